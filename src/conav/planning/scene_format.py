"""What a scene file says, as types: they read it, and its JSON schema is made from them.

pydantic reads these dataclasses; a key that none of them has is an error. Lengths are in metres,
times in seconds, angles in radians, counter-clockwise from the x axis.
"""

import json
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field, TypeAdapter

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Name = Annotated[str, Field(min_length=1)]
Point = tuple[float, float]
Points = Annotated[tuple[Point, ...], Field(min_length=3)]
Disc = tuple[float, float, Positive]
Box = tuple[float, float, float, float]
Motion = Literal["single-integrator", "double-integrator", "dubins-car"]
AfterArrival = Literal["stay", "vanish"]
CouplingKind = Literal["meet", "not-before", "near"]
Cost = Literal["length", "duration"]

_CONFIG = ConfigDict(extra="forbid", allow_inf_nan=False)


@dataclass(frozen=True)
class Shape:
    """A disc, a box along the axes, or a polygon: exactly one of them."""

    __pydantic_config__: ClassVar[ConfigDict] = _CONFIG

    disc: Annotated[Disc | None, Field(description="x, y, radius [m]")] = None
    box: Annotated[Box | None, Field(description="x0, y0, x1, y1 [m], opposite corners")] = None
    polygon: Annotated[Points | None, Field(description="corners [m], in either direction")] = None

    def __post_init__(self) -> None:
        if (self.disc, self.box, self.polygon).count(None) != 2:
            raise ValueError("needs exactly one of disc, box and polygon")


@dataclass(frozen=True)
class FloorEntry:
    """Where robots may be: a map, or an outline with holes."""

    __pydantic_config__: ClassVar[ConfigDict] = _CONFIG

    map: Annotated[
        Name | None, Field(description="a map file, as seen from the scene file, or a built-in map")
    ] = None
    resolution: Annotated[
        Positive | None, Field(description="metres per cell, for maps without a scale")
    ] = None
    size: Annotated[
        tuple[Positive, Positive] | None, Field(description="width and height of a built-in map")
    ] = None
    seed: Annotated[int | None, Field(ge=0, description="layout of a built-in map")] = None
    box: Annotated[Box | None, Field(description="x0, y0, x1, y1 [m], opposite corners")] = None
    outline: Annotated[Points | None, Field(description="corners [m], in either direction")] = None
    holes: Annotated[tuple[Points, ...], Field(description="rings in which nobody may be")] = ()
    name: Name | None = None

    def __post_init__(self) -> None:
        if (self.map, self.box, self.outline).count(None) != 2:
            raise ValueError("needs exactly one of map, box and outline")
        of_map = {"resolution": self.resolution, "size": self.size, "seed": self.seed}
        for key, value in of_map.items():
            if self.map is None and value is not None:
                raise ValueError(f"{key} is for a map, and there is none")
        if self.map is not None and (self.holes or self.name):
            raise ValueError(f"{'holes' if self.holes else 'name'} is for a box or an outline")


@dataclass(frozen=True)
class RobotDefaults:
    """What robots have unless they say otherwise."""

    __pydantic_config__: ClassVar[ConfigDict] = _CONFIG

    task: Annotated[Name | None, Field(description="a formula over the names of regions")] = None
    radius_m: Positive | None = None
    speed_mps: Annotated[Positive | None, Field(description="top speed")] = None
    acceleration_mps2: Annotated[
        Positive | None, Field(description="of a double integrator: the greatest")
    ] = None
    turning_radius_m: Annotated[
        Positive | None, Field(description="of a Dubins car: the tightest turn")
    ] = None
    motion: Motion | None = None
    after_arrival: Annotated[
        AfterArrival | None, Field(description="stay in everybody's way, or vanish")
    ] = None


@dataclass(frozen=True)
class RobotEntry(RobotDefaults):
    """A robot; what it leaves out it has from the defaults."""

    start: Annotated[
        tuple[float, ...],
        Field(
            min_length=2,
            max_length=4,
            description="x, y; of a double integrator also vx, vy (else 0, 0); of a Dubins car "
            "also the heading (else 0)",
        ),
    ] = field(kw_only=True)
    name: Annotated[Name | None, Field(description="robot_0, robot_1, ... unless given")] = None
    goal: Annotated[
        Disc | None,
        Field(description="x, y, radius [m]: short for a region goal and the task F goal"),
    ] = None
    regions: Annotated[
        dict[Name, Shape], Field(description="of this robot alone; they hide those of the scene")
    ] = field(default_factory=dict)


@dataclass(frozen=True)
class CouplingEntry:
    """A task of two robots together."""

    __pydantic_config__: ClassVar[ConfigDict] = _CONFIG

    kind: CouplingKind
    robots: Annotated[
        tuple[Name, Name], Field(description="names; of not-before the later one first")
    ]
    region: Annotated[
        Name | Shape | None, Field(description="of meet and not-before: where; a name or a shape")
    ] = None
    other_region: Annotated[
        Name | Shape | None,
        Field(description="of not-before: where the second robot must have been, else region"),
    ] = None
    within_m: Annotated[
        Positive | None, Field(description="of meet and near: the distance of centres")
    ] = None

    def __post_init__(self) -> None:
        keys = {
            "region": self.region,
            "other_region": self.other_region,
            "within_m": self.within_m,
        }
        needed = {"meet": ("region", "within_m"), "not-before": ("region",), "near": ("within_m",)}
        allowed = {**needed, "not-before": ("region", "other_region")}
        for key, value in keys.items():
            if value is None and key in needed[self.kind]:
                raise ValueError(f"{self.kind} needs {key}")
            if value is not None and key not in allowed[self.kind]:
                raise ValueError(f"{self.kind} has no {key}")
        if self.robots[0] == self.robots[1]:
            raise ValueError("robots must be two different ones")


@dataclass(frozen=True)
class SceneFile:
    """A scene: robots with tasks of their own on one floor."""

    __pydantic_config__: ClassVar[ConfigDict] = _CONFIG

    floor: FloorEntry
    robots: Annotated[tuple[RobotEntry, ...], Field(min_length=1)]
    horizon_s: Annotated[Positive, Field(description="everybody has arrived by then")]
    name: Annotated[Name | None, Field(description="the file's name unless given")] = None
    margin_m: Annotated[NotNegative, Field(description="kept between robots beyond radii")] = 0.0
    costs: Annotated[
        tuple[Cost, ...], Field(min_length=1, description="what each robot wants little of")
    ] = ("length",)
    walls: Annotated[tuple[Shape, ...], Field(description="taken out of the floor")] = ()
    regions: Annotated[
        dict[Name, Shape], Field(description="known to every robot whose task names them")
    ] = field(default_factory=dict)
    defaults: RobotDefaults = field(default_factory=RobotDefaults)
    couplings: Annotated[
        tuple[CouplingEntry, ...], Field(description="tasks of two robots together")
    ] = ()


SCENE = TypeAdapter(SceneFile)


def scene_schema() -> dict[str, Any]:
    """The JSON schema of scene files (draft 2020-12)."""
    schema = SCENE.json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def scene_schema_text() -> str:
    """`scene_schema` as the text that is published with the package."""
    return json.dumps(scene_schema(), indent=2) + "\n"
