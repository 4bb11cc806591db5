"""Solvers by name, with settings."""

import pickle
from pathlib import Path

import pytest

from conav.errors import InputError
from conav.planning.catalogue import SOLVERS, make_solver, settings_of

DOCS = Path(__file__).parents[2] / "docs" / "planners"


@pytest.mark.parametrize("name", SOLVERS)
def test_every_solver_is_made_documented_and_pickles(name: str) -> None:
    solver = make_solver(name, {"samples": "500", "eta_m": "2.5"})
    assert settings_of(solver)["samples"] == 500
    assert settings_of(pickle.loads(pickle.dumps(solver))) == settings_of(solver)
    page = (DOCS / f"{name}.md").read_text()
    for setting in settings_of(solver):
        assert f"`{setting}`" in page


def test_bad_names_and_values() -> None:
    with pytest.raises(InputError, match="did you mean inash"):
        make_solver("inahs")
    with pytest.raises(InputError, match="did you mean samples"):
        make_solver("inash", {"sample": 3})
    with pytest.raises(InputError, match="setting 'mode' of solver inash"):
        make_solver("inash", {"mode": "backward"})
