"""Whom a correction makes suspect: tables that a reader can check by hand, and what holds of every lesson."""

from __future__ import annotations

from dataclasses import replace
from math import nan
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.make.lessons import draw_tables, make_lesson

from understudy.errors import DefinitionError
from understudy.learning.mislabels import CorrectionDiagnosis, MistakeCause, diagnose_correction
from understudy.model.learner_options import LearnerOptions, SklearnOptions
from understudy.model.lesson import Lesson
from understudy.model.value_kinds import Categorical, Continuous, Kind, Toroidal

LIGHT = Categorical(("red", "amber", "green"))
DRIVING = [("go", [value], "go", "default") for value in (102, 100, 80, 60, 53)]
ARRIVING = ("go", [3], "done", "directive")
WRONG = ("go", [56], "turn", "directive")
RIGHT = ("go", [55], "go", "confirmation")


def diagnose(
    shown: list[tuple[Any, ...]], kinds: list[Kind] | None = None, *, corrections: int = 1
) -> CorrectionDiagnosis:
    """What the last example, a correction like those before it, came to."""
    return diagnose_correction(*make_corrections(shown, kinds, corrections=corrections))


def make_corrections(
    shown: list[tuple[Any, ...]], kinds: list[Kind] | None = None, *, corrections: int = 1
) -> tuple[Lesson, Any]:
    plain = make_lesson(shown, kinds)
    first = len(shown) - corrections
    made = tuple(replace(each, correction=each.number >= first) for each in plain.examples)
    return replace(plain, examples=made), made[-1]


CASES = [  # examples, the last a correction; the verdict; the suspects' numbers
    ([*DRIVING, ARRIVING, WRONG, RIGHT], MistakeCause.BAD, [6]),
    # an end of a region: the only example of its kind, with others to one side only
    ([*DRIVING, ARRIVING, ("go", [5], "go", "confirmation")], MistakeCause.UNSURE, []),
    # nothing was shown there
    ([*DRIVING, ARRIVING, ("go", [200], "done", "directive")], MistakeCause.FEW, []),
    ([*DRIVING, ARRIVING, ("go", [30], "done", "directive")], MistakeCause.FEW, []),
    # too few to tell
    ([ARRIVING, WRONG, RIGHT], MistakeCause.UNSURE, []),
    ([("go", [60], "go", "default"), ("go", [53], "go", "default"), WRONG, RIGHT], MistakeCause.UNSURE, []),
    # bad, but far from the correction: it had no part in this mistake
    (
        [
            *[("go", [value], "go", "default") for value in (1, 2, 3, 5, 6, 7)],
            ("go", [4], "turn", "directive"),
            *[("go", [value], "rest", "directive") for value in (95, 96, 98, 99)],
            ("go", [90], "go", "confirmation"),
        ],
        MistakeCause.UNSURE,
        [],
    ),
    # what other states were shown is no evidence
    (
        [*[("turn", each[1], "turn", each[3]) for each in DRIVING], ARRIVING, WRONG, RIGHT],
        MistakeCause.UNSURE,
        [],
    ),
]


@pytest.mark.parametrize(("shown", "verdict", "suspects"), CASES)
def test_whom_a_correction_makes_suspect(
    shown: list[tuple[Any, ...]], verdict: MistakeCause, suspects: list[int]
) -> None:
    found = diagnose(shown)
    assert (found.verdict, [each.example.number for each in found.suspects]) == (verdict, suspects)


def test_reasons_name_examples() -> None:
    found = diagnose([*DRIVING, ARRIVING, WRONG, RIGHT])
    assert found.reason == "The decision at correction 7 was wrong because of example 6."
    reason = "Example 6 says turn, but examples 3, 4 and 7, which are most like it, say go."
    assert found.reasons == {6: reason}
    assert str(found) == f"{found.reason} {reason}"


@pytest.mark.parametrize("others", range(3, 8))
def test_with_fewer_than_six_others_it_is_too_early(others: int) -> None:
    found = diagnose([*DRIVING[: others - 2], ARRIVING, WRONG, RIGHT])
    assert ("too early to doubt any" in found.reason) == (others < 6)
    assert f"With {others} other examples beside" in found.reason or others >= 6


def test_no_suspect_speaks_against_another() -> None:
    """Two buttons were hit wrongly at one place: each is doubted by those that are not."""
    found = diagnose([*DRIVING, ARRIVING, WRONG, ("go", [56.2], "rest", "directive"), RIGHT])
    assert sorted(found.reasons) == [6, 7]
    assert all("3, 4 and 8" in reason and reason.endswith("say go.") for reason in found.reasons.values())


KINDS: list[tuple[Kind, float, float]] = [  # a kind, where the robot goes on, and where it should turn
    (Toroidal(360), 355, 180),
    (LIGHT, 2, 0),
    (Continuous(), nan, 4),
    (Continuous(), 4, nan),
]


