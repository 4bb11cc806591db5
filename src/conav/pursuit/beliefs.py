"""What a team that follows a schedule may take for clear, for the run file and for pictures."""

import shapely

from conav.geometry.view_cells import cell_border
from conav.pursuit.shadow_moves import Point, ShadowMoves, apply
from conav.pursuit.types import HiddenRegion, Schedule


def beliefs_of(shadows: ShadowMoves, schedule: Schedule) -> dict[int, tuple[HiddenRegion, ...]]:
    """All that is hidden after each leg of a schedule, in which one pursuer drives at a time."""
    beliefs: dict[int, tuple[HiddenRegion, ...]] = {}
    team = _points(schedule, 0)
    dirty = (1 << shadows.shadows(team).count) - 1
    for leg in range(len(schedule.active)):
        after = _points(schedule, leg + 1)
        moved = [i for i in range(len(team)) if team[i] != after[i]]
        for i in moved:  # one at most
            others = (*team[:i], *team[i + 1 :])
            dirty = apply(shadows.move(others, team[i], after[i]), dirty)
        team = after
        beliefs[leg] = hidden_now(shadows, team, dirty)
    return beliefs


def hidden_now(
    shadows: ShadowMoves, team: tuple[Point, ...], dirty: int
) -> tuple[HiddenRegion, ...]:
    """The shadows of a team as polygons, and whether each is clear; `dirty` as in `apply`."""
    cells, numbers = shadows.hidden(team)
    groups: dict[tuple[int, ...], list[int]] = {}
    for cell, of_cell in enumerate(numbers):
        if of_cell:
            groups.setdefault(tuple(of_cell), []).append(cell)
    regions: list[HiddenRegion] = []
    for of_group, members in groups.items():
        clear = not any(dirty >> number & 1 for number in of_group)
        parts = [
            shapely.make_valid(shapely.Polygon(cell_border(shadows.floor, cells, cell)))
            for cell in members
        ]
        whole = shapely.union_all(parts)
        for part in shapely.get_parts(whole):
            if isinstance(part, shapely.Polygon) and part.area > 0.0:
                outer = shapely.get_coordinates(part.exterior)[:-1]
                holes = tuple(shapely.get_coordinates(hole)[:-1] for hole in part.interiors)
                regions.append(HiddenRegion(outer, holes, clear))
    return tuple(regions)


def _points(schedule: Schedule, moment: int) -> tuple[Point, ...]:
    return tuple((x, y) for x, y in schedule.positions[moment].tolist())
