"""The buffer of readings at the ticks that a lesson may still need.

It holds the last ticks of the present episode, and permanently those of presses, of the second before them, and of
watched ticks. An episode ends at a restart, a rewind or driving, so that no reading from before it is used.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from understudy.model.features import ReadingKey
from understudy.model.learner_options import LONGEST_REACTION_S
from understudy.model.lesson import Lesson, ReadingLog


@dataclass(frozen=True, slots=True)
class Sample:
    """The readings at one tick, with the demonstrator's time."""

    seconds: float
    values: tuple[float, ...]


class SampleBuffer:
    """The recent moments of one agent, and the rows that its lesson uses."""

    def __init__(self, keys: Sequence[ReadingKey], record: ReadingLog | None = None) -> None:
        self.keys = tuple(keys)
        record = record or ReadingLog()
        recorded_keys = list(record.keys)
        old = np.full((len(record), len(self.keys)), np.nan)
        for column, key in enumerate(self.keys):
            if key in recorded_keys:
                old[:, column] = record.values[:, recorded_keys.index(key)]
        self._values = np.zeros((max(64, 2 * len(record)), len(self.keys)))
        self._seconds = np.zeros(len(self._values))
        self._values[: len(record)], self._seconds[: len(record)] = old, record.seconds
        self._kept = len(record)
        self._episode: deque[Sample] = deque()

    def begin_episode(self) -> None:
        """Forget the moments before now."""
        self._episode.clear()

    def append(self, moment: Sample) -> None:
        """Add the moment of a tick, which may be used for LONGEST_REACTION_S."""
        episode = self._episode
        episode.append(moment)
        while episode[0].seconds < moment.seconds - LONGEST_REACTION_S - 1e-9:
            episode.popleft()

    def keep_press(self) -> tuple[int, int]:
        """Keep the last moment and those before it; return the row of the press and how many precede it."""
        rows = [self.keep(moment) for moment in self._episode]
        return rows[-1], len(rows) - 1

    def keep_last(self) -> int:
        """Keep the last moment alone, and return its row."""
        return self.keep(self._episode[-1])

    def keep(self, moment: Sample) -> int:
        """Keep a moment, and return its row."""
        if self._kept == len(self._values):
            self._values = np.concatenate([self._values, np.zeros_like(self._values)])
            self._seconds = np.concatenate([self._seconds, np.zeros_like(self._seconds)])
        self._values[self._kept], self._seconds[self._kept] = moment.values, moment.seconds
        self._kept += 1
        return self._kept - 1

    @property
    def now(self) -> float:
        """The demonstrator's time of the last moment."""
        return self._episode[-1].seconds

    @property
    def record(self) -> ReadingLog:
        """All kept rows, as a view."""
        return ReadingLog(self.keys, self._values[: self._kept], self._seconds[: self._kept])


def compact_reading_log(lesson: Lesson) -> Lesson:
    """Return the lesson with only those rows of its record that its examples use."""
    record = lesson.record
    is_used = np.zeros(len(record), np.bool_)
    for example in lesson.examples:
        if example.moment is not None:
            is_used[example.moment - example.window : example.moment + 1] = True
    places = (np.cumsum(is_used) - 1).tolist()
    return replace(
        lesson,
        examples=tuple(
            each
            if each.moment is None or each.moment == places[each.moment]
            else replace(each, moment=places[each.moment])
            for each in lesson.examples
        ),
        record=ReadingLog(record.keys, record.values[is_used], record.seconds[is_used]),
    )
