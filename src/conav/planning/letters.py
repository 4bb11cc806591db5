"""Which labels can occur, and the automaton of a task over them."""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from conav.errors import InputError
from conav.planning.types import PlanningRobot, Region
from conav.tasks.automaton import Automaton
from conav.tasks.parse import parse_formula
from conav.tasks.translate import automaton_of

MAX_LETTERS = 4096


@dataclass(frozen=True, eq=False)
class Task:
    """A robot's task as an automaton over the labels that occur.

    Bit i of a label stands for `regions[i]`; those the formula does not name are left out.
    `masks[k]`, shape (letters,), is the label of the automaton's letter k.
    """

    regions: tuple[Region, ...]
    masks: NDArray[np.int64]
    automaton: Automaton


def task_of(robot: PlanningRobot, reachable: Collection[str] | None = None) -> Task:
    """The robot's task; with `reachable` only those of its regions can be entered.

    Raises `InputError` for a formula that cannot be read and for too many letters.
    """
    formula = parse_formula(robot.task, regions=tuple(robot.regions))
    names = sorted(formula.names, key=lambda name: (robot.regions[name].disc is None, name))
    regions = tuple(robot.regions[name] for name in names)  # in the order of bits
    open_ones = [reachable is None or name in reachable for name in names]
    masks = occurring_labels(regions, open_ones)
    by_letter = {
        frozenset(name for bit, name in enumerate(names) if mask >> bit & 1): mask for mask in masks
    }
    automaton = automaton_of(formula, by_letter)
    ordered = np.array([by_letter[letter] for letter in automaton.letters], dtype=np.int64)
    return Task(regions, ordered, automaton)


def occurring_labels(regions: Sequence[Region], allowed: Sequence[bool]) -> list[int]:
    """Every label that occurs somewhere in the plane, and maybe some that do not, sorted.

    Regions of a label meet pairwise, and one that lies in another is never without it. That three
    meet pairwise and not at one place is not looked into.
    """
    count = len(regions)
    meets = [0] * count
    inside = [0] * count
    for i in range(count):
        for j in range(count):
            if i != j and _meet(regions[i], regions[j]):
                meets[i] |= 1 << j
                if _contains(regions[j], regions[i]):
                    inside[i] |= 1 << j
    found = [0]
    for bit in range(count):
        if allowed[bit]:
            found += [mask | 1 << bit for mask in found if mask & ~meets[bit] == 0]
        if len(found) > MAX_LETTERS * 16:
            raise InputError("regions", "too many overlap each other", "name fewer in the task")
    kept = [
        mask
        for mask in found
        if all(inside[bit] & ~mask == 0 for bit in range(count) if mask >> bit & 1)
    ]
    if len(kept) > MAX_LETTERS:
        raise InputError("regions", "too many overlap each other", "name fewer in the task")
    return sorted(kept)


def region_distance(a: Region, b: Region) -> float:
    """The distance [m] between two regions, 0 where they meet."""
    if a.disc is not None and b.disc is not None:
        return max(0.0, math.dist(a.disc[:2], b.disc[:2]) - a.disc[2] - b.disc[2])
    if a.disc is not None:
        return max(0.0, shapely.Point(a.disc[:2]).distance(_polygon(b)) - a.disc[2])
    if b.disc is not None:
        return region_distance(b, a)
    return float(_polygon(a).distance(_polygon(b)))


def point_distance(x: float, y: float, region: Region) -> float:
    """The distance [m] from a place to a region."""
    return region_distance(Region("", disc=(x, y, 0.0)), region)


def _meet(a: Region, b: Region) -> bool:
    return region_distance(a, b) <= 1e-9


def _contains(outer: Region, inner: Region) -> bool:
    """Whether the inner region lies in the outer one."""
    if outer.disc is not None:
        x, y, radius = outer.disc
        if inner.disc is not None:
            return math.dist((x, y), inner.disc[:2]) + inner.disc[2] <= radius
        assert inner.polygon is not None
        return all(math.dist((x, y), point) <= radius for point in inner.polygon.tolist())
    if inner.disc is not None:
        at = shapely.Point(inner.disc[:2])
        whole = _polygon(outer)
        return bool(whole.covers(at)) and at.distance(whole.exterior) >= inner.disc[2]
    return bool(_polygon(outer).covers(_polygon(inner)))


def _polygon(region: Region) -> shapely.Polygon:
    assert region.polygon is not None
    return shapely.Polygon(region.polygon)
