"""Bodies of recorded runs, which return the recorded readings tick by tick and move nothing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from understudy.errors import UnknownName
from understudy.model.features import Percept, ReadingKey, format_reading_label
from understudy.records.header import RecordingHeader
from understudy.records.record import Record
from understudy.runtime.body import Channel, Commands, Reading


class ReplayBody:
    """The body of the agents of a run, at its first tick; each command advances it by a tick, and is ignored otherwise.

    The records have the same ticks and readings. `head` has the channels of the body, of which some may not have been
    recorded, and the start of the run, which is its time until readings are sensed.
    """

    def __init__(self, records: Sequence[Record], head: RecordingHeader | None = None) -> None:
        first = records[0]
        self.agents, self.tick_s, self.ticks = len(records), first.tick_s, first.ticks
        self.readings: Sequence[Reading] = first.readings
        self.targets: Sequence[str] = first.targets
        self.channels: Sequence[Channel] = first.channels if head is None else head.channels
        self._times, self._source = first.times, first.source
        self._columns = {
            key: np.stack([each.values[key] for each in records], axis=1) for key in first.values
        }
        self.tick = 0
        """The number of the current tick, from 0; equal to the number of ticks once all have passed."""
        self._now = float(self._times[0]) if head is None else head.began_s

    @property
    def is_over(self) -> bool:
        """True if all ticks have passed."""
        return self.tick >= self.ticks

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
        row = min(self.tick, self.ticks - 1)
        for key in keys:
            if key not in self._columns:
                labels = [format_reading_label(each) for each in self._columns]
                raise UnknownName(
                    what="reading", name=format_reading_label(key), where=self._source, known=labels
                )
        return {key: self._columns[key][row].copy() for key in keys}

    def act(self, commands: Commands) -> None:
        """Advance to the next tick; the commands are ignored."""
        self.tick += 1
        self._now = self._time()

    def _time(self) -> float:
        return float(self._times[min(self.tick, self.ticks - 1)])
