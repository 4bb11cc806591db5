"""Where to look from into the last pockets, against every place tried one by one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import conav
from conav.exploration.belief import Belief, new_scratch
from conav.exploration.viewpoints import (
    beside_frontier,
    nearest_viewpoint,
    unknown_beside_frontier,
)
from conav.geometry.grid_search import SearchSpace, search
from conav.geometry.sight import segment_is_clear
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import UNKNOWN, OccupancyGrid
from conav.maps.planning_grid import PlanningGrid, planning_grid
from conav.robots.sensor import Sensor


def search_from(belief: Belief, start: int) -> SearchSpace:
    """A search over everything known to be reachable."""
    space = SearchSpace(belief.moves.size)
    nothing = np.zeros(belief.moves.shape, np.uint8)
    search(belief.moves, start, nothing, 1, space)
    return space


def distances(space: SearchSpace) -> np.ndarray:
    """Path lengths of the last search, inf where it did not come."""
    return np.where(space.stamp[:-1] == space.stamp[-1], space.distance, np.inf)


def hidden_beside_frontier(belief: Belief) -> list[tuple[int, int]]:
    rows, cols = belief.cells.shape
    found = []
    for r, c in np.argwhere(belief.cells == UNKNOWN):
        around = [(r, c + 1), (r, c - 1), (r + 1, c), (r - 1, c)]
        if any(0 <= r2 < rows and 0 <= c2 < cols and belief.frontier[r2, c2] for r2, c2 in around):
            found.append((int(r), int(c)))
    return found


def viewpoint_by_definition(
    plan: PlanningGrid, belief: Belief, sensor: Sensor, space: SearchSpace
) -> tuple[int, int]:
    """Each reached place not scanned from, with each hidden cell."""
    lattice = plan.lattice
    square = (sensor.range_m / lattice.resolution) ** 2
    best: tuple[float, int, int] | None = None
    for r, c in hidden_beside_frontier(belief):
        for cell in np.flatnonzero(space.stamp[:-1] == space.stamp[-1]):
            row, col = divmod(int(cell), lattice.cols)
            if belief.stood[row, col]:
                continue
            r2, c2 = int(lattice.fine_row[row]), int(lattice.fine_col[col])
            if (r - r2) ** 2 + (c - c2) ** 2 > square:
                continue
            if sensor.occlusion and not segment_is_clear(belief.cells, r, c, r2, c2):
                continue
            found = (float(space.distance[cell]), int(cell), r * plan.walls.shape[1] + c)
            best = found if best is None else min(best, found)
    return (-1, -1) if best is None else best[1:]


def explored(
    rng: np.random.Generator, ratio: float, radius: float, share: float
) -> tuple[PlanningGrid, Belief, int] | None:
    """A map known in part, and a robot's place on it."""
    rows, cols = (int(rng.integers(3, 11)) for _ in range(2))
    cells = (rng.random((rows, cols)) < 0.2).astype(np.uint8)
    plan = planning_grid(OccupancyGrid(cells, 1.0), cell_m=ratio, radius_m=radius)
    places = np.flatnonzero(plan.standable)
    if len(places) == 0:
        return None
    belief = Belief(plan)
    seen = np.flatnonzero(rng.random(cells.size) < share).astype(np.int32)
    for place in rng.choice(places, 3):
        belief.hear(plan, int(place), seen, new_scratch(plan))
    return plan, belief, int(place)  # where the robot is it has looked


@settings(max_examples=120, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([(1.0, 0.1), (1.0, 0.6), (1.7, 0.3), (3.0, 0.75)]),
    st.sampled_from([0.5, 0.8, 0.95]),
    st.booleans(),
    st.sampled_from([1.0, 2.5, 30.0]),
)
def test_the_nearest_viewpoint_is_the_nearest(
    seed: int, body: tuple[float, float], share: float, occlusion: bool, reach: float
) -> None:
    given_ = explored(np.random.default_rng(seed), *body, share)
    if given_ is None:
        return
    plan, belief, robot = given_
    sensor = Sensor("any", occlusion, reach)
    space = search_from(belief, robot)
    expected = viewpoint_by_definition(plan, belief, sensor, space)
    assert nearest_viewpoint(belief, plan.lattice, sensor, distances(space)) == expected
    cols = belief.cells.shape[1]
    hidden = [r * cols + c for r, c in hidden_beside_frontier(belief)]
    assert unknown_beside_frontier(belief).tolist() == hidden


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([(0.5, 0.1), (0.5, 0.4), (0.3, 0.2)]))
def test_the_nearest_viewpoint_among_several_in_one_fine_cell(
    seed: int, body: tuple[float, float]
) -> None:
    given_ = explored(np.random.default_rng(seed), *body, 0.9)
    if given_ is None:
        return
    plan, belief, robot = given_
    sensor = Sensor("any", True, 5.0)
    space = search_from(belief, robot)
    expected = viewpoint_by_definition(plan, belief, sensor, space)
    assert nearest_viewpoint(belief, plan.lattice, sensor, distances(space)) == expected


