"""What the coach asks about presses that look like slips."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.make.goto_sessions import GOTO, Row, make_goto_session

from understudy.coaching import advice
from understudy.coaching.advice import MOST_SLIPS, Advice, AdviceKind
from understudy.coaching.give_advice import give_advice
from understudy.coaching.lesson_analysis import LessonAnalysis
from understudy.learning.fit import learn
from understudy.learning.mislabels import find_mislabels
from understudy.model.lesson import Lesson

FAR: tuple[Row, ...] = tuple(("forward", "left", "directive", 3.0 + k / 4, 90 + 10 * k) for k in range(4))
NEAR: tuple[Row, ...] = tuple(("forward", "done", "directive", 0.2 + k / 20, 80 + 20 * k) for k in range(4))
SLIP: Row = ("forward", "done", "directive", 3.4, 105)


def slips_of(lesson: Lesson, meant: dict[int, float] | None = None) -> list[Advice]:
    found = give_advice(lesson, learn(lesson), meant=meant or {})
    return [each for each in found if each.kind is AdviceKind.SLIP]


def test_a_press_that_the_others_speak_against_is_asked_about() -> None:
    (asked,) = slips_of(make_goto_session((*FAR, *NEAR, SLIP)))
    assert asked.sentence.startswith("Did you mean this in state forward when A is ")
    assert "Example 8 says done, but examples " in asked.sentence
    assert (asked.state, asked.examples, asked.at) == (
        "forward",
        (8,),
        make_goto_session((SLIP,)).examples[0].values,
    )
    assert asked.weight > 0.5


def test_what_was_meant_is_not_asked_again_and_hangs_together_by_itself() -> None:
    lesson = make_goto_session((*FAR, *NEAR, SLIP))
    (asked,) = slips_of(lesson)
    assert not slips_of(lesson, {8: asked.doubt})
    everything = give_advice(lesson, learn(lesson))
    assert not [each for each in everything if each.kind is AdviceKind.SINGLE and 8 in each.examples]


def test_what_the_others_would_have_foretold_is_rare_and_no_slip() -> None:
    """Forty lessons with slips here and there: asked about are those that the tree without them does not decide so."""
    asked = rare = 0
    for seed in range(40):
        draws = np.random.default_rng(seed)
        rows = [row_of(float(draws.uniform(0, 4)), float(draws.uniform(0, 360)), draws) for _ in range(24)]
        lesson = make_goto_session(tuple(rows))
        odd = {suspect.example.number for suspect in find_mislabels(lesson, most=MOST_SLIPS)}
        found = {each.examples[0] for each in slips_of(lesson)}
        for number in odd:
            others = replace(lesson, examples=tuple(e for e in lesson.examples if e.number != number))
            transition = learn(others)["forward"]
            said = lesson.examples[number]
            outcome = lesson.automaton.state_names[transition.decide(said.values)]
            assert (number in found) is (outcome != said.next)
        asked, rare = asked + len(found), rare + len(odd - found)
    assert asked > rare > 0


def row_of(distance: float, angle: float, draws: np.random.Generator) -> Row:
    """What is right there, but for one press in ten."""
    right = "done" if distance < 0.8 else "left"
    slipped = draws.random() < 0.1
    return (
        "forward",
        ("left" if right == "done" else "done") if slipped else right,
        "directive",
        distance,
        angle,
    )


def test_a_lesson_that_hangs_together_has_none() -> None:
    assert not slips_of(make_goto_session(GOTO))
    assert not slips_of(make_goto_session((SLIP,)))


def test_in_a_stateless_lesson_it_is_asked_of_no_state() -> None:
    lesson = make_goto_session((*FAR, *NEAR, SLIP))
    pooled = replace(lesson, automaton=replace(lesson.automaton, stateless=True))
    (asked,) = slips_of(pooled)
    assert asked.state == ""
    assert asked.sentence.startswith("Did you mean this when A is ")


def test_a_press_recorded_in_a_flag_state_may_be_a_slip_too() -> None:
    """No tree leaves that state, so none is asked whether it would have decided so."""
    lesson = make_goto_session((*FAR, *NEAR, ("done", "done", "confirmation", 3.4, 105)))
    (asked,) = slips_of(lesson)
    assert (asked.state, asked.examples) == ("done", (8,))
    assert asked.sentence.startswith("Did you mean this in state done when A is ")


def test_in_a_large_lesson_no_slips_are_looked_for_and_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    lesson = make_goto_session((*FAR, *NEAR, SLIP))
    monkeypatch.setattr(advice, "MOST_COMPARED", 8)
    assert not slips_of(lesson)
    (said,) = [each.sentence for each in give_advice(lesson, learn(lesson)) if "no slips" in each.sentence]
    assert (
        said == "I looked for no slips: 9 presses are too many to compare each with all others (8 at most)."
    )


def test_presses_without_support_are_the_same_however_few_are_compared_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    draws = np.random.default_rng(3)
    rows = [row_of(float(draws.uniform(0, 4)), float(draws.uniform(0, 360)), draws) for _ in range(60)]
    lesson = make_goto_session(tuple(rows))
    found = []
    for few in (1, 7, 64):
        monkeypatch.setattr(advice, "FEW", few)
        state = LessonAnalysis(lesson, learn(lesson)).states["forward"]
        found.append(list(advice._list_unsupported_presses(state)))
    assert found[0] == found[1] == found[2] != []
