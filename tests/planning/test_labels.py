"""Labels of places and words of straight lines."""

import numpy as np
import pytest
import shapely

from conav.errors import InputError
from conav.planning.labels import (
    MAX_EVENTS,
    UNCLEAR,
    build_regions,
    in_order_of_bits,
    on_border,
    point_label,
    segment_word,
)
from conav.planning.letters import occurring_labels, region_distance
from conav.planning.types import Region

SQUARE = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])


def word_of(regions, ax, ay, bx, by):
    arrays = build_regions(regions)
    word = np.empty(3 * MAX_EVENTS, np.int64)
    first = point_label(*arrays, ax, ay)
    last = point_label(*arrays, bx, by)
    count = segment_word(*arrays, ax, ay, bx, by, first, last, np.empty(MAX_EVENTS), word)
    return None if count == UNCLEAR else [first, *word[:count].tolist()]


def test_the_border_belongs_to_the_region() -> None:
    arrays = build_regions([Region("d", disc=(5, 5, 1)), Region("p", polygon=SQUARE)])
    assert point_label(*arrays, 6.0, 5.0) == 1
    assert point_label(*arrays, 2.0, 1.0) == 2
    assert point_label(*arrays, 2.0 + 1e-9, 1.0) == 0
    assert on_border(*arrays, 2.0 + 1e-10, 1.0)
    assert on_border(*arrays, 5.0, 4.0 - 1e-10)
    assert not on_border(*arrays, 1.0, 1.0)


def test_words_through_a_disc_and_a_square() -> None:
    regions = [Region("d", disc=(4, 1, 0.5)), Region("p", polygon=SQUARE)]
    assert word_of(regions, -1, 1, 6, 1) == [0, 2, 0, 1, 0]
    assert word_of(regions, 6, 1, -1, 1) == [0, 1, 0, 2, 0]
    assert word_of(regions, 1, 1, 4, 1) == [2, 0, 1]
    assert word_of(regions, 3, 3, 4, 3) == [0]
    assert word_of(regions, 3, 3, 3, 3) == [0]


def test_a_shared_border_belongs_to_both() -> None:
    left, right = SQUARE, SQUARE + np.array([2.0, 0.0])
    regions = [Region("l", polygon=left), Region("r", polygon=right)]
    assert word_of(regions, 1.0, 1.0, 3.0, 1.3) == [1, 3, 2]
    assert word_of(regions, 3.0, 1.0, 1.0, 1.7) == [2, 3, 1]


def test_lines_by_a_corner_or_along_a_border_have_no_word() -> None:
    regions = [Region("d", disc=(4, 1, 0.5)), Region("p", polygon=SQUARE)]
    assert word_of(regions, -1.0, 1.0, 1.0, 3.0) is None  # through the corner (0, 2)
    assert word_of(regions, 3.0, 1.5, 5.0, 1.5) is None  # touches the disc
    assert word_of(regions, -1.0, 2.0, 3.0, 2.0) is None  # along a side


@pytest.mark.parametrize("seed", range(8))
def test_words_are_those_of_many_points(seed: int) -> None:
    random = np.random.default_rng(seed)
    star = np.column_stack(
        [
            (2 + np.array([1.5, 0.5] * 4)) * np.cos(np.arange(8) * np.pi / 4),
            (2 + np.array([1.5, 0.5] * 4)) * np.sin(np.arange(8) * np.pi / 4),
        ]
    )
    regions = in_order_of_bits(
        [
            Region("star", polygon=star),
            Region("a", disc=(*random.uniform(-3, 3, 2), 1.3)),
            Region("b", disc=(*random.uniform(-3, 3, 2), 0.7)),
        ]
    )
    arrays = build_regions(regions)
    for _ in range(60):
        ax, ay, bx, by = random.uniform(-5, 5, 4)
        found = word_of(regions, ax, ay, bx, by)
        assert found is not None
        shares = np.linspace(0, 1, 4001)
        labels = [point_label(*arrays, ax + s * (bx - ax), ay + s * (by - ay)) for s in shares]
        seen = [label for i, label in enumerate(labels) if i == 0 or labels[i - 1] != label]
        # Points may miss a short letter, never see one that is not there.
        rest = iter(found)
        assert all(label in rest for label in seen)
        assert len(found) - len(seen) <= 2


def test_labels_that_occur() -> None:
    regions = [
        Region("big", disc=(0, 0, 3)),
        Region("small", disc=(1, 0, 1)),
        Region("far", disc=(9, 0, 1)),
        Region("across", polygon=SQUARE + np.array([2.0, -1.0])),
    ]
    found = occurring_labels(regions, [True] * 4)
    assert found == [0, 1, 3, 4, 8, 9, 11]  # small never without big; nothing with far
    assert occurring_labels(regions, [True, True, False, False]) == [0, 1, 3]


def test_distances_of_regions() -> None:
    square = Region("p", polygon=SQUARE)
    assert region_distance(square, Region("d", disc=(5, 1, 1))) == 2.0
    assert region_distance(Region("d", disc=(1, 1, 0.1)), square) == 0.0
    assert region_distance(Region("a", disc=(0, 0, 1)), Region("b", disc=(3, 4, 1))) == 3.0
    assert region_distance(square, Region("q", polygon=SQUARE + np.array([5.0, 0.0]))) == 3.0
    assert shapely.Polygon(SQUARE).area == 4.0


def test_too_many_regions_are_refused() -> None:
    with pytest.raises(InputError, match="at most 62"):
        build_regions([Region(str(i), disc=(i, 0, 0.1)) for i in range(63)])
