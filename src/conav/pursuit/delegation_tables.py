"""The delegation protocol of [Pellier2005], Figures 6 and 7, as tables."""

from collections.abc import Mapping
from enum import StrEnum
from typing import TypeVar

from conav.pursuit.delegation_messages import Role


class Asking(StrEnum):
    """The assisted pursuer, Figure 6; numbers are the paper's, 0 and 8 are ours."""

    WORKING = "0 needs no help"
    ROLES = "1 collects roles"
    CHOICE = "2 decides who can help"
    GUARDS = "3 asks guards"
    IDLES = "4 asks idle pursuers"
    WAITING = "5 waits for explorers"
    STUCKS = "6 asks stuck pursuers"
    MORE = "7 asks for one more pursuer"
    HELPED = "8 is being helped"


class Helping(StrEnum):
    """The assistant pursuer, Figure 7."""

    FREE = "free"
    ASKED = "asked"
    OFFERED = "has offered"
    COMING = "comes"


ASKING: dict[tuple[Asking, str], Asking] = {
    (Asking.WORKING, "stuck"): Asking.ROLES,
    (Asking.ROLES, "all roles told"): Asking.CHOICE,
    (Asking.CHOICE, "some are idle"): Asking.IDLES,
    (Asking.CHOICE, "some are guards"): Asking.GUARDS,
    (Asking.CHOICE, "some explore"): Asking.WAITING,
    (Asking.CHOICE, "others are stuck"): Asking.STUCKS,
    (Asking.CHOICE, "nobody is left to ask"): Asking.MORE,
    (Asking.CHOICE, "a task ended"): Asking.ROLES,
    (Asking.IDLES, "all refused"): Asking.CHOICE,
    (Asking.IDLES, "best offer taken"): Asking.HELPED,
    (Asking.GUARDS, "all refused"): Asking.CHOICE,
    (Asking.GUARDS, "best offer taken"): Asking.HELPED,
    (Asking.STUCKS, "all refused"): Asking.CHOICE,
    (Asking.STUCKS, "best offer taken"): Asking.HELPED,
    (Asking.WAITING, "a task ended"): Asking.ROLES,
    (Asking.MORE, "a pursuer joined"): Asking.ROLES,
    (Asking.HELPED, "helper came"): Asking.WORKING,
    (Asking.HELPED, "helper is gone"): Asking.ROLES,
    (Asking.ROLES, "gives up"): Asking.WORKING,
    (Asking.IDLES, "gives up"): Asking.WORKING,
    (Asking.GUARDS, "gives up"): Asking.WORKING,
    (Asking.STUCKS, "gives up"): Asking.WORKING,
    (Asking.WAITING, "gives up"): Asking.WORKING,
    (Asking.MORE, "gives up"): Asking.WORKING,
}
"""(state, event) -> state of who is stuck."""

HELPING: dict[tuple[Helping, str], Helping] = {
    (Helping.FREE, "asked for help"): Helping.ASKED,
    (Helping.ASKED, "can help"): Helping.OFFERED,
    (Helping.ASKED, "cannot help"): Helping.FREE,
    (Helping.ASKED, "asker is gone"): Helping.FREE,
    (Helping.OFFERED, "offer not taken"): Helping.FREE,
    (Helping.OFFERED, "offer taken"): Helping.COMING,
    (Helping.OFFERED, "asker is gone"): Helping.FREE,
    (Helping.COMING, "came"): Helping.FREE,
    (Helping.COMING, "asker is gone"): Helping.FREE,
}
"""(state, event) -> state of who may help."""

ROLES: dict[tuple[Role, str], Role] = {
    (Role.IDLE, "takes a part"): Role.EXPLORER,
    (Role.EXPLORER, "part ended"): Role.IDLE,
    (Role.EXPLORER, "stuck"): Role.STUCK,
    (Role.STUCK, "helper came"): Role.EXPLORER,
    (Role.STUCK, "gives up"): Role.IDLE,
    (Role.IDLE, "came"): Role.GUARD,
    (Role.GUARD, "came"): Role.GUARD,
    (Role.GUARD, "released"): Role.IDLE,
}
"""(role, event) -> role."""


S = TypeVar("S")


class IllegalEvent(Exception):
    """A state has no transition for an event; nothing was changed."""


def follow(table: Mapping[tuple[S, str], S], state: S, event: str) -> S:
    """The state after an event; raises `IllegalEvent` where the table has none."""
    if (state, event) not in table:
        raise IllegalEvent(f"{state!s} has no transition for {event!r}")
    return table[state, event]


def protocol_table() -> str:
    """All three tables as Markdown."""
    rows = ["| | state | event | next state |", "|---|---|---|---|"]
    for name, table in (("assisted", ASKING), ("assistant", HELPING), ("role", ROLES)):
        rows += [
            f"| {name} | {state} | {event} | {then} |" for (state, event), then in table.items()
        ]
    return "\n".join(rows)
