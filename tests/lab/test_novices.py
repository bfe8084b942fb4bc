"""Some novices beside what was published; what they are like, and what they press, by hand."""

from __future__ import annotations

from dataclasses import replace
from math import nan
from typing import Any

import pytest
from tests.lab.test_servoing import make_view
from tests.make.lessons import make_lesson

from understudy.learning.fit import learn_automaton
from understudy.model.library import TrainedAutomaton
from understudy_lab.novices import study
from understudy_lab.novices.failure_causes import (
    FINDS,
    RESTS,
    SWINGS,
    WALKS_ON,
    classify_blind_behavior,
    count_turn_backs,
    has_succeeded,
    list_blind_states,
    succeeds_everywhere,
)
from understudy_lab.novices.novice import (
    ALIKE,
    MINUTES_S,
    MISTAKES,
    PARAMETERS,
    RANGES,
    SITUATIONS,
    UNDERSTOOD,
    Novice,
    draw_traits,
    make_shared_traits,
)
from understudy_lab.novices.sensitivity import SAID
from understudy_lab.results import differences, load_published
from understudy_lab.runner import row_of
from understudy_lab.statistics import apply_holm_correction, pairs_differ, shares_differ
from understudy_lab.tasks.soccer import POSITIONS

TASKS = [{"seed": study.SEEDS[0]}, {"seed": study.SEEDS[1], "trait": "lapses", "factor": 1.5}]


@pytest.mark.retrains
@pytest.mark.parametrize("task", TASKS)
def test_some_are_as_published(task: dict[str, Any]) -> None:
    known = load_published("novices")
    assert known is not None
    row = row_of(study.EXPERIMENT, task)
    assert differences([row], known, study.EXPERIMENT) == []
    assert known.rows[0]["task"] == TASKS[0]


def test_traits_are_within_their_ranges() -> None:
    all_ = [draw_traits(seed) for seed in range(300)]
    for name in ("reaction_s", "slips", "lapses", "misjudged", "off_middle_px"):
        least, most, _ = RANGES[name]
        found = [getattr(traits, name) for traits in all_]
        assert least <= min(found) < max(found) <= most
    assert all(traits.situations and set(traits.situations) <= set(SITUATIONS) for traits in all_)
    mistaken = [traits.mistake for traits in all_ if traits.mistake != UNDERSTOOD]
    assert set(mistaken) == set(MISTAKES)
    assert 0.12 < len(mistaken) / len(all_) < 0.28


def test_a_changed_trait_changes_nothing_else() -> None:
    for seed in range(20):
        before, after = draw_traits(seed), draw_traits(seed, scaled={"slips": 1.5})
        assert after.slips == pytest.approx(1.5 * before.slips)
        assert replace(after, slips=before.slips) == before


@pytest.mark.parametrize("name", PARAMETERS)
def test_every_parameter_can_be_changed(name: str) -> None:
    assert name in SAID
    assert make_shared_traits({}) == ALIKE
    changed = [(draw_traits(seed, scaled={name: 1.5}), make_shared_traits({name: 1.5})) for seed in range(40)]
    assert changed != [(draw_traits(seed), ALIKE) for seed in range(40)]


PLAIN = replace(
    draw_traits(0), mistake=UNDERSTOOD, edge_px=0.0, off_middle_px=0.0, search="right", misjudged=0.0
)
PRESSED = [  # what they misunderstood, the screens they see, what they would have last
    (UNDERSTOOD, [("start", nan)], "right"),
    (UNDERSTOOD, [("start", 20.0)], "forwardL"),
    (UNDERSTOOD, [("start", 20.0), ("forwardL", nan)], "left"),
    (UNDERSTOOD, [("right", 30.0), ("right", nan)], "left"),  # turned past it
    ("other side", [("start", 20.0)], "forwardR"),
    ("one only", [("start", 150.0)], "forwardL"),
]


