"""A team on a floor nobody gave it: what it knows, where it stands, what may be contaminated.

All that is decided rests on the survey. What lies beyond its frontiers is one contaminated region
(`shadow_moves`). A shadow that is clear reaches no frontier, so it is a shadow of the whole floor
too, and a larger survey has it again, by its measures; all others are contaminated. A drive is
judged after it was made, with what was seen at its end, where less of the floor is unknown.
"""

from itertools import pairwise
from typing import Any

import numpy as np
import shapely

from conav.pursuit.beliefs import hidden_now, shadow_polygons
from conav.pursuit.known_map import KnownMapSearch
from conav.pursuit.navigation_graph import surveyed_navigation_graph
from conav.pursuit.roadmap import Roadmap
from conav.pursuit.sensor import Point, Sensor
from conav.pursuit.shadow_moves import ShadowMoves, Shadows
from conav.pursuit.survey import begin_survey
from conav.pursuit.types import HiddenRegion, Pursuer, Schedule

SAME = 1e-7  # relative: two rounded measures of one shadow differ by less


class UnknownFloorTeam:
    """Pursuers that look, drive and are joined by others; one drives at a time."""

    def __init__(self, sensor: Sensor, pursuers: tuple[Pursuer, ...]) -> None:
        self._sensor = sensor
        self.pursuers = list(pursuers)
        self.team = [_place(one) for one in pursuers]
        survey = begin_survey(sensor.look(self.team[0]))
        for place in self.team[1:]:
            survey = survey.add(sensor.look(place))
        self.survey = survey
        self.search = self._new_search()
        self.dirty = (1 << self._shadows().count) - 1
        self.beliefs: dict[int, tuple[HiddenRegion, ...]] = {}
        self.history: list[dict[str, Any]] = []
        self.recontaminations = 0
        self.distance_m = 0.0
        self._times = [0.0]
        self._rows = [list(self.team)]
        regions = hidden_now(self.search.shadows, tuple(self.team), self.dirty)
        self._contaminated = _contaminated(regions)

    @property
    def legs(self) -> int:
        """How many drives were made, and looks without one."""
        return len(self._times) - 1

    @property
    def drives(self) -> int:
        """Legs in which somebody moved."""
        return sum(a != b for a, b in pairwise(self._times))

    @property
    def done(self) -> bool:
        """Whether nothing is unexplored and nothing contaminated."""
        return self.survey.complete and self.dirty == 0

    def numbers(self) -> list[int]:
        """Where the team stands, as places of the navigation graph."""
        return [self.search.roadmap.points.index(place) for place in self.team]

    def note(self, what: str, **more: Any) -> None:
        """Enter something into the history."""
        self.history.append({"leg": self.legs, "what": what, **more})

    def drive(self, i: int, to: Point) -> None:
        """Pursuer i drives straight to a place of the known region that it sees, and looks."""
        start, team = self.team[i], tuple(self.team)
        known_before = self.survey.known.polygon
        survey = self.survey.add(self._sensor.look(to))
        if survey is not self.survey:
            old = self.search.shadows
            self.survey = survey
            self.search = self._new_search()
            self.dirty = carried_over(old, self.search.shadows, team, self.dirty)
        others = (*team[:i], *team[i + 1 :])
        self.dirty = self.search.shadows.after(others, start, to, self.dirty)
        self.team[i] = to
        length = float(np.sqrt((to[0] - start[0]) ** 2 + (to[1] - start[1]) ** 2))
        self.distance_m += length
        self._times.append(self._times[-1] + length / self.pursuers[i].speed_mps)
        self._rows.append(list(self.team))
        before = self._contaminated
        regions = hidden_now(self.search.shadows, tuple(self.team), self.dirty)
        self.beliefs[self.legs - 1] = regions
        self._contaminated = _contaminated(regions)
        again = shapely.difference(shapely.intersection(self._contaminated, known_before), before)
        if shapely.area(again) > 1e-6 * self.survey.known.area:
            self.recontaminations += 1

    def stand(self) -> None:
        """Everybody looks where it stands, in no time: a leg for those who never drive."""
        self._times.append(self._times[-1])
        self._rows.append(list(self.team))
        self.beliefs[self.legs - 1] = hidden_now(self.search.shadows, tuple(self.team), self.dirty)

    def enter(self, newcomer: Pursuer) -> None:
        """One more pursuer comes in, at a place that was visited, and looks."""
        place = _place(newcomer)
        assert place in self.survey.visited, "newcomers enter where somebody looked before"
        self.dirty = self.dirty_with(place)
        self.pursuers.append(newcomer)
        self.team.append(place)
        regions = hidden_now(self.search.shadows, tuple(self.team), self.dirty)
        self._contaminated = _contaminated(regions)
        self.note("enters", pursuer=newcomer.name)

    def dirty_with(self, *newcomers: Point) -> int:
        """What is contaminated when pursuers come in at these places."""
        team, dirty = tuple(self.team), self.dirty
        for place in newcomers:
            dirty = self.search.shadows.joined_by(team, place, dirty)
            team = (*team, place)
        return dirty

    def schedule(self) -> Schedule:
        """What was driven up to now. Whoever came in later waits at its start, unseeing."""
        n = len(self.pursuers)
        starts = [_place(one) for one in self.pursuers]
        positions = np.array([[*row, *starts[len(row) :]] for row in self._rows])
        counts = np.array([len(row) for row in self._rows[1:]], dtype=np.int64)
        active = np.arange(n)[None, :] < counts[:, None]
        return Schedule(np.array(self._times), positions, active.reshape(-1, n))

    def use(self, search: KnownMapSearch) -> None:
        """Go on with another roadmap of the same known region."""
        self.dirty = carried_over(self.search.shadows, search.shadows, tuple(self.team), self.dirty)
        self.search = search

    def _new_search(self) -> KnownMapSearch:
        self.graph = surveyed_navigation_graph(self.survey, (_place(self.pursuers[0]), *self.team))
        frontiers = None if self.survey.complete else self.survey.frontiers
        roadmap = Roadmap(self.graph.points, self.graph.joined, self.graph.lengths)
        return KnownMapSearch(ShadowMoves(self.survey.mesh, frontiers=frontiers), roadmap)

    def _shadows(self) -> Shadows:
        return self.search.shadows.shadows(tuple(self.team))


