"""A clock in a file, which a test moves and by which a studio runs: the world stands still while the test does."""

from __future__ import annotations

import struct
from mmap import mmap
from pathlib import Path

TIME = struct.Struct("d")
"""What time it is, s."""


class SharedClock:
    """The time in a file."""

    def __init__(self, file: Path) -> None:
        if not file.exists():
            file.write_bytes(TIME.pack(0.0))
        with file.open("r+b") as opened:
            self._time = mmap(opened.fileno(), TIME.size)

    def read(self) -> float:
        """Tell what time it is."""
        now: float = TIME.unpack_from(self._time)[0]
        return now

    def advance(self, seconds: float) -> None:
        """Let time pass."""
        TIME.pack_into(self._time, 0, self.read() + seconds)
