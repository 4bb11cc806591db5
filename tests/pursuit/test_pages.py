"""The pages of clearing floors say what the program has."""

from dataclasses import fields
from importlib import import_module
from pathlib import Path

import pytest

from conav.pursuit.catalogue import METHODS
from conav.pursuit.delegation_tables import protocol_table

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {
    ("known-map", "shadows"): "pursuit.md",
    ("known-map", "paper"): "pursuit-labels.md",
    ("splitting", "shadows"): "pursuit-splitting.md",
    ("splitting", "paper"): "pursuit-splitting.md",
    ("unknown-map", "shadows"): "pursuit-unknown.md",
    ("spanning-trees", "shadows"): "pursuit-graphs.md",
    ("delegation", "shadows"): "pursuit-delegation.md",
}
"""Where settings are; those of guards are told in words."""


def test_every_method_has_a_page() -> None:
    have = {(name, labels) for name, kinds in METHODS.items() for labels in kinds}
    assert have == {*PAGES, ("guards", "shadows")}


@pytest.mark.parametrize("key", PAGES)
def test_settings_are_on_the_page_of_their_method(key: tuple[str, str]) -> None:
    name, labels = key
    page = (DOCS / PAGES[key]).read_text()
    module, _, entry = METHODS[name][labels].partition(":")
    for item in fields(getattr(import_module(module), entry)):
        assert f"| `{item.name}` |" in page
    assert f"`--method {name}`" in (DOCS / "pursuit.md").read_text()


def test_the_protocol_on_its_page_is_the_programs() -> None:
    page = (DOCS / "pursuit-delegation.md").read_text()
    assert protocol_table() in page


def test_ways_of_random_evaders_are_on_the_page() -> None:
    page = (DOCS / "pursuit.md").read_text()
    for option in ("--evader random", "--evader-speed", "--evaders", "--seed"):
        assert f"{option}`" in page or f"{option} " in page
