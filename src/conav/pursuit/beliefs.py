"""What a team that follows a schedule may take for clear, for the run file and for pictures."""

import numpy as np
import shapely

from conav.geometry.view_cells import cell_border, view_cells
from conav.geometry.view_cells import shadows as shadows_of
from conav.pursuit.joint_drives import JointDrives
from conav.pursuit.shadow_moves import Point, ShadowMoves
from conav.pursuit.types import HiddenRegion, Schedule


def beliefs_of(shadows: ShadowMoves, schedule: Schedule) -> dict[int, tuple[HiddenRegion, ...]]:
    """All that is hidden after each leg of a schedule, in which everybody sees all the time."""
    joint = JointDrives(shadows)
    beliefs: dict[int, tuple[HiddenRegion, ...]] = {}
    team = _points(schedule, 0)
    dirty = (1 << shadows.shadows(team).count) - 1
    for leg in range(len(schedule.active)):
        after = _points(schedule, leg + 1)
        moved = [i for i in range(len(team)) if team[i] != after[i]]
        if moved:
            others = shadows.team([at for i, at in enumerate(team) if i not in moved])
            drives = tuple((shadows.number(team[i]), shadows.number(after[i])) for i in moved)
            dirty = joint.after(others, drives, dirty)
        team = after
        beliefs[leg] = hidden_now(shadows, team, dirty)
    return beliefs


def hidden_now(
    shadows: ShadowMoves, team: tuple[Point, ...], dirty: int
) -> tuple[HiddenRegion, ...]:
    """The shadows of a team as polygons, and whether each is clear; `dirty` as in `after`."""
    regions: list[HiddenRegion] = []
    for number, whole in enumerate(shadow_polygons(shadows, team)):
        for part in shapely.get_parts(whole):
            if isinstance(part, shapely.Polygon) and part.area > 0.0:
                outer = shapely.get_coordinates(part.exterior)[:-1]
                holes = tuple(shapely.get_coordinates(hole)[:-1] for hole in part.interiors)
                regions.append(HiddenRegion(outer, holes, clear=not dirty >> number & 1))
    return tuple(regions)


def shadow_polygons(shadows: ShadowMoves, team: tuple[Point, ...]) -> list[shapely.Geometry]:
    """The shadows of a team by number, what is known of them; rounded."""
    cells = view_cells(shadows.floor, [shadows.view(point) for point in sorted(set(team))])
    labels = shadows_of(cells)
    return [
        shapely.union_all(
            [
                shapely.make_valid(shapely.Polygon(cell_border(shadows.floor, cells, cell)))
                for cell in np.flatnonzero(labels == number).tolist()
            ]
        )
        for number in range(int(labels.max()) + 1)
    ]


def _points(schedule: Schedule, moment: int) -> tuple[Point, ...]:
    return tuple((x, y) for x, y in schedule.positions[moment].tolist())
