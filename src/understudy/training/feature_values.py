"""Values of a lesson's features, computed from its record.

The same function serves a new press, a feature that was added later, and a changed reaction time.
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
from understudy.model.lesson import Example, Lesson, ReadingLog
from understudy.model.library import Kit
from understudy.model.value_kinds import NO, Categorical
from understudy.runtime.body import Body
from understudy.runtime.feature_columns import read_feature_column
from understudy.runtime.interpreter import RunningAutomaton, measure_elapsed


def list_steady_readings(body: Body) -> frozenset[str]:
    """List the readings that a reaction time never shifts: categorical ones, which are events rather than motion."""
    return frozenset(reading.name for reading in body.readings if isinstance(reading.kind, Categorical))


def list_steady_kit_readings(kit: Kit) -> frozenset[str]:
    """List the readings of a kit's features that a reaction time never shifts, where no body is there to ask."""
    features = (each for each in kit.features.values() if isinstance(each, Feature))
    return frozenset(each.reading or "" for each in features if isinstance(each.kind, Categorical))


def collect_own_values(machine: RunningAutomaton, now: float) -> dict[str, float]:
    """Collect the present values of own features: flags of the running behavior, counters, timers, time in state."""
    own = {f"counter {name}": value for name, value in machine.counters.items()}
    own |= {f"timer {name}": measure_elapsed(now, since) for name, since in machine.timers.items()}
    own["time_in_state"] = measure_elapsed(now, machine.entered)
    if machine.active.flag is not None:
        own[f"flag {machine.active.flag}"] = 1.0
    return own


def find_own_value(feature: AnyFeature, own: Mapping[str, float]) -> float | None:
    """Find the value of an automaton's own feature among recorded ones; None for a feature of the body.

    A feature that a switch resets is an own feature in the tick in which its state was entered.
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
    """Compute the present values of features, by label, for one agent with these targets of parameters."""
    values_by_label = {}
    for bound in features:
        value = find_own_value(bound.feature, own)
        if value is None:
            ground = BoundFeature(bound.feature, bound.binding.substitute(targets))
            value = float(read_feature_column(ground, percept, agents=body.agents)[agent])
        values_by_label[str(bound)] = value
    return values_by_label


def compute_example_values(
    example: Example, lesson: Lesson, record: ReadingLog, *, steady: frozenset[str]
) -> tuple[float, ...]:
    """Compute the values of the lesson's features at an example's moment; `steady` readings are never shifted.

    SessionError if the moment was not recorded.
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
    """Get the snapshot at an example's moment; for a press, with the readings that move taken `reaction_s` earlier."""
    row, shifted = example.moment or 0, find_shifted_row(example, record, reaction_s)
    return {
        key: record.values[row if key[0] in steady else shifted, column : column + 1]
        for column, key in enumerate(record.keys)
    }


def find_shifted_row(example: Example, record: ReadingLog, reaction_s: float) -> int:
    """Find the row of the record nearest to `reaction_s`, or its own reaction time, before the moment of a press."""
    row = example.moment or 0
    reaction_s = reaction_s if example.reaction_s is None else example.reaction_s
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
    """Return the new lesson with the values of its examples computed again from the record.

    Values that were typed or edited stay, for the features that stay.
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