@pytest.mark.parametrize(("kind", "on", "off"), KINDS)
def test_any_kind_of_feature(kind: Kind, on: float, off: float) -> None:
    """The last but one was pressed wrong, among others that are alike round the circle, by label or by absence."""
    near = (on + 10) % 360 if isinstance(kind, Toroidal) else on
    shown = [
        *[("go", [value], "go", "confirmation") for value in (on, near, on, near)],
        *[("go", [off], "turn", "directive")] * 3,
        ("go", [near], "turn", "directive"),
        ("go", [on], "go", "confirmation"),
    ]
    found = diagnose(shown, [kind])
    assert [each.example.number for each in found.suspects] == [7]


def test_corrections_that_contradict_each_other_are_both_kept() -> None:
    shown = [*DRIVING, ARRIVING, ("go", [55], "turn", "directive"), ("go", [55], "go", "confirmation")]
    found = diagnose(shown, corrections=2)
    assert (found.verdict, found.suspects) == (MistakeCause.CONTRADICTION, ())
    assert found.reason == "Correction 7 contradicts example 6: both are kept."


def test_what_was_recorded_beside_a_correction_contradicts_none() -> None:
    """Who corrects to a state, and at once, seeing the very same, on to another, has contradicted nobody."""
    shown = [*DRIVING, ARRIVING, ("go", [55], "go", "default"), ("go", [55], "turn", "directive")]
    assert diagnose(shown, corrections=2).verdict is not MistakeCause.CONTRADICTION


def test_what_is_like_a_correction_may_agree_with_it() -> None:
    """It was all said near by; what was learned has the boundary elsewhere."""
    found = diagnose([*DRIVING, ("go", [3], "turn", "directive"), ("go", [79], "go", "confirmation")])
    assert found.verdict is MistakeCause.FEW
    assert found.reason == "Examples like correction 6 agree with it: the boundary was in the wrong place."
    alone = diagnose([*DRIVING, ARRIVING, ("go", [200], "done", "directive")])
    assert alone.reason == "There were no examples like correction 6: it adds what was missing."


def test_the_learner_makes_no_difference() -> None:
    given_, correction = make_corrections([*DRIVING, ARRIVING, WRONG, RIGHT])
    other = replace(given_, options=LearnerOptions(learner=SklearnOptions("SVC")))
    assert diagnose_correction(other, correction) == diagnose_correction(given_, correction)


def test_stateless_lessons_pool_all_states() -> None:
    shown = [("go" if k % 2 else "rest", [float(k)], "go", "confirmation") for k in range(6)]
    shown += [("rest", [2.5], "turn", "directive"), ("go", [2.6], "go", "confirmation")]
    pooled = make_lesson(shown, stateless=True)
    made = (*pooled.examples[:-1], replace(pooled.examples[-1], correction=True))
    assert [
        each.example.number for each in diagnose_correction(replace(pooled, examples=made), made[-1]).suspects
    ] == [6]


def test_what_teaches_nothing_cannot_be_judged() -> None:
    given_, correction = make_corrections([*DRIVING, ARRIVING, WRONG, RIGHT])
    with pytest.raises(DefinitionError, match="teaches nothing"):
        diagnose_correction(given_, replace(correction, quarantined="by mistake"))


def test_one_in_quarantine_is_neither_suspect_nor_witness() -> None:
    given_, correction = make_corrections([*DRIVING, ARRIVING, WRONG, RIGHT])
    out = tuple(replace(each, quarantined="no" if each.number == 6 else "") for each in given_.examples)
    assert diagnose_correction(replace(given_, examples=out), correction).suspects == ()


@settings(max_examples=60)
@given(draw_tables(), st.randoms(use_true_random=False))
def test_no_correction_is_ever_suspected_and_order_makes_no_difference(table: Any, random: Any) -> None:
    rows, kinds = table
    names = ["go", "turn", "done"]
    sorts = {0: "default", 1: "directive"}
    shown = [("go", list(each.values), names[each.outcome], sorts[each.group]) for each in rows]
    shown.append(("go", list(rows[0].values), "turn", "directive"))
    given_, correction = make_corrections(shown, kinds, corrections=1 + random.randrange(len(shown)))
    found = diagnose_correction(given_, correction)
    assert not any(each.example.correction or each.example.next == correction.next for each in found.suspects)
    assert (found.verdict is MistakeCause.BAD) == bool(found.suspects)
    assert all(0.5 <= each.doubt <= 1.0 for each in found.suspects)
    mixed = list(given_.examples)
    random.shuffle(mixed)
    assert diagnose_correction(replace(given_, examples=tuple(mixed)), correction) == found
