"""CDR by hand for the messages written every few steps: the same bytes rosbags makes, sooner.

CDR aligns every number to its own size, counted from behind the four bytes that name the encoding
(little endian, version 1). Strings and sequences begin with a 4-byte length; a string's includes
its closing zero.
"""

import struct
from collections.abc import Sequence

from conav.runs.types import StepRecord

ENCODING = b"\x00\x01\x00\x00"

_LENGTH = struct.Struct("<I")
_TWO = struct.Struct("<II")
_ENDS = struct.Struct("<IxxxxQ"), struct.Struct("<IQ")
_POSE = struct.Struct("<7d")
_PAD = (b"", b"\x00\x00\x00", b"\x00\x00", b"\x00")


def encode_step(record: StepRecord) -> bytes:
    """A step as `conav_msgs/msg/Step`."""
    pack = _LENGTH.pack
    n = len(record.cells)
    count = pack(n)
    pad = _PAD[n % 4]
    body = b"".join(
        (
            _TWO.pack(record.step, n),
            record.cells.tobytes(),
            count,
            record.headings.tobytes(),
            pad,
            count,
            record.looked.tobytes(),
            pad,
            count,
            record.scan_ends.tobytes(),
            pack(len(record.scans)),
            record.scans.tobytes(),
            pack(len(record.told)),
            record.told.tobytes(),
            pack(len(record.said)),
            record.said.tobytes(),
            count,
            record.wishes.tobytes(),
            pad,
            count,
            record.goals.tobytes(),
            count,
            record.finished.tobytes(),
            pad,
            count,
            record.quiet.tobytes(),
            pad,
            count,
            record.condition.tobytes(),
            pad,
        )
    )
    # The last number is eight bytes long; a gap before it depends on where this one ends.
    ends = _ENDS[len(body) % 8 // 4]
    return ENCODING + body + ends.pack(record.messages, record.bytes)


def encode_pose(time_ns: int, frame: str, numbers: Sequence[float]) -> bytes:
    """`geometry_msgs/msg/PoseStamped`; numbers are position x y z and orientation x y z w."""
    head = _stamped(time_ns, frame)
    return ENCODING + head + b"\x00" * (-len(head) % 8) + _POSE.pack(*numbers)


def encode_transforms(
    time_ns: int, frame: str, children: Sequence[str], numbers: Sequence[Sequence[float]]
) -> bytes:
    """`tf2_msgs/msg/TFMessage`, one transform per child frame; numbers as in `encode_pose`."""
    body = bytearray(_LENGTH.pack(len(children)))
    for child, pose in zip(children, numbers, strict=True):
        body += b"\x00" * (-len(body) % 4)
        body += _stamped(time_ns, frame)
        body += b"\x00" * (-len(body) % 4)
        body += _string(child)
        body += b"\x00" * (-len(body) % 8)
        body += _POSE.pack(*pose)
    return ENCODING + bytes(body)


def _stamped(time_ns: int, frame: str) -> bytes:
    return _TWO.pack(time_ns // 1_000_000_000, time_ns % 1_000_000_000) + _string(frame)


def _string(text: str) -> bytes:
    data = text.encode() + b"\x00"
    return _LENGTH.pack(len(data)) + data
