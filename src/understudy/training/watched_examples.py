"""Learning from silence: ticks that the demonstrator watched and did not correct become watched examples.

Rules (1) to (3) of *Watched examples* in docs/semantics.md; the learner applies rule (4).
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from understudy.model.features import ReadingKey
from understudy.model.lesson import Example, Lesson, ReadingLog
from understudy.runtime.interpreter import measure_elapsed
from understudy.training.example_index import ExampleKey, make_example_key
from understudy.training.feature_values import compute_example_values
from understudy.training.sample_buffer import Sample

STAY_APART_S = 0.3
SHORTEST_DOUBT_S = 0.4
REACTION_MARGIN_S = 0.2


def measure_deciding_time(reaction_s: float) -> float:
    """Return the time in s before a press in which a demonstrator with this reaction time was deciding to press."""
    return max(SHORTEST_DOUBT_S, measure_elapsed(reaction_s + REACTION_MARGIN_S, 0.0))


@dataclass(frozen=True, slots=True)
class WatchedTick:
    """A tick that has not been corrected so far."""

    moment: Sample
    example: Example  # without row or number yet


@dataclass(frozen=True, slots=True)
class WatchedBatch:
    """Ticks that become examples, and when each state was last seen to stay."""

    ticks: tuple[WatchedTick, ...]
    last_stay: dict[str, float]


class WatchedBuffer:
    """The ticks watched since the last press, and the choice of those that become examples."""

    def __init__(self) -> None:
        self._seen: list[WatchedTick] = []
        self._last_stay: dict[str, float] = {}

    def add_tick(self, tick: WatchedTick) -> None:
        """Add a tick without a press."""
        self._seen.append(tick)

    def discard_recent(self, now: float, *, reaction_s: float, since_s: float = inf) -> None:
        """Discard the ticks just before a press and those since a time, which the demonstrator did not accept."""
        deciding_s = measure_deciding_time(reaction_s)
        self._seen = [
            tick
            for tick in self._seen
            if measure_elapsed(now, tick.moment.seconds) >= deciding_s and tick.moment.seconds < since_s
        ]

    def begin_episode(self) -> None:
        """Note that the robot was moved, so that stays need no distance in time from those before."""
        self._last_stay.clear()

    def clear(self) -> None:
        """Drop all ticks."""
        self._seen.clear()

    def extract_batch(
        self, lesson: Lesson, keys: Sequence[ReadingKey], *, existing: Set[ExampleKey], steady: frozenset[str]
    ) -> WatchedBatch:
        """Convert the ticks to examples of the lesson, thinned to transitions and to stays that are apart in time.

        `existing` has the keys of the examples that the lesson has.
        """
        agreed, last_stay = [], dict(self._last_stay)
        added: set[ExampleKey] = set()
        for tick in self._seen:
            example = tick.example
            if example.next == example.state:
                last = last_stay.get(example.state)
                if last is not None and measure_elapsed(tick.moment.seconds, last) < STAY_APART_S:
                    continue
                last_stay[example.state] = tick.moment.seconds
            alone = ReadingLog(tuple(keys), np.array([tick.moment.values]), np.array([tick.moment.seconds]))
            values = compute_example_values(replace(example, moment=0), lesson, alone, steady=steady)
            example = replace(example, values=values)
            key = make_example_key(example)
            if key not in existing and key not in added:
                added.add(key)
                agreed.append(WatchedTick(tick.moment, example))
        return WatchedBatch(tuple(agreed), last_stay)

    def accept(self, agreed: WatchedBatch) -> None:
        """Note that these have become examples."""
        self._seen.clear()
        self._last_stay = agreed.last_stay
