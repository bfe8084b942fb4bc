"""Pairs of readings that are taken where more is repeated of drives left out of learning, and not otherwise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest
from tests.segmentation.drives import follow, make_drive

from understudy.addons.recordings.drive_kit import list_drive_features, make_candidates, make_drive_kit
from understudy.addons.recordings.lesson_from_drive import DriveLesson, to_lesson
from understudy.addons.recordings.pair_report import PairReport, take_pairs
from understudy.addons.recordings.propose_pairs import (
    is_clearly_better,
    list_fitting_pairs,
    propose_pairs,
)
from understudy.addons.recordings.rerun_drive import LeftOut
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Feature, TimeInState
from understudy.model.library import Library
from understudy.model.value_kinds import BOOLEAN, Column, Continuous, Kind, Toroidal
from understudy.runtime.body import Reading

MOVES = {"forward": {"drive": 0.8}, "back": {"drive": -0.4}}
TICKS = 80
Columns = Mapping[tuple[str, str | None], Column]


def hold(random: np.random.Generator, low: float, high: float, ticks: int) -> Column:
    """Values that jump every eight ticks, and wander a little between."""
    levels = random.uniform(low, high, -(-ticks // 8)).repeat(8)[:ticks]
    return np.asarray(levels + 0.02 * (high - low) * random.standard_normal(ticks))


def draw_readings(seed: int, ticks: int = TICKS) -> Columns:
    """A gap, a speed and two places, of which none tells another."""
    random = np.random.default_rng(seed)
    x = hold(random, 0.0, 100.0, ticks)
    return {
        ("gap", None): hold(random, 5.0, 60.0, ticks),
        ("speed", None): hold(random, 5.0, 30.0, ticks),
        ("x", None): x,
        ("x_ahead", None): x + hold(random, 5.0, 60.0, ticks),
        ("x_behind", None): x - hold(random, 5.0, 60.0, ticks),
    }


UNITS = {"gap": "m", "speed": "m/s", "x": "m", "x_ahead": "m", "x_behind": "m"}
RULES = {  # what the driver goes back by
    "time": lambda each: each["gap", None] / each["speed", None] < 2.0,
    "difference": lambda each: each["x_ahead", None] - each["x", None] < 30.0,
    "time to a place": lambda each: (each["x_ahead", None] - each["x", None]) / each["speed", None] < 2.0,
    "two times": lambda each: (
        np.minimum(each["x_ahead", None] - each["x", None], each["x", None] - each["x_behind", None])
        / each["speed", None]
        < 1.0
    ),
    "gap": lambda each: each["gap", None] < 30.0,
    "either": lambda each: (each["gap", None] < 25.0) | (each["speed", None] < 10.0),
}


def show(
    rule: str, *, drives: int = 6, ticks: int = TICKS, seed: int = 0, units: Mapping[str, str] = UNITS
) -> tuple[Segmentation, Library]:
    """Label drives of a driver who goes back by a rule."""
    shown = [draw_readings(seed + each, ticks) for each in range(drives)]
    back = np.concatenate([RULES[rule](each) for each in shown])
    commands = follow([(-0.4 if each else 0.8, 0.0) for each in back], gain=1.0, seed=seed)
    values = {key: np.concatenate([each[key] for each in shown]) for key in shown[0]}
    readings = [Reading(name, Continuous(), units.get(name, "")) for name, _ in values]
    drive = make_drive(commands, values, readings=readings, lengths=[ticks] * drives)
    episodes = tuple(replace(each, source=f"{number}.csv") for number, each in enumerate(drive.episodes))
    drive = replace(drive, episodes=episodes)
    library = Library(make_drive_kit(drive, MOVES))
    return segment(drive, make_candidates(library, drive)), library


def search(
    found: Segmentation, library: Library, features: Sequence[str] | None = None
) -> tuple[DriveLesson, PairReport]:
    """Learn the lesson of a drive, and take the pairs that are worth it."""

    def make(chosen: Sequence[str | BoundFeature] | None) -> DriveLesson:
        return to_lesson(found, library=library, features=chosen, reaction_s=0.0)

    made = make(features)
    sides = [*made.lesson.automaton.features, *list_drive_features(library, found.drive)]
    return take_pairs(found, made, list(dict.fromkeys(sides)), make)


def list_features(made: DriveLesson) -> list[str]:
    return list(map(str, made.lesson.automaton.features))


@pytest.mark.parametrize(
    ("drives", "ticks", "left_out"), [(6, TICKS, LeftOut.DRIVES), (1, 400, LeftOut.BLOCKS)]
)
def test_a_quotient_is_taken(drives: int, ticks: int, left_out: LeftOut) -> None:
    made, report = search(*show("time", drives=drives, ticks=ticks))
    assert "gap / speed" in list_features(made)
    assert "gap" not in list_features(made)
    row = report.taken[0]
    assert (row.pairs, row.instead_of) == (["gap / speed"], ["gap", "speed"])
    assert row.repeated_before < row.repeated <= report.ticks == drives * ticks
    assert report.repeated / report.ticks > 0.95
    assert report.left_out == left_out
    units = {str(each): each.feature.unit for each in made.lesson.automaton.features}
    assert units["gap / speed"] == "s"


@pytest.mark.parametrize("units", [UNITS, {}])
def test_a_difference_is_taken(units: Mapping[str, str]) -> None:
    made, report = search(*show("difference", units=units))
    assert report.taken[0].pairs == ["x_ahead - x"]
    assert "x_ahead - x" in list_features(made)


def test_a_quotient_of_a_difference_is_found_in_two_steps() -> None:
    made, report = search(*show("time to a place", drives=8, ticks=120))
    assert report.taken[0].pairs == ["x_ahead - x"]
    assert "(x_ahead - x) / speed" in list_features(made)
    assert report.repeated / report.ticks > 0.95


def test_differences_of_one_unit_are_divided_together() -> None:
    """A driver who looks at the times to what is ahead and to what is behind."""
    differences = ["x_ahead - x", "x - x_behind"]
    made, report = search(*show("two times", drives=8, ticks=120), features=differences)
    assert [(each.pairs, each.instead_of) for each in report.taken] == [
        ([f"({each}) / speed" for each in differences], differences)
    ]
    assert list_features(made) == report.taken[0].pairs
    _, sentence = report.list_sentences()
    assert (
        "(x_ahead - x) / speed and (x - x_behind) / speed are features instead of x_ahead - x and x -"
        in sentence
    )


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("rule", ["gap", "either"])
def test_nothing_is_taken_where_readings_alone_decide(rule: str, seed: int) -> None:
    found, library = show(rule, seed=100 * seed)
    made, report = search(found, library)
    assert report.taken == []
    assert list_features(made) == ["gap", "speed", "x", "x_ahead", "x_behind"]
    assert report.tried > 0
    assert report.fitting >= report.tried
    (sentence,) = report.list_sentences()
    assert sentence.startswith(
        f"Of {report.fitting} pairs of readings with fitting units, {report.tried} were tried"
    )
    assert (
        f"clearly more than {report.repeated} of {report.ticks} ticks of drives left out of learning"
        in sentence
    )


def test_what_is_said() -> None:
    _, report = search(*show("time"))
    first, second, *_ = report.list_sentences()
    assert "were tried." in first
    row = report.taken[0]
    assert second == (
        f"gap / speed is a feature instead of gap and speed: with that, {row.repeated} instead of "
        f"{row.repeated_before} of 480 ticks of drives left out of learning are repeated."
    )


def test_each_measurement_is_reported() -> None:
    found, library = show("gap", drives=3)
    made = to_lesson(found, library=library, reaction_s=0.0)
    calls: list[tuple[int, int]] = []
    sides = list_drive_features(library, found.drive)
    done = propose_pairs(found, made, sides, report=lambda done, of: calls.append((done, of)))
    assert done.taken == ()
    assert calls == [(number + 1, len(calls)) for number in range(len(calls))]


def test_pairs_are_about_parameters() -> None:
    """A driver who looks at the time to the ball teaches to look at the time to any target."""
    found, _ = show("time")
    drive = found.drive
    values = {(name, "ball" if name == "gap" else None): column for (name, _), column in drive.values.items()}
    readings = tuple(replace(each, of_targets=each.name == "gap") for each in drive.readings)
    drive = replace(drive, values=values, readings=readings, targets=("ball",))
    library = Library(make_drive_kit(drive, MOVES))
    found, targets = segment(drive, make_candidates(library, drive)), {"A": "ball"}

    def make(features: Sequence[BoundFeature] | None) -> DriveLesson:
        return to_lesson(found, library=library, features=features, reaction_s=0.0, targets=targets)

    made = make(None)
    made, report = take_pairs(found, made, made.lesson.automaton.features, make, targets=targets)
    assert report.taken[0].pairs == ["gap(A) / speed"]
    assert "gap(A) / speed" in list_features(made)
    assert made.lesson.automaton.parameters == ("A",)


def bind(name: str, unit: str, kind: Kind | None = None, target: str | None = None) -> BoundFeature:
    feature = Feature(name, kind or Continuous(), name, unit=unit, of="A" if target else None)
    return BoundFeature(feature, Binding({"A": target}) if target else Binding())


FITTING = [
    ([bind("gap", "m"), bind("speed", "m/s")], ["gap / speed"]),
    ([bind("gap", "m"), bind("length", "m")], ["gap - length", "gap / length", "length / gap"]),
    ([bind("a", ""), bind("b", "")], ["a - b", "a / b", "b / a"]),
    ([bind("gap", "m"), bind("b", "")], []),
    ([bind("gap", "m"), bind("charge", "%")], []),
    ([bind("heading", "rad", Toroidal()), bind("course", "rad", Toroidal())], ["heading - course"]),
    ([bind("heading", "rad", Toroidal()), bind("rate", "rad/s")], []),
    ([bind("ready", "", BOOLEAN), bind("b", ""), BoundFeature(TimeInState())], []),
    (
        [bind("range", "m", target="ball"), bind("range", "m", target="post")],
        ["range(ball) - range(post)", "range(ball) / range(post)", "range(post) / range(ball)"],
    ),
    ([bind("speed", "m/s"), bind("rate", "m/s^2")], ["speed / rate"]),
]


@pytest.mark.parametrize(("sides", "pairs"), FITTING)
def test_pairs_with_fitting_units(sides: list[BoundFeature], pairs: list[str]) -> None:
    assert list(map(str, list_fitting_pairs(sides))) == pairs


def test_quotients_of_differences() -> None:
    sides = [bind("gap", "m"), bind("x", "m"), bind("speed", "m/s")]
    (difference,) = [each for each in list_fitting_pairs(sides) if str(each) == "gap - x"]
    more = set(map(str, list_fitting_pairs([*sides, difference]))) - set(map(str, list_fitting_pairs(sides)))
    assert more == {"(gap - x) / speed", "(gap - x) / gap", "(gap - x) / x"}


CLEAR = [  # ticks repeated before and after of each of ten drives of 10 ticks, whether that is clearly better
    ([8] * 10, [10] * 10, True),
    ([8] * 10, [8] * 10, False),
    ([10] * 10, [10] * 10, False),  # nothing is left to gain
    ([8] * 10, [9] * 4 + [8] * 6, False),  # a fifth of what was not repeated
    ([8] * 10, [10, 10, 10] + [8] * 7, False),  # three of three drives gain: that may be chance
    ([8] * 10, [10, 10, 10, 10] + [8] * 6, True),
    ([8] * 10, [10, 10, 10, 10, 7, 7] + [8] * 4, False),  # four gain and two lose
    ([5] * 10, [10] + [5] * 9, False),  # one drive tells nothing of others
    ([8] * 10, [6] * 10, False),
]


@pytest.mark.parametrize(("before", "after", "clear"), CLEAR)
def test_what_is_clearly_better(before: list[int], after: list[int], clear: bool) -> None:
    found, _ = show("gap", drives=10, ticks=16)
    ticks = 16
    repeated = [
        np.concatenate([np.arange(ticks) >= ticks - count for count in counts]) for counts in (before, after)
    ]
    labels = np.zeros(10 * ticks, np.int64)
    labels.reshape(10, ticks)[:, : ticks - 10] = len(found.candidates)
    assert is_clearly_better(replace(found, labels=labels), *repeated) is clear
