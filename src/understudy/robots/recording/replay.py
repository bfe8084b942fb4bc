"""A recording as a body: it senses what was sensed, tick by tick, and moves nothing."""

from __future__ import annotations

from collections.abc import Sequence

from understudy.errors import UnknownName
from understudy.model.features import Percept, ReadingKey
from understudy.robots.recording.message_types import format_reading_label
from understudy.robots.recording.reader import Recording
from understudy.runtime.body import Channel, Commands, Reading


class ReplayBody:
    """The body of a recording, at its first tick; each command goes on to the next, whatever it says.

    Until something is sensed, its clock stands where the run began.
    """

    def __init__(self, recording: Recording) -> None:
        head = recording.head
        self.recording = recording
        self.agents = len(head.names)
        self.readings: Sequence[Reading] = head.readings
        self.targets: Sequence[str] = head.targets
        self.channels: Sequence[Channel] = head.channels
        self.tick_s = head.tick_s
        self._rows = {key: row for row, key in enumerate(recording.keys)}
        self.tick = 0
        """Which tick it is at; the number of ticks, once all have passed."""
        self._now = head.began_s

    @property
    def is_over(self) -> bool:
        """Whether all ticks have passed."""
        return self.tick >= self.recording.ticks

    @property
    def time_s(self) -> float:
        """The time of this tick as it was recorded, s."""
        return self._now

    def wait(self, until_s: float | None) -> None:
        """Let its clock stand, until it senses, where the body's stood when something came between two ticks."""
        if until_s is not None:
            self._now = until_s

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """What was read at this tick; UnknownName of what was not recorded."""
        self._now = self._time()
        values = self.recording.values[min(self.tick, self.recording.ticks - 1)]
        for key in keys:
            if key not in self._rows:
                where, known = str(self.recording.path), [format_reading_label(each) for each in self._rows]
                raise UnknownName(what="reading", name=format_reading_label(key), where=where, known=known)
        return {key: values[self._rows[key]].copy() for key in keys}

    def act(self, commands: Commands) -> None:
        """Go on to the next tick."""
        self.tick += 1
        self._now = self._time()

    def _time(self) -> float:
        return float(self.recording.times[min(self.tick, self.recording.ticks - 1)])