@pytest.mark.parametrize(("mistake", "screens", "wished"), PRESSED)
def test_what_a_novice_wants(mistake: str, screens: list[tuple[str, float]], wished: str) -> None:
    novice = Novice(replace(PLAIN, mistake=mistake), 0)
    assert [novice.wish(make_view(*screen)) for screen in screens][-1] == wished


def test_who_misjudges_thinks_it_is_there_too_early() -> None:
    good, bad = Novice(PLAIN, 0), Novice(replace(PLAIN, misjudged=0.5), 0)
    view = make_view("forwardL", 80.0, 2500.0)
    assert (good.there(view), bad.there(view)) == (False, True)


def test_five_minutes_and_no_more() -> None:
    novice = Novice(draw_traits(1000), 1000)
    assert novice.teach().lesson is not None
    assert novice.seconds == pytest.approx(MINUTES_S, abs=0.2)
    assert novice.presses > 10


def make_row(left: int, hidden: int, right: int) -> dict[str, Any]:
    """A row in which so many of ten trials from each position reach the ball."""
    times = {
        name: [12.0] * n + [None] * (10 - n) for name, n in zip(POSITIONS, (left, hidden, right), strict=True)
    }
    return {"task": {"seed": 0}, "times": times, "reached": left + hidden + right}


SUCCESSES = [
    ((10, 10, 10), True, True),
    ((10, 0, 5), True, False),
    ((5, 5, 4), False, False),
    ((5, 5, 5), True, True),
]


@pytest.mark.parametrize(("reached", "half", "each"), SUCCESSES)
def test_success(reached: tuple[int, int, int], half: bool, each: bool) -> None:
    assert (has_succeeded(make_row(*reached)), succeeds_everywhere(make_row(*reached))) == (half, each)


PRESSED_BACK = [  # examples with nothing seen, what it then goes through, turns pressed back
    ([("start", "left", "directive"), ("left", "left", "default")], ["start", "left"], (0, 0)),
    (
        [("start", "left", "directive"), *[("left", "left", "default")] * 9, ("left", "right", "directive")],
        ["start", "left", "right"],  # nine that were recorded by themselves are outvoted
        (1, 0),
    ),
    (
        [("start", "left", "directive"), ("left", "right", "directive"), ("right", "left", "directive")],
        ["start", "left", "right", "left"],
        (1, 1),
    ),
]


@pytest.mark.parametrize(("shown", "states", "back"), PRESSED_BACK)
def test_what_a_robot_does_while_it_sees_nothing(
    shown: list[tuple[str, str, str]], states: list[str], back: tuple[int, int]
) -> None:
    made = make_lesson([(before, [nan], after, kind) for before, after, kind in shown])
    taught = TrainedAutomaton(learn_automaton(made), made)
    assert list_blind_states(taught) == states
    assert count_turn_backs(taught) == {"left": back[0], "right": back[1]}


DOES = [
    (["start"], RESTS),
    (["start", "forwardL"], WALKS_ON),
    (["start", "left", "right"], FINDS),
    (["start", "left", "right", "left"], SWINGS),
    (["start", "left", "right", "forwardR", "right"], FINDS),  # a step between turns to one side
    (["start", "right", "forwardL", "left", "right"], SWINGS),
]


@pytest.mark.parametrize(("states", "does"), DOES)
def test_what_that_comes_to(states: list[str], does: str) -> None:
    assert classify_blind_behavior(states) == does


def test_chances_by_hand() -> None:
    assert shares_differ([True] * 3, [False] * 3) == pytest.approx(
        2 / 20
    )  # two of the 20 ways to choose 3 of 6
    assert shares_differ([True, False], [True, False]) == 1.0
    assert pairs_differ([False] * 5, [True] * 5) == pytest.approx(2 / 32)
    assert pairs_differ([True, False], [False, True]) == 1.0
    assert apply_holm_correction([0.04, 0.01, 0.03]) == [
        False,
        True,
        False,
    ]  # 0.01 < 0.05 / 3, but 0.03 > 0.05 / 2
