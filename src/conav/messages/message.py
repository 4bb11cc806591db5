"""Messages between robots and their defined size.

Sizes follow one compact encoding, so that methods can be compared by what they send and not by how
a library packs it. A message has a header of 24 bytes: sender and receiver (4 each), sending time
(8), kind (4), length (4).
"""

from typing import NamedTuple, Protocol

HEADER_BYTES = 24


class Body(Protocol):
    """The content of a message; knows its own encoded size."""

    @property
    def size_bytes(self) -> int: ...


class Message(NamedTuple):
    """One message from one robot to one other."""

    sender: int
    receiver: int
    sent_at_s: float  # [s] simulated
    body: Body

    @property
    def size_bytes(self) -> int:
        """Header and body [bytes]."""
        return HEADER_BYTES + self.body.size_bytes


def report_bytes(n_robots: int) -> int:
    """The size of the report every robot sends to every robot it hears, each step [bytes].

    Header, its position (two 4-byte numbers), and per robot of the team the number of that robot's
    scans it holds (4 bytes each): the version vector from which a receiver sees what it lacks.
    """
    return HEADER_BYTES + 8 + 4 * n_robots


def scan_bytes(n_cells: int) -> int:
    """The size of one scan inside a message [bytes]: pose and count (8), 4 per newly seen cell."""
    return 8 + 4 * n_cells