@settings(max_examples=80, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([(1.0, 0.1), (1.0, 0.6), (2.0, 0.9), (3.0, 1.4)]),
    st.sampled_from([1.5, 4.0]),
)
def test_hopeless_cells_are_never_given_up_too_early(
    seed: int, body: tuple[float, float], reach: float
) -> None:
    """What a belief keeps over a whole exploration does not change the answers."""
    rng = np.random.default_rng(seed)
    rows, cols = (int(rng.integers(3, 12)) for _ in range(2))
    cells = (rng.random((rows, cols)) < 0.15).astype(np.uint8)
    plan = planning_grid(OccupancyGrid(cells, 1.0), cell_m=body[0], radius_m=body[1])
    places = np.flatnonzero(plan.standable)
    if len(places) == 0:
        return
    robot = int(rng.choice(places))
    belief = Belief(plan)
    scratch = new_scratch(plan)
    sensor = Sensor("any", True, reach)
    belief.hear(plan, robot, np.empty(0, np.int32), scratch)
    for _ in range(12):
        shown = np.flatnonzero(rng.random(cells.size) < 0.2).astype(np.int32)
        belief.hear(plan, int(rng.choice(places)), shown, scratch)
        space = search_from(belief, robot)
        got = nearest_viewpoint(belief, plan.lattice, sensor, distances(space))
        assert got == viewpoint_by_definition(plan, belief, sensor, space)


def test_a_way_that_opens_without_a_new_place_brings_hope_back() -> None:
    """Two places known before the move between them is: the disc just fits past one corner."""
    plan = planning_grid(
        parse_ascii("." * 9 + "\n" + "." * 9 + "\n" + "." * 9), cell_m=3.0, radius_m=1.4
    )
    assert plan.standable.tolist() == [[1, 1, 1]]
    last = 8  # the lower right corner, far from every disc
    corners = [2, 3, 20, 21]  # under the sweep from the first place to the second, under no disc
    belief = Belief(plan)
    scratch = new_scratch(plan)
    some = np.array([i for i in range(27) if i not in (last, *corners)], np.int32)
    belief.hear(plan, 0, some, scratch)
    assert belief.opened == 3
    sensor = Sensor("any", True, 4.0)

    def look_for(robot: int) -> tuple[int, int]:
        space = search_from(belief, robot)
        got = nearest_viewpoint(belief, plan.lattice, sensor, distances(space))
        assert got == viewpoint_by_definition(plan, belief, sensor, space)
        return got

    look_for(0)
    belief.hear(plan, 0, np.array(corners, np.int32), scratch)
    assert belief.opened == 3
    assert look_for(0) == (2, last)


def test_by_hand() -> None:
    # The robot cannot enter the niche at the top; its mouth, (2, 3), is as near as it gets.
    picture = "###.###\n###.###\n.......\n.......\n......."
    plan = planning_grid(parse_ascii(picture), cell_m=1.0, radius_m=0.6)
    assert np.argwhere(plan.standable).tolist() == [*([1, c] for c in range(1, 6)), [2, 3]]
    niche = [3 * 7 + 3, 4 * 7 + 3]
    seen = [i for i in range(35) if i not in niche]
    belief = Belief(plan)
    belief.hear(plan, 1 * 7 + 1, np.array(seen, np.int32), new_scratch(plan))
    space = search_from(belief, 1 * 7 + 1)

    def look(reach: float) -> tuple[int, int]:
        sensor = Sensor("range", True, reach)
        return nearest_viewpoint(belief, plan.lattice, sensor, distances(space))

    # The lower cell of the niche is seen from the place beside straight below, too.
    assert look(9.0) == (1 * 7 + 2, niche[0])
    assert look(2.0) == (1 * 7 + 3, niche[0])
    assert look(1.0) == (2 * 7 + 3, niche[0])
    assert look(0.9) == (-1, -1)


def test_nothing_hidden_nothing_found() -> None:
    plan = planning_grid(parse_ascii("....\n...."))
    belief = Belief(plan)
    belief.hear(plan, 0, np.arange(8, dtype=np.int32), new_scratch(plan))
    space = search_from(belief, 0)
    sensor = Sensor("range", True, 9.0)
    assert nearest_viewpoint(belief, plan.lattice, sensor, distances(space)) == (-1, -1)


def test_beside_frontier_by_hand() -> None:
    plan = planning_grid(parse_ascii("......"))
    belief = Belief(plan)
    belief.hear(plan, 2, np.array([0, 1, 2, 3], np.int32), new_scratch(plan))
    assert belief.frontier.tolist() == [[0, 0, 0, 1, 0, 0]]
    # Not from cell 2, which was scanned from.
    assert beside_frontier(belief).tolist() == [[0, 0, 0, 1, 1, 0]]
    with pytest.raises(ValueError, match="read-only"):
        beside_frontier(belief)[0, 0] = 1


@pytest.mark.parametrize("cell", [0.5, 0.4, 0.2])
def test_a_team_on_small_planning_cells_sees_everything(cell: float) -> None:
    room = parse_ascii("########\n#......#\n#......#\n#...#..#\n########")
    done = conav.explore(room, robots=1, cell_m=cell, radius_m=0.1, range_m=2.5, seed=1)
    assert (done.status, done.metrics.coverage) == ("done", 1.0)
