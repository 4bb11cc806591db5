"""Multi-robot coordination in unknown 2-D environments: explore, plan, pursue.

    >>> import conav
    >>> found = conav.explore("maze", robots=2, seed=1)
    >>> str(found.status), found.metrics.coverage
    ('done', 1.0)

Importing conav imports nothing else; each name below is loaded when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from conav.errors import InputError
    from conav.exploration.verify import verify_exploration
    from conav.maps.builtin.catalogue import builtin_map
    from conav.maps.load_floor_plan import load_floor_plan
    from conav.maps.occupancy_grid import OccupancyGrid
    from conav.maps.polygon_map import PolygonMap
    from conav.maps.polygonise import polygonise
    from conav.maps.read_floor_plan import read_floor_plan
    from conav.maps.read_map import read_map
    from conav.maps.ros_map_server import write_ros_map
    from conav.maps.write_floor_plan import write_floor_plan
    from conav.pictures.animation import save_animation
    from conav.pictures.floor_plan import save_floor_plan
    from conav.pictures.plan_animation import save_plan_animation
    from conav.pictures.plan_picture import save_plan_picture
    from conav.pictures.still import save_still
    from conav.planning.load_scene import load_scene
    from conav.planning.plan import plan
    from conav.planning.scene_writer import write_scene
    from conav.planning.types import PlanningProblem, PlanningResult, PlanningRobot, Region
    from conav.planning.verify import verify_plan
    from conav.pursuit.verify import verify_pursuit
    from conav.runs.reader import (
        read_exploration,
        read_plan,
        read_pursuit,
        read_run,
        repair_run,
    )
    from conav.simulation.execution import Execution, execute
    from conav.simulation.explore import Exploration, explore
    from conav.status import Status

_PUBLIC = {
    "Execution": "conav.simulation.execution",
    "Exploration": "conav.simulation.explore",
    "InputError": "conav.errors",
    "OccupancyGrid": "conav.maps.occupancy_grid",
    "PlanningProblem": "conav.planning.types",
    "PlanningResult": "conav.planning.types",
    "PlanningRobot": "conav.planning.types",
    "PolygonMap": "conav.maps.polygon_map",
    "Region": "conav.planning.types",
    "Status": "conav.status",
    "builtin_map": "conav.maps.builtin.catalogue",
    "execute": "conav.simulation.execution",
    "explore": "conav.simulation.explore",
    "load_floor_plan": "conav.maps.load_floor_plan",
    "load_scene": "conav.planning.load_scene",
    "plan": "conav.planning.plan",
    "polygonise": "conav.maps.polygonise",
    "read_exploration": "conav.runs.reader",
    "read_floor_plan": "conav.maps.read_floor_plan",
    "read_map": "conav.maps.read_map",
    "read_plan": "conav.runs.reader",
    "read_pursuit": "conav.runs.reader",
    "read_run": "conav.runs.reader",
    "repair_run": "conav.runs.reader",
    "save_animation": "conav.pictures.animation",
    "save_floor_plan": "conav.pictures.floor_plan",
    "save_plan_animation": "conav.pictures.plan_animation",
    "save_plan_picture": "conav.pictures.plan_picture",
    "save_still": "conav.pictures.still",
    "verify_exploration": "conav.exploration.verify",
    "verify_plan": "conav.planning.verify",
    "verify_pursuit": "conav.pursuit.verify",
    "write_floor_plan": "conav.maps.write_floor_plan",
    "write_ros_map": "conav.maps.ros_map_server",
    "write_scene": "conav.planning.scene_writer",
}

__version__ = "0.1.0"

__all__ = [
    "Execution",
    "Exploration",
    "InputError",
    "OccupancyGrid",
    "PlanningProblem",
    "PlanningResult",
    "PlanningRobot",
    "PolygonMap",
    "Region",
    "Status",
    "__version__",
    "builtin_map",
    "execute",
    "explore",
    "load_floor_plan",
    "load_scene",
    "plan",
    "polygonise",
    "read_exploration",
    "read_floor_plan",
    "read_map",
    "read_plan",
    "read_pursuit",
    "read_run",
    "repair_run",
    "save_animation",
    "save_floor_plan",
    "save_plan_animation",
    "save_plan_picture",
    "save_still",
    "verify_exploration",
    "verify_plan",
    "verify_pursuit",
    "write_floor_plan",
    "write_ros_map",
    "write_scene",
]


def __getattr__(name: str) -> Any:
    if name in _PUBLIC:
        value = getattr(import_module(_PUBLIC[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'conav' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
