"""How late presses come, found out from the record: scripted demonstrators whose reaction time is known."""

from __future__ import annotations

import re
from dataclasses import replace
from math import nan
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.bodies import Scripted
from tests.make.sessions import make_session, play

from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Feature, ReadingKey, TimeInState
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Example, ExampleKind, Lesson, ReadingLog
from understudy.model.value_kinds import BOOLEAN, Continuous, Kind, Toroidal
from understudy.training.feature_values import list_steady_readings
from understudy.training.reaction_time import estimate_reaction_time
from understudy_lab.novices.novice import Novice, draw_traits


def demonstrate(
    late_s: float, presses: int = 20, *, kind: Kind = Continuous(), seed: int = 1, spread_s: float = 0.03
) -> Lesson:
    """Presses for `done` when x falls below 2, each so late, at speeds from 0.2/s to 1/s; y is by the way.

    An angle crosses the seam instead.
    """
    draws = np.random.default_rng(seed)
    before = np.arange(-10, 1) / 10
    values, seconds, examples = [], [], []
    for number in range(presses):
        x = -draws.uniform(0.2, 1.0) * (before + draws.normal(late_s, spread_s))
        x = np.mod(x, kind.period) if isinstance(kind, Toroidal) else 2.0 + x
        y = draws.uniform(0, 5) + draws.uniform(-1, 1) * before
        values.append(np.column_stack([x, y]))
        seconds.append(100 * number + before)
        shown = (float(x[-1]), float(y[-1]))
        kinds = ExampleKind.DIRECTIVE
        examples.append(Example(number, "go", shown, "done", kinds, moment=11 * number + 10, window=10))
    features = tuple(
        BoundFeature(Feature(name, each, reading=name, unit="m"))
        for name, each in (("x", kind), ("y", Continuous()))
    )
    automaton = Automaton("taught", (START, State("go", "go"), State("done", flag="done")), features)
    record = ReadingLog((("x", None), ("y", None)), np.vstack(values), np.concatenate(seconds))
    return Lesson(automaton, tuple(examples), record=record)


@pytest.mark.parametrize("kind", [Continuous(), Toroidal()])
@pytest.mark.parametrize("late_s", [0.0, 0.1, 0.3, 0.5, 0.7])
def test_a_known_reaction_time_is_found(late_s: float, kind: Kind) -> None:
    found = estimate_reaction_time(demonstrate(late_s, kind=kind))
    assert found is not None
    assert found.reaction_s == pytest.approx(late_s, abs=0.051)
    assert found.presses == 20
    assert found.least_s <= late_s <= found.most_s
    assert found.most_s - found.least_s == pytest.approx(0.2, abs=0.11)


@pytest.mark.parametrize("kind", [Continuous(), Toroidal()])
def test_the_evidence_says_how_far_apart(kind: Kind) -> None:
    """Who is 0.03 s off on either side, at 0.6 m/s, is about 2 cm off; half of what a tick changes comes on top. Who
    is 0.3 s late at between 0.2 and 1 m/s, is 10 cm off."""
    then, now = re.findall(r"(0\.\d+) m", str(estimate_reaction_time(demonstrate(0.3, kind=kind))))
    assert float(then) == pytest.approx(0.03, abs=0.015)
    assert float(now) == pytest.approx(0.1, abs=0.05)


def test_even_of_a_machine() -> None:
    """None undercuts half of what a tick changes, so that a single shift that fits to the digit is not everything."""
    found = estimate_reaction_time(demonstrate(0.3, spread_s=0.0))
    assert found is not None
    assert found.reaction_s == 0.3


def test_what_tells_most_is_the_evidence() -> None:
    """Three sorts of presses, one of them by somebody who hardly knows what they want."""
    parts = [
        demonstrate(0.3, 10, spread_s=0.2, seed=4),
        demonstrate(0.3, 10, seed=5),
        demonstrate(0.3, 6, seed=6),
    ]
    examples: list[Example] = []
    values: list[NDArray[np.float64]] = []
    seconds: list[NDArray[np.float64]] = []
    for part, state in zip(parts, ("go", "on", "by"), strict=True):
        rows = sum(len(each) for each in seconds)
        examples += [replace(each, state=state, moment=(each.moment or 0) + rows) for each in part.examples]
        values.append(part.record.values)
        seconds.append(part.record.seconds)
    record = ReadingLog(parts[0].record.keys, np.vstack(values), np.concatenate(seconds))
    found = estimate_reaction_time(replace(parts[0], examples=tuple(examples), record=record))
    assert found is not None
    assert found.presses == 26
    assert "the 10 presses from on to done" in found.evidence


