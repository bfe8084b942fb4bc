"""Recordings as bodies, which return the recorded readings tick by tick and move nothing."""

from __future__ import annotations

from collections.abc import Sequence

from understudy.errors import UnknownName
from understudy.model.features import Percept, ReadingKey, format_reading_label
from understudy.records.reader import Recording
from understudy.runtime.body import Channel, Commands, Reading


class ReplayBody:
    """The body of a recording, at its first tick; each command advances it to the next tick, and is ignored otherwise.

    Until readings are sensed, its time is the start of the run.
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
        """The number of the current tick, from 0; equal to the number of ticks once all have passed."""
        self._now = head.began_s

    @property
    def is_over(self) -> bool:
        """True if all ticks have passed."""
        return self.tick >= self.recording.ticks

    @property
    def time_s(self) -> float:
        """The recorded time of this tick, in s."""
        return self._now

    def wait(self, until_s: float | None) -> None:
        """Set the time (s), until readings are sensed, to that of an action between two ticks; None leaves it."""
        if until_s is not None:
            self._now = until_s

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return the recorded readings of this tick; raise UnknownName if one was not recorded."""
        self._now = self._time()
        values = self.recording.values[min(self.tick, self.recording.ticks - 1)]
        for key in keys:
            if key not in self._rows:
                where, labels = str(self.recording.path), [format_reading_label(each) for each in self._rows]
                raise UnknownName(what="reading", name=format_reading_label(key), where=where, known=labels)
        return {key: values[self._rows[key]].copy() for key in keys}

    def act(self, commands: Commands) -> None:
        """Advance to the next tick; the commands are ignored."""
        self.tick += 1
        self._now = self._time()

    def _time(self) -> float:
        return float(self.recording.times[min(self.tick, self.recording.ticks - 1)])
