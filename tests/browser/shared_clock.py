"""A clock in a file, which a test moves and by which a studio runs: the world stands still while the test does."""

from __future__ import annotations

import struct
from mmap import mmap
from pathlib import Path
from time import monotonic, sleep

TIMES = struct.Struct("dd")
"""What time it is, and what time the studio last saw, s."""
MOST_S = 0.2
"""How far it moves at once; the studio does not make up for more than a quarter of a second."""
SEEN_S = 60.0
"""How long a studio may take to see that it moved."""


class SharedClock:
    """The time in a file."""

    def __init__(self, file: Path) -> None:
        if not file.exists():
            file.write_bytes(TIMES.pack(0.0, 0.0))
        with file.open("r+b") as opened:
            self._times = mmap(opened.fileno(), TIMES.size)

    def read(self) -> float:
        """Tell what time it is, and note that it was seen."""
        now: float = TIMES.unpack_from(self._times)[0]
        struct.pack_into("d", self._times, struct.calcsize("d"), now)
        return now

    def advance(self, seconds: float) -> None:
        """Let time pass, in steps that a studio keeps up with, and wait until it has seen each."""
        while seconds > 0:
            step = min(seconds, MOST_S)
            seconds -= step
            now = TIMES.unpack_from(self._times)[0] + step
            struct.pack_into("d", self._times, 0, now)
            until = monotonic() + SEEN_S
            while TIMES.unpack_from(self._times)[1] != now:
                assert monotonic() < until, "the studio does not look at its clock"
                sleep(0.002)
