"""The digest of a run: equal for equal runs, on every machine."""

import hashlib


class Digest:
    """SHA-256 over the ordered (topic, time, payload) of a run's events.

    Left out: versions, wall times, the thinned ROS topics and how the file is compressed.
    """

    def __init__(self) -> None:
        self._sum = hashlib.sha256()

    def add(self, topic: str, time_ns: int, payload: bytes | memoryview) -> None:
        """Take in the next event."""
        name = topic.encode()
        self._sum.update(b"%d:%b:%d:%d:" % (len(name), name, time_ns, len(payload)))
        self._sum.update(payload)

    def hex(self) -> str:
        """The digest of all events so far, 64 hexadecimal digits."""
        return self._sum.hexdigest()
