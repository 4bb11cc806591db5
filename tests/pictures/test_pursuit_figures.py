"""Figures of pursuits: names, depths, and what is where in what colour."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from conav.geometry.triangulation import triangulate
from conav.maps.polygon_map import PolygonMap
from conav.pictures.pursuit_figures import (
    CLEAR,
    CONTAMINATED,
    SEEN,
    Moment,
    depths,
    node_names,
    save_components,
    save_graphs,
    save_moments,
    save_view,
)
from conav.pursuit.known_map import Move
from conav.pursuit.navigation_graph import known_navigation_graph
from conav.pursuit.pursuit_graph import PursuitGraph
from conav.pursuit.types import HiddenRegion

CORNER = PolygonMap([(0, 0), (20, 0), (20, 10), (10, 10), (10, 20), (0, 20)])
ARM = np.array([(1.0, 12.0), (9.0, 12.0), (9.0, 19.0), (1.0, 19.0)])


def colours(path: Path) -> dict[tuple[int, ...], int]:
    """How many pixels have which colour."""
    with Image.open(path) as picture:
        pixels = np.asarray(picture.convert("RGB")).reshape(-1, 3)
    found, counts = np.unique(pixels, axis=0, return_counts=True)
    return {tuple(map(int, rgb)): int(n) for rgb, n in zip(found, counts, strict=True)}


def size(path: Path) -> tuple[int, int]:
    with Image.open(path) as picture:
        return picture.size


def test_what_is_seen_is_as_large_as_it_is(tmp_path: Path) -> None:
    save_view(CORNER, (19.0, 5.0), tmp_path / "view.png")
    found = colours(tmp_path / "view.png")
    # Beyond the corner from (19, 5) the arm is seen below the line through (10, 10).
    seen = 200 + (10 * 10 / 9 * 5) / 2
    scale = size(tmp_path / "view.png")[0] / (20.0 + 2 * 0.4)  # a margin of 2 % on each side
    assert found[SEEN] / scale**2 == pytest.approx(seen, rel=0.03)


def test_hidden_regions_have_the_colour_of_their_label(tmp_path: Path) -> None:
    for clear, colour, other in ((True, CLEAR, CONTAMINATED), (False, CONTAMINATED, CLEAR)):
        moment = Moment([(15.0, 5.0)], (HiddenRegion(ARM, clear=clear),), words="one")
        save_moments(CORNER, [moment, moment, moment], tmp_path / "moments.png", columns=2)
        found = colours(tmp_path / "moments.png")
        assert other not in found
        assert found[colour] > 3 * 15_000
    save_moments(CORNER, [moment], tmp_path / "one.png")
    width, height = size(tmp_path / "one.png")
    assert size(tmp_path / "moments.png") == (2 * width, 2 * height)
    save_components(CORNER, (15.0, 5.0), [ARM], tmp_path / "parts.png")
    assert colours(tmp_path / "parts.png")[CONTAMINATED] > 15_000


def test_both_graphs_are_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    mesh = triangulate(CORNER.vertices, CORNER.ring_starts)
    graph = known_navigation_graph(CORNER, mesh, [(15.0, 5.0)])
    assert node_names(graph) == ["p", "S1"]
    there = Move(0, 1)
    pursuit = PursuitGraph(
        (((0,), 1), ((1,), 1), ((0,), 0), ((1,), 0)),
        (((1, there), (2, there)), ((3, there),), (), ()),
        True,
    )
    assert depths(pursuit) == [0, 1, 1, 2]
    save_graphs(CORNER, graph, pursuit, tmp_path / "graphs.png")
    assert size(tmp_path / "graphs.png") == (1800, 1000)
