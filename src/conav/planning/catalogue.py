"""The solvers by name."""

import difflib
import importlib
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Protocol, cast

from conav.errors import InputError
from conav.planning.budget import OnProgress
from conav.planning.types import PlanningProblem, PlanningResult

SOLVERS: dict[str, str] = {
    "inash": "conav.planning.inash:INash",
    "prioritized": "conav.planning.prioritized:Prioritized",
    "anytime-prioritized": "conav.planning.anytime_prioritized:AnytimePrioritized",
    "inash-restarts": "conav.planning.inash_restarts:INashRestarts",
    "social-optimum": "conav.planning.social_optimum:SocialOptimum",
    "coupled": "conav.planning.coupled:Coupled",
}
"""Solver name -> "module:class"; nothing is imported before it is asked for."""

DEFAULT_SOLVER = "inash"


class Solver(Protocol):
    """Settings, and what they do with a problem."""

    def solve(
        self, problem: PlanningProblem, seed: int = 0, on_progress: OnProgress | None = None
    ) -> PlanningResult: ...


def solver_class(name: str) -> type[Any]:
    """The class of settings behind a solver's name. Raises `InputError` for an unknown name."""
    if name not in SOLVERS:
        near = difflib.get_close_matches(name, SOLVERS, n=1)
        hint = f"did you mean {near[0]}?" if near else "use one of: " + ", ".join(SOLVERS)
        raise InputError(f"solver {name!r}", "is not known", hint)
    module, _, attribute = SOLVERS[name].partition(":")
    return cast("type[Any]", getattr(importlib.import_module(module), attribute))


def make_solver(name: str, settings: Mapping[str, object] | None = None) -> Solver:
    """The solver with these settings; text is read as the setting's type.

    Raises `InputError` for an unknown name, a misspelt setting or a value that is not allowed.
    """
    from pydantic import ConfigDict, TypeAdapter, ValidationError

    cls = solver_class(name)
    names = [item.name for item in fields(cls)]
    given = dict(settings or {})
    for key in given:
        if key not in names:
            near = difflib.get_close_matches(key, names, n=1)
            hint = f"did you mean {near[0]}?" if near else "its settings: " + ", ".join(names)
            raise InputError(f"setting {key!r}", f"solver {name} has no such setting", hint)
    cls.__pydantic_config__ = ConfigDict(extra="forbid")
    try:
        return cast("Solver", TypeAdapter(cls).validate_python(given))
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        place = f"setting {key!r} of solver {name}" if key else f"settings of solver {name}"
        raise InputError(
            place,
            f"got {first['input']!r}: {first['msg'].removeprefix('Value error, ')}",
            f"see docs/planners/{name}.md for its values",
        ) from None


def settings_of(solver: Solver) -> dict[str, object]:
    """All settings of a solver, defaults included, by name."""
    return {item.name: getattr(solver, item.name) for item in fields(cast("Any", solver))}
