"""The exploration strategies by name."""

import difflib
import importlib
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, cast

from conav.errors import InputError
from conav.exploration.types import Strategy

STRATEGIES: dict[str, str] = {
    "nearest": "conav.exploration.nearest:Nearest",
    "greedy": "conav.exploration.greedy:Greedy",
    "hungarian": "conav.exploration.hungarian:Hungarian",
    "minpos": "conav.exploration.minpos:MinPos",
    "frontier-dp": "conav.exploration.frontier_dp:FrontierDP",
    "decision-theoretic": "conav.exploration.decision_theoretic:DecisionTheoretic",
    "repeated-auction": "conav.exploration.repeated_auction:RepeatedAuction",
    "segmentation": "conav.exploration.segmentation:Segmentation",
    "two-stage": "conav.exploration.two_stage:TwoStage",
    "pocket-assignment": "conav.exploration.pocket_assignment:PocketAssignment",
    "lanes-and-pockets": "conav.exploration.lanes_and_pockets:LanesAndPockets",
    "potential-1": "conav.exploration.potential_1:Potential1",
    "potential": "conav.exploration.potential:Potential",
    "potential-improved": "conav.exploration.potential_improved:PotentialImproved",
    "potential-frontier": "conav.exploration.potential_frontier:PotentialFrontier",
    "potential-quiet": "conav.exploration.potential_quiet:PotentialQuiet",
    "better-response": "conav.exploration.better_response:BetterResponse",
    "marginal-contribution": "conav.exploration.marginal_contribution:MarginalContribution",
    "uncoordinated": "conav.exploration.uncoordinated:Uncoordinated",
    "uncoordinated-alone": "conav.exploration.uncoordinated_alone:UncoordinatedAlone",
}
"""Strategy name -> "module:class"; nothing is imported before it is asked for."""

DEFAULT_STRATEGY = "lanes-and-pockets"


def strategy_class(name: str) -> type[Any]:
    """The class of settings behind a strategy's name. Raises `InputError` for an unknown name."""
    if name not in STRATEGIES:
        near = difflib.get_close_matches(name, STRATEGIES, n=1)
        hint = f"did you mean {near[0]}?" if near else "use one of: " + ", ".join(STRATEGIES)
        raise InputError(f"strategy {name!r}", "is not known", hint)
    module, _, attribute = STRATEGIES[name].partition(":")
    return cast("type[Any]", getattr(importlib.import_module(module), attribute))


def make_strategy(name: str, settings: Mapping[str, object] | None = None) -> Strategy:
    """The strategy with these settings; text is read as the setting's type.

    Raises `InputError` for an unknown name, a misspelt setting or a value of the wrong type.
    """
    from pydantic import ConfigDict, TypeAdapter, ValidationError

    cls = strategy_class(name)
    names = [item.name for item in fields(cls)]
    given = dict(settings or {})
    for key in given:
        if key not in names:
            near = difflib.get_close_matches(key, names, n=1)
            known = ", ".join(names) if names else "none"
            hint = f"did you mean {near[0]}?" if near else f"its settings: {known}"
            raise InputError(f"setting {key!r}", f"strategy {name} has no such setting", hint)
    cls.__pydantic_config__ = ConfigDict(extra="forbid")
    try:
        return cast("Strategy", TypeAdapter(cls).validate_python(given))
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        if not key:  # settings that do not go together, or a check of the class's own
            raise InputError(
                f"settings of strategy {name}",
                first["msg"].removeprefix("Value error, "),
                f"see docs/strategies/{name}.md for their values",
            ) from None
        raise InputError(
            f"setting {key!r} of strategy {name}",
            f"got {first['input']!r}: {first['msg']}",
            f"see docs/strategies/{name}.md for its values",
        ) from None


def settings_of(strategy: Strategy) -> dict[str, object]:
    """All settings of a strategy, defaults included, by name."""
    return {item.name: getattr(strategy, item.name) for item in fields(cast("Any", strategy))}