def test_the_evidence_says_by_what() -> None:
    late = str(estimate_reaction_time(demonstrate(0.3)))
    assert late.startswith("Taken 0.3 s earlier, the 20 presses from go to done lie about 0.0")
    assert " by x, instead of 0.0" in late
    assert str(estimate_reaction_time(demonstrate(0.0))).endswith(
        "hardly agree better at any earlier moment: they do not seem late."
    )


def test_the_evidence_speaks_of_angles_in_degrees() -> None:
    """As everything else that people read: 0.3 rad are 17 degrees."""
    lesson = demonstrate(0.3, kind=Toroidal())
    angle, aside = lesson.automaton.features
    bound = BoundFeature(Feature("x", angle.kind, reading="x", unit="rad"))
    features = replace(lesson.automaton, features=(bound, aside))
    said = str(estimate_reaction_time(replace(lesson, automaton=features)))
    meters = str(estimate_reaction_time(lesson))
    then, now = (float(each) for each in re.findall(r"([\d.]+)°", said))
    radians = [float(each) for each in re.findall(r"(0\.\d+) m", meters)]
    assert "rad" not in said
    assert [then, now] == pytest.approx(np.degrees(radians), rel=0.05)


def test_too_little_gives_no_estimate() -> None:
    assert estimate_reaction_time(demonstrate(0.3, presses=7)) is None
    lesson = demonstrate(0.3)
    of_many_sorts = tuple(replace(each, next=f"to {each.number % 7}") for each in lesson.examples)
    assert estimate_reaction_time(replace(lesson, examples=of_many_sorts)) is None
    assert estimate_reaction_time(Lesson(demonstrate(0.3).automaton)) is None
    assert estimate_reaction_time(make_session().lesson) is None


def test_who_is_not_clearly_late_is_not_told_so() -> None:
    """Presses that were 0.05 s late agree a little better 0.1 s before. Where they vary by 0.1 s, nobody can tell."""
    found = estimate_reaction_time(demonstrate(0.05, 12, seed=3))
    assert found is not None
    assert (found.reaction_s, found.least_s) == (0.0, 0.0)
    assert found.evidence.endswith("they do not seem late.")
    assert estimate_reaction_time(demonstrate(0.05, 8, spread_s=0.1, seed=4)) is None


def test_what_never_scatters_gives_no_estimate() -> None:
    """At one speed every shift agrees as well as any other."""
    taught = make_session(body=Scripted())
    for _ in range(10):
        play(taught, "forward", 12, "left", 1)
        taught.reset(0)
    assert estimate_reaction_time(taught.lesson, steady=list_steady_readings(taught.body)) is None


def test_what_is_in_quarantine_edited_or_without_record_says_nothing() -> None:
    lesson = demonstrate(0.3)
    changes: tuple[dict[str, Any], ...] = (
        {"quarantined": "slipped"},
        {"edited": True},
        {"moment": None},
        {"window": 7},
        {"kind": ExampleKind.CONFIRMATION},
    )
    for change in changes:
        examples = tuple(replace(each, **change) for each in lesson.examples)
        assert estimate_reaction_time(replace(lesson, examples=examples)) is None


def test_what_is_steady_is_not_shifted() -> None:
    assert estimate_reaction_time(demonstrate(0.3), steady=frozenset({"x", "y"})) is None


def test_the_reaction_time_a_lesson_has_makes_no_difference() -> None:
    lesson = demonstrate(0.3)
    assert estimate_reaction_time(
        replace(lesson, options=LearnerOptions(reaction_s=0.5))
    ) == estimate_reaction_time(lesson)


def log_of(
    log: ReadingLog,
    *,
    keys: tuple[ReadingKey, ...] | None = None,
    values: NDArray[np.float64] | None = None,
) -> ReadingLog:
    """Make a log that differs from another in its keys or values."""
    return ReadingLog(
        log.keys if keys is None else keys, log.values if values is None else values, log.seconds
    )


def test_absence_tells_of_no_boundary() -> None:
    """Of a thing that comes into sight a moment before the press, the moment before that is out of sight."""
    lesson = demonstrate(0.3)
    values = lesson.record.values.copy()
    values[values[:, 0] > 2.3, 0] = nan
    found = estimate_reaction_time(replace(lesson, record=log_of(lesson.record, values=values)))
    assert found is not None
    assert found.reaction_s == pytest.approx(0.3, abs=0.051)