def carried_over(old: ShadowMoves, new: ShadowMoves, team: tuple[Point, ...], dirty: int) -> int:
    """What is contaminated when more of the floor is known, while the team stands.

    A shadow stays clear when it was clear, and it is the same still; see above.
    """
    after = new.shadows(team)
    clear = [
        polygon
        for number, polygon in enumerate(shadow_polygons(old, team))
        if not dirty >> number & 1
    ]
    result = (1 << after.count) - 1
    if clear:
        for number, polygon in enumerate(shadow_polygons(new, team)):
            if not after.exposed >> number & 1 and any(_same(polygon, one) for one in clear):
                result &= ~(1 << number)
    return result


def _same(one: shapely.Geometry, other: shapely.Geometry) -> bool:
    """Whether two shadows are one, but for rounding: by area, middle and bounding box."""
    measures = [
        np.array([shapely.area(shape), *middle, *shapely.bounds(shape).tolist()])
        for shape in (one, other)
        for middle in shapely.get_coordinates(shapely.centroid(shape)).tolist()
        if shapely.area(shape) > 0.0
    ]
    if len(measures) < 2:
        return False
    return bool(np.abs(measures[0] - measures[1]).max() <= SAME * np.abs(measures[0]).max())


def _place(pursuer: Pursuer) -> Point:
    x, y = pursuer.start
    return float(x), float(y)


def _contaminated(regions: tuple[HiddenRegion, ...]) -> shapely.Geometry:
    """The union of the regions that are not clear."""
    parts = [shapely.Polygon(one.outer, one.holes) for one in regions if not one.clear]
    return shapely.union_all([shapely.make_valid(part) for part in parts])
