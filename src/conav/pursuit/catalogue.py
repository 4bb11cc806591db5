"""The methods of clearing a floor by name."""

import difflib
import importlib
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, Protocol, cast

from conav.errors import InputError
from conav.pursuit.types import PursuitProblem, PursuitResult

OnProgress = Callable[[int, int], bool]
"""Told how many pursuers are tried and how many states were expanded for them; False ends it."""

METHODS: dict[str, dict[str, str]] = {
    "known-map": {
        "shadows": "conav.pursuit.clear_known_map:ClearKnownMap",
        "paper": "conav.pursuit.clear_by_vertex_labels:ClearByVertexLabels",
    },
    "splitting": {
        "shadows": "conav.pursuit.splitting:Splitting",
        "paper": "conav.pursuit.splitting:SplittingByVertexLabels",
    },
    "unknown-map": {"shadows": "conav.pursuit.clear_unknown_map:ClearUnknownMap"},
    "guards": {"shadows": "conav.pursuit.clear_by_guards:ClearByGuards"},
    "spanning-trees": {"shadows": "conav.pursuit.clear_by_spanning_trees:ClearBySpanningTrees"},
    "delegation": {"shadows": "conav.pursuit.delegation:Delegation"},
}
"""Method -> labels -> "module:class"; nothing is imported before it is asked for."""

DEFAULT_METHOD, DEFAULT_LABELS = "known-map", "shadows"


class Method(Protocol):
    """A frozen dataclass of settings that finds out how to clear a floor."""

    def solve(
        self, problem: PursuitProblem, on_progress: OnProgress | None = None
    ) -> PursuitResult: ...


def make_method(
    name: str = DEFAULT_METHOD,
    labels: str = DEFAULT_LABELS,
    settings: Mapping[str, object] | None = None,
) -> Method:
    """The method with these labels and settings; text is read as the setting's type.

    Raises `InputError` for a name, labels or setting that is not known, and for a value that is not
    allowed.
    """
    from pydantic import ConfigDict, TypeAdapter, ValidationError

    if name not in METHODS:
        raise InputError(f"method {name!r}", "is not known", _hint(name, METHODS))
    if labels not in METHODS[name]:
        raise InputError(
            f"labels {labels!r}", f"are not what {name} works with", _hint(labels, METHODS[name])
        )
    module, _, entry = METHODS[name][labels].partition(":")
    cls: Any = getattr(importlib.import_module(module), entry)
    names = [item.name for item in fields(cls)]
    settings = dict(settings or {})
    for key in settings:
        if key not in names:
            raise InputError(f"setting {key!r}", "is not known", _hint(key, names))
    cls.__pydantic_config__ = ConfigDict(extra="forbid")
    try:
        return cast("Method", TypeAdapter(cls).validate_python(settings))
    except ValidationError as error:
        first = error.errors()[0]
        key = str(first["loc"][0]) if first["loc"] else ""  # then the types tried, for some
        raise InputError(
            f"setting {key!r}" if key else "settings",
            f"got {first['input']!r}: {first['msg'].removeprefix('Value error, ')}",
            "see docs/pursuit.md",
        ) from None


def settings_of(method: Method) -> dict[str, object]:
    """All settings, defaults included, by name."""
    return {item.name: getattr(method, item.name) for item in fields(cast("Any", method))}


def _hint(word: str, known: Any) -> str:
    near = difflib.get_close_matches(word, list(known), n=1)
    return f"did you mean {near[0]}?" if near else "there are: " + ", ".join(known)