def test_whatever_a_parameter_stood_for() -> None:
    """Half of the presses were for one target, half for the other, which was elsewhere then."""
    lesson = demonstrate(0.3)
    values = np.column_stack([lesson.record.values[:, 0], 50 * np.sin(7.0 * np.arange(len(lesson.record)))])
    values[len(values) // 2 :] = values[len(values) // 2 :, ::-1]
    near = Feature("near", Continuous(), reading="range", of="what")
    automaton = replace(
        lesson.automaton, features=(BoundFeature(near, Binding(what="A")),), parameters=("A",)
    )
    examples = tuple(
        replace(each, values=each.values[:1], binding=Binding(A="ball" if each.number < 10 else "goal"))
        for each in lesson.examples
    )
    record = ReadingLog((("range", "ball"), ("range", "goal")), values, lesson.record.seconds)
    found = estimate_reaction_time(replace(lesson, automaton=automaton, examples=examples, record=record))
    assert found is not None
    assert found.reaction_s == pytest.approx(0.3, abs=0.051)
    assert "from go to done lie about 0.0" in found.evidence


def test_what_never_changes_says_nothing() -> None:
    lesson = demonstrate(0.3)
    values = lesson.record.values.copy()
    values[:, 1] = 5.0
    found = estimate_reaction_time(replace(lesson, record=log_of(lesson.record, values=values)))
    assert found == estimate_reaction_time(lesson)


def test_labels_and_what_is_the_automatons_own_say_nothing() -> None:
    lesson = demonstrate(0.3)
    seen = np.where(np.tile(np.arange(11) > 7, 20), np.repeat(np.arange(20) % 2, 11), 0.0)[:, None]
    record = ReadingLog(
        (*lesson.record.keys, ("seen", None)), np.hstack([lesson.record.values, seen]), lesson.record.seconds
    )
    more = (BoundFeature(Feature("seen", BOOLEAN, reading="seen")), BoundFeature(TimeInState()))
    automaton = replace(lesson.automaton, features=(*lesson.automaton.features, *more))
    examples = tuple(
        replace(each, values=(*each.values, 0.0, 1.0), own={"time_in_state": 1.0}) for each in lesson.examples
    )
    assert estimate_reaction_time(
        replace(lesson, automaton=automaton, examples=examples, record=record)
    ) == estimate_reaction_time(lesson)
    only = replace(lesson.automaton, features=more[:1])
    assert estimate_reaction_time(replace(lesson, automaton=only, record=record)) is None


def test_what_was_not_recorded_says_nothing() -> None:
    """A feature whose reading the body of that time did not have; another one still tells."""
    lesson = demonstrate(0.3)
    record = log_of(lesson.record, keys=(("x", None), ("z", None)))
    assert estimate_reaction_time(replace(lesson, record=record)) == estimate_reaction_time(lesson)
    assert (
        estimate_reaction_time(replace(lesson, record=log_of(record, keys=(("w", None), ("z", None)))))
        is None
    )


def test_a_novice_who_reacts_in_half_a_second() -> None:
    traits = draw_traits(1)
    taught = Novice(traits, 1).teach()
    assert taught.lesson is not None
    found = estimate_reaction_time(taught.lesson)
    assert found is not None
    assert found.reaction_s == pytest.approx(traits.reaction_s, abs=0.15)


def test_counts_say_nothing_about_how_late_presses_are() -> None:
    """At most presses, a count has just become 12; some come a tick before. A second earlier, it is 11 at all."""
    rows, seconds, examples = [], [], []
    for number in range(16):
        count = [11.0] * 10 + [12.0 if number % 4 else 11.0]
        rows.append(np.array(count)[:, None])
        seconds.append(100 * number + np.arange(-10, 1) / 10)
        kind = ExampleKind.DIRECTIVE
        examples.append(Example(number, "go", (count[-1],), "done", kind, moment=11 * number + 10, window=10))
    feature = BoundFeature(Feature("count", Continuous(), reading="count", unit="units"))
    automaton = Automaton("taught", (START, State("go", "go"), State("done", flag="done")), (feature,))
    record = ReadingLog((("count", None),), np.vstack(rows), np.concatenate(seconds))
    assert estimate_reaction_time(Lesson(automaton, tuple(examples), record=record)) is None
