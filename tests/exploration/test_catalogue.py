"""Catalogue, modules, tests and docs name the same strategies; each passes the shared checks."""

from pathlib import Path

import pytest

from conav.errors import InputError
from conav.exploration.catalogue import STRATEGIES, make_strategy, settings_of
from conav.testing import check_strategy

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", STRATEGIES)
@pytest.mark.parametrize("motion", ["8-connected", "4-connected", "forward-turn"])
def test_passes_the_shared_checks(name: str, motion: str) -> None:
    check_strategy(make_strategy(name), motion=motion)


@pytest.mark.parametrize("name", STRATEGIES)
def test_has_its_file_its_test_and_its_page(name: str) -> None:
    module = STRATEGIES[name].partition(":")[0]
    stem = name.replace("-", "_")
    assert module == f"conav.exploration.{stem}"
    assert (ROOT / "src/conav/exploration" / f"{stem}.py").is_file()
    assert (ROOT / "tests/exploration" / f"test_{stem}.py").is_file()
    assert (ROOT / "docs/strategies" / f"{name}.md").is_file()


def test_no_page_without_a_strategy() -> None:
    pages = {path.stem for path in (ROOT / "docs/strategies").glob("*.md")}
    assert pages == set(STRATEGIES)


@pytest.mark.parametrize("name", STRATEGIES)
def test_page_names_every_setting(name: str) -> None:
    page = (ROOT / "docs/strategies" / f"{name}.md").read_text()
    for setting in settings_of(make_strategy(name)):
        assert f"`{setting}`" in page


def test_settings_come_from_text() -> None:
    assert settings_of(make_strategy("nearest", {"keep_goal": "true"})) == {"keep_goal": True}


@pytest.mark.parametrize(
    ("name", "settings", "hint"),
    [
        ("nearst", {}, "nearest"),
        ("nearest", {"keep_gaol": "1"}, "keep_goal"),
        ("nearest", {"keep_goal": "maybe"}, "docs/strategies/nearest.md"),
    ],
)
def test_misspellings_are_named(name: str, settings: dict[str, str], hint: str) -> None:
    with pytest.raises(InputError, match=hint):
        make_strategy(name, settings)
