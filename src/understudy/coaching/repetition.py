"""Repetition: a robot that stays in one state and comes back to the same situation again and again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.lesson_analysis import FeatureDistances
from understudy.coaching.reasons_to_ask import DoubtReason, Uncertainty
from understudy.coaching.situation_sampling import stack_example_vectors
from understudy.coaching.situation_text import make_feature_phrases
from understudy.model.lesson import Lesson

AWAY = 3.0
"""The distance, in largest steps between two moments, beyond which the robot has left a situation."""
PARTS = 4
"""The number of parts of a round. The robot asks in another part in each round, until the lesson changes."""
LOOK_S = 0.5
"""The time between two looks at whether a robot repeats itself, s."""
GAP_S = 1.0
"""A stay that was not observed for longer than this begins again, s."""


def find_repetition(values: NDArray[np.float64], distances: FeatureDistances) -> range | None:
    """Find the moments between which a robot has come back to its first situation for the second time.

    Whether it is back is judged by the largest step between two moments, so that no feature needs a threshold. A robot
    whose features hardly change does not repeat anything: it may well have to wait.

    Parameters
    ----------
    values
        The feature vectors [n, F] of successive moments, all in the same state.
    distances
        The distances between feature vectors.

    Returns
    -------
    range or None
        The indices of the moments of the second round; None if the robot does not come back twice.
    """
    if len(values) == 0:
        return None
    step = float(distances.compute(values[1:], values[:-1]).max(initial=0.0))
    first, away = None, False
    for moment, distance in enumerate(distances.compute(values, values[0]).tolist()):
        if distance > AWAY * step:
            away = True
        elif away and distance <= step:
            if first is not None:
                return range(first, moment)
            first, away = moment, False
    return None


def choose_moment(lesson: Lesson, state: str, values: NDArray[np.float64], count: int) -> int:
    """Choose the moment of a round at which to ask what the robot should do.

    It is the moment most like an example that leaves the state, and after each question a part of the round later, so
    that the questions go around: what was right at one moment says nothing about the others.

    Parameters
    ----------
    lesson
        The lesson.
    state
        The state in which the robot stays.
    values
        The feature vectors [n, F] of a round.
    count
        How often it was asked in this state.

    Returns
    -------
    int
        The index of the moment.
    """
    exits = [example.values for example in lesson.examples if example.state == state != example.next]
    nearest = 0
    if exits:
        apart = make_lesson_distances(lesson).compute(values[:, None], np.array(exits))
        nearest = int(apart.min(axis=1).argmin())
    return (nearest + count * len(values) // PARTS) % len(values)


def describe_repetition(state: str, seconds: float) -> Uncertainty:
    """Return the doubt about a robot that has stayed in a state for a time, s, and comes back to where it was."""
    reason = f"I have been in {state} for {seconds:.0f} s, and come back to where I was"
    return Uncertainty(1.0, DoubtReason.REPEATING, reason)


class RepetitionWatch:
    """A watch over a robot with one lesson, tick by tick: where it repeats itself, and when to ask about that.

    The robot is asked about once in each round, a part of the round later each time, until the whole round was asked
    about. Going on is an answer for one moment only.
    """

    def __init__(self, lesson: Lesson) -> None:
        self._lesson, self._distances = lesson, make_lesson_distances(lesson)
        self._asked: Counter[str] = Counter()
        self._begin("", 0.0)

    def _begin(self, state: str, time_s: float) -> None:
        self._state, self._looked_s = state, time_s
        self._times: list[float] = []
        self._values: list[Sequence[float]] = []
        self._due_s, self._round_s = np.inf, 0.0

    def observe(self, time_s: float, state: str, values: Sequence[float]) -> None:
        """Observe the robot before a tick."""
        last_s = self._times[-1] if self._times else time_s
        if state != self._state or not 0.0 <= time_s - last_s <= GAP_S:  # another stay, or another world
            self._begin(state, time_s)
        self._times.append(time_s)
        self._values.append(values)
        if self._due_s < np.inf:
            while time_s > self._due_s + LOOK_S:  # nothing could be asked then
                self._due_s += self._round_s
        elif time_s - self._looked_s >= LOOK_S and not self.was_asked_about(state):
            self._looked_s = time_s
            self._look(time_s)

    def _look(self, now: float) -> None:
        """Find out whether the robot repeats itself, and when it will be where to ask."""
        rows = np.array(self._values, np.float64).reshape(len(self._values), -1)
        moments = find_repetition(rows, self._distances)
        if moments is None:
            return
        count = self._asked[self._state]
        moment = moments[choose_moment(self._lesson, self._state, rows[moments.start : moments.stop], count)]
        self._round_s = self._times[moments.stop] - self._times[moments.start]
        self._due_s = self._times[moment] + self._round_s
        while self._due_s < now - LOOK_S:
            self._due_s += self._round_s

    def find_doubt(self) -> Uncertainty | None:
        """Return the doubt if the robot repeats itself and is where to ask about that; None otherwise."""
        if not self._times or self._times[-1] < self._due_s - 1e-9 or self.was_asked_about(self._state):
            return None
        return describe_repetition(self._state, self._times[-1] - self._times[0])

    def note_asked(self, state: str) -> None:
        """Note that it was asked why the robot repeats itself in a state."""
        self._asked[state] += 1
        if state == self._state and self._due_s < np.inf:
            self._due_s += self._round_s * (1 + 1 / PARTS)

    def count_asked(self, state: str) -> int:
        """Return how often it was asked why the robot repeats itself in a state."""
        return self._asked[state]

    def was_asked_about(self, state: str) -> bool:
        """Return whether a whole round in a state was asked about."""
        return self._asked[state] >= PARTS


def make_lesson_distances(lesson: Lesson) -> FeatureDistances:
    """Make the distances between feature vectors of a lesson's automaton, with all features weighed alike."""
    vectors = stack_example_vectors(lesson)
    return FeatureDistances(make_feature_phrases(lesson.automaton.features, vectors), None)
