"""Animated GIFs on one palette, written frame by frame.

Only the rectangle that changed is stored, with what is equal in it left transparent, so long
animations stay small; nothing but the last frame is held in memory.
"""

import struct
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

MAX_DELAY = 65535  # hundredths of a second


class GifWriter:
    """Writes frames of palette indices to a stream; loops for ever.

    `palette` has shape (256, 3); index `transparent` must not occur in a frame.
    """

    def __init__(
        self,
        stream: BinaryIO,
        width: int,
        height: int,
        palette: NDArray[np.uint8],
        transparent: int,
    ) -> None:
        self._stream = stream
        self._transparent = transparent
        self._shown: NDArray[np.uint8] | None = None  # what the file shows after its last frame
        self._waiting: NDArray[np.uint8] | None = None  # the frame whose delay is still growing
        self._delay = 0
        # A global palette of 2 ** (7 + 1) entries; no background; square pixels.
        stream.write(b"GIF89a" + struct.pack("<HHBBB", width, height, 0xF7, 0, 0))
        stream.write(palette.tobytes())
        stream.write(b"!\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00")

    def add(self, frame: NDArray[np.uint8], delay: int) -> None:
        """Add a frame, shape (height, width), shown for that many hundredths of a second.

        A frame equal to the one before it only prolongs that one.
        """
        if self._waiting is not None and np.array_equal(frame, self._waiting):
            self._delay += delay
            return
        self._flush()
        self._waiting = frame.copy()
        self._delay = delay

    def close(self) -> None:
        """Write what is left; the stream stays open."""
        self._flush()
        self._stream.write(b";")

    def _flush(self) -> None:
        from PIL import GifImagePlugin, Image

        frame = self._waiting
        if frame is None:
            return
        left = top = 0
        patch = frame
        if self._shown is not None:
            changed = frame != self._shown
            rows, cols = np.flatnonzero(changed.any(axis=1)), np.flatnonzero(changed.any(axis=0))
            top, left = int(rows[0]), int(cols[0])
            box = np.s_[top : int(rows[-1]) + 1, left : int(cols[-1]) + 1]
            patch = np.where(changed[box], frame[box], np.uint8(self._transparent))
        parts = GifImagePlugin.getdata(
            Image.fromarray(patch),
            offset=(left, top),
            duration=min(self._delay, MAX_DELAY) * 10,
            transparency=self._transparent,
            disposal=1,
        )
        self._stream.writelines(parts)
        self._shown = frame
        self._waiting = None
