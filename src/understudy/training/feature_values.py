"""From what was recorded to what a lesson's features were then: how examples get, and regain, their values.

The same function serves a fresh press, a feature added later, and a reaction time changed afterwards.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import nan

import numpy as np

from understudy.errors import SessionError
from understudy.model.features import (
    AnyFeature,
    BoundFeature,
    CounterFeature,
    Feature,
    FlagFeature,
    Percept,
    TimerFeature,
)
from understudy.model.kinds import NO, Categorical
from understudy.model.lesson import Example, Lesson, ReadingLog
from understudy.runtime.body import Body
from understudy.runtime.feature_columns import read_feature_column
from understudy.runtime.interpreter import RunningAutomaton, measure_elapsed


def list_steady_readings(body: Body) -> frozenset[str]:
    """The readings of a body that a reaction time never shifts: categories, which are events rather than motion."""
    return frozenset(reading.name for reading in body.readings if isinstance(reading.kind, Categorical))


def collect_own_values(machine: RunningAutomaton, now: float) -> dict[str, float]:
    """What own features could read now: flag of what the automaton runs, counters, timers, time in state."""
    own = {f"counter {name}": value for name, value in machine.counters.items()}
    own |= {f"timer {name}": measure_elapsed(now, since) for name, since in machine.timers.items()}
    own["time_in_state"] = measure_elapsed(now, machine.entered)
    if machine.active.flag is not None:
        own[f"flag {machine.active.flag}"] = 1.0
    return own


def find_own_value(feature: AnyFeature, own: Mapping[str, float]) -> float | None:
    """The value of an automaton's own feature among its recorded own readings; None for one of the body.

    What a switch changes is the automaton's own in the tick in which its state was entered.
    """
    if isinstance(feature, Feature):
        return feature.fresh if own.get("time_in_state") == 0.0 else None
    if isinstance(feature, FlagFeature):
        return own.get(f"flag {feature.name}", NO)
    if isinstance(feature, CounterFeature):
        return own.get(f"counter {feature.name}", 0.0)
    if isinstance(feature, TimerFeature):
        return own.get(f"timer {feature.name}", nan)
    return own.get("time_in_state", nan)


def compute_feature_values(
    features: Sequence[BoundFeature],
    own: Mapping[str, float],
    targets: Mapping[str, str],
    percept: Percept,
    body: Body,
    agent: int,
) -> dict[str, float]:
    """The values of features now, by their labels, for one agent whose parameters stand for these targets."""
    found = {}
    for bound in features:
        value = find_own_value(bound.feature, own)
        if value is None:
            ground = BoundFeature(bound.feature, bound.binding.substitute(targets))
            value = float(read_feature_column(ground, percept, agents=body.agents)[agent])
        found[str(bound)] = value
    return found


def compute_example_values(
    example: Example, lesson: Lesson, record: ReadingLog, *, steady: frozenset[str]
) -> tuple[float, ...]:
    """The values of the lesson's features at an example's moment; `steady` readings (categories) are never
    shifted.

    SessionError where the moment was not recorded.
    """
    if example.moment is None:
        raise SessionError(
            f"example {example.number} of {lesson.name!r} was written by hand, without readings around it; "
            "delete it, or keep the features it was written for"
        )
    percept = get_shifted_percept(example, record, reaction_s=lesson.options.reaction_s, steady=steady)
    return tuple(_value(bound, example, percept) for bound in lesson.automaton.features)


def get_shifted_percept(
    example: Example, record: ReadingLog, *, reaction_s: float, steady: frozenset[str]
) -> Percept:
    """The snapshot of an example's moment, its shiftable readings taken `reaction_s` earlier if a press made
    it.
    """
    row, shifted = example.moment or 0, find_shifted_row(example, record, reaction_s)
    return {
        key: record.values[row if key[0] in steady else shifted, column : column + 1]
        for column, key in enumerate(record.keys)
    }


def find_shifted_row(example: Example, record: ReadingLog, reaction_s: float) -> int:
    """The row of the record nearest to `reaction_s` before an example's moment, if a press made it."""
    row = example.moment or 0
    if not (example.is_from_press and reaction_s > 0 and example.window > 0):
        return row
    seconds = record.seconds[row - example.window : row + 1]
    distance = np.abs(seconds - (seconds[-1] - reaction_s))
    return row - example.window + int(np.argmin(np.round(distance, 9)))


def _value(bound: BoundFeature, example: Example, percept: Percept) -> float:
    own = find_own_value(bound.feature, example.own)
    if own is not None:
        return own
    ground = BoundFeature(bound.feature, bound.binding.substitute(example.binding))
    return float(read_feature_column(ground, percept, agents=1)[0])


def recompute_example_values(
    old: Lesson, new: Lesson, record: ReadingLog, *, steady: frozenset[str]
) -> Lesson:
    """The new lesson with its examples' values, which are still the old one's, computed again from the
    record.

    What was written or edited by hand stays as it is, for the features that stay.
    """
    places = [_place(bound, old) for bound in new.automaton.features]
    examples = []
    for example in new.examples:
        by_hand = example.edited or example.moment is None
        if by_hand and None not in places:
            values = tuple(example.values[place] for place in places if place is not None)
        else:
            values = compute_example_values(example, new, record, steady=steady)
            if by_hand:
                values = tuple(
                    value if place is None else example.values[place]
                    for place, value in zip(places, values, strict=True)
                )
        examples.append(replace(example, values=values))
    return replace(new, examples=tuple(examples))


def _place(bound: BoundFeature, lesson: Lesson) -> int | None:
    features = lesson.automaton.features
    return features.index(bound) if bound in features else None
