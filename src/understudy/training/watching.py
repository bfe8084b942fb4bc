"""Watching: silence is consent. Ticks that the demonstrator saw and let pass become watched examples.

Rules (1) to (3) of ARCHITECTURE section 3, 'Watched examples'; rule (4) is the learner's.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from understudy.model.example import Example
from understudy.model.lesson import Lesson, Record
from understudy.training.recorder import Moment, Recorder
from understudy.training.values import values_of

STAY_APART_S = 0.3
SHORTEST_DOUBT_S = 0.4
REACTION_MARGIN_S = 0.2


@dataclass(frozen=True, slots=True)
class Seen:
    """One tick that nobody objected to so far."""

    moment: Moment
    example: Example  # without values, row or number yet


class Watching:
    """The ticks seen since the last press, and which of them become examples."""

    def __init__(self) -> None:
        self._seen: list[Seen] = []
        self._last_stay: dict[str, float] = {}

    def see(self, seen: Seen) -> None:
        """A tick passed in silence."""
        self._seen.append(seen)

    def doubt(self, now: float, *, reaction_s: float, flagged: float = inf) -> None:
        """A press came: what happened just before it was not agreed to, nor a flag it corrects, raised at `flagged`."""
        limit = min(now - max(SHORTEST_DOUBT_S, reaction_s + REACTION_MARGIN_S), flagged - 1e-6)
        self._seen = [seen for seen in self._seen if seen.moment.seconds <= limit + 1e-9]

    def begin_episode(self) -> None:
        """The robot is elsewhere: stays need not be apart from those before."""
        self._last_stay.clear()

    def forget(self) -> None:
        """Drop what was seen."""
        self._seen.clear()

    def accept(self, lesson: Lesson, recorder: Recorder, *, steady: frozenset[str]) -> tuple[Example, ...]:
        """What was seen becomes examples of the lesson, thinned: transitions, and stays apart in time."""
        accepted: list[Example] = []
        number = max((example.number for example in lesson.examples), default=0)
        known = {_key(example.state, example.values) for example in lesson.examples}
        for seen in self._seen:
            example = seen.example
            if example.next == example.state:
                last = self._last_stay.get(example.state, -1e9)
                if seen.moment.seconds - last < STAY_APART_S - 1e-9:
                    continue
                self._last_stay[example.state] = seen.moment.seconds
            alone = Record(recorder.keys, np.array([seen.moment.values]), np.array([seen.moment.seconds]))
            values = values_of(replace(example, moment=0), lesson, alone, steady=steady)
            if _key(example.state, values) in known:
                continue
            known.add(_key(example.state, values))
            number += 1
            accepted.append(replace(example, number=number, values=values, moment=recorder.keep(seen.moment)))
        self._seen.clear()
        return tuple(accepted)


def _key(state: str, values: tuple[float, ...]) -> tuple[str | float | None, ...]:
    return (state, *(None if value != value else value for value in values))
