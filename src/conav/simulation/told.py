"""What the radio network did in one step."""

from typing import NamedTuple


class Told(NamedTuple):
    """A transfer: `receiver` now holds the first `upto` scans of `origin`, from `sender`."""

    receiver: int
    sender: int
    origin: int
    upto: int


class Exchange(NamedTuple):
    """What was exchanged."""

    told: list[Told]  # empty where all tell all
    messages: int
    bytes: int
