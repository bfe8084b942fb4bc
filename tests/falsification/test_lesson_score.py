"""The score of a behavior in new worlds: by what was shown, not by the robot's own word."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from msgspec import structs
from tests.sim.patrollers import ROBOTS, SCENARIO
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.addons.checks.falsification.lesson_score import LessonScore, ScoreChange, score_behavior
from understudy.addons.checks.falsification.new_worlds import NewWorlds
from understudy.addons.checks.falsification.session_setup import SessionSetup
from understudy.errors import SettingError
from understudy.judging.evaluate import evaluate
from understudy.learning.fit import learn_automaton
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.runtime.link import link
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT
from understudy.training.lesson_design import new_lesson

FORAGE = find_scenario("forage")
LIBRARY = Library.from_automata(FORAGE_KIT, *AUTOMATA)
WORLDS = NewWorlds(SessionSetup(FORAGE), range(5, 15))
BINDINGS = [{"A": target} for target in ("nearest_food", "station")]


def teach_distances(*presses: float, beside: float) -> Library:
    """Return the library with a lesson of goto in which *done* was pressed at these distances, and not at `beside`."""
    automaton = LIBRARY.taught["goto"].automaton
    shown = [*((meters, "done", ExampleKind.DIRECTIVE) for meters in presses)]
    shown += [(meters, "forward", ExampleKind.CONFIRMATION) for meters in (beside, 5.0)]
    examples = [
        Example(number, "forward", (meters, 0.0), following, kind)
        for number, (meters, following, kind) in enumerate(shown, 1)
    ]
    lesson = Lesson(replace(automaton, transitions={}), tuple(examples))
    return LIBRARY.with_automaton(TrainedAutomaton(automaton, lesson))


def test_it_has_to_work_with_each_target() -> None:
    library = teach_distances(0.1, 0.2, 0.3, beside=0.5)
    score = score_behavior(library, "goto", WORLDS, BINDINGS)
    assert score.works.all()
    assert score.describe() == "goto works in 10 of 10 new worlds"
    alone = [
        evaluate(library, "goto", FORAGE, range(5, 15), binding=each).taught.seconds for each in BINDINGS
    ]
    assert score.seconds == pytest.approx(alone[0] + alone[1])


def test_a_flag_far_from_where_it_was_shown_does_not_count() -> None:
    """The same automaton was shown to stop nearer than it does."""
    library = teach_distances(0.01, 0.02, 0.03, beside=0.05)
    score = score_behavior(library, "goto", WORLDS, BINDINGS[:1])
    assert not score.works.any()
    assert np.isnan(score.seconds).all()


def test_without_a_flag_the_goal_of_the_world_counts() -> None:
    score = score_behavior(LIBRARY, "forage", NewWorlds(SessionSetup(FORAGE), range(5, 9)), [{}])
    assert score.works.tolist() == evaluate(LIBRARY, "forage", FORAGE, range(5, 9)).taught.finished.tolist()


def test_where_others_move_it_is_read_at_the_flag() -> None:
    """A robot stops 1.1 m before another one, which drives on: 0.9 s later it is elsewhere."""
    lesson = new_lesson(ROBOTS, "roam", states=["forwards"], flags=["done"], features=["sonar_front_left"])
    shown = [
        (0.8, "done"),
        (0.7, "done"),
        (0.9, "done"),
        (1.1, "forwards"),
        (1.2, "forwards"),
        (3.0, "forwards"),
    ]
    examples = [Example(1, "start", (2.0,), "forwards", ExampleKind.DIRECTIVE)] + [
        Example(number, "forwards", (meters,), following, ExampleKind.CONFIRMATION)
        for number, (meters, following) in enumerate(shown, 2)
    ]
    lesson = replace(lesson, examples=tuple(examples))
    library = ROBOTS.with_automaton(TrainedAutomaton(learn_automaton(lesson), lesson))
    setup = SessionSetup(SCENARIO, 0, [link(ROBOTS, "wander", {})] * 4)
    assert score_behavior(library, "roam", NewWorlds(setup, (500, 539)), [{}]).works.all()


def test_neither_flag_nor_goal() -> None:
    with pytest.raises(SettingError, match="goal"):
        score_behavior(
            LIBRARY, "forage", NewWorlds(SessionSetup(structs.replace(FORAGE, goal=None)), [0]), [{}]
        )


CHANGES = [  # works before and after in the same worlds, times slower -> fell, rose, words
    ([1] * 10, [1] * 10, 1.0, False, False, "x works in 10 of 10 new worlds"),
    ([1] * 10, [1] * 6 + [0] * 4, 1.0, False, False, "x works in 6 of 10 new worlds"),
    ([1] * 10, [1] * 5 + [0] * 5, 1.0, True, False, "x works in 5 of 10 new worlds, and before the last change in 10"),
    ([0] * 10, [1] * 5 + [0] * 5, 1.0, False, True, "x works in 5 of 10 new worlds, up from 0"),
    ([1] * 6 + [0] * 4, [0] * 2 + [1] * 8, 1.0, False, False, "x works in 8 of 10 new worlds"),
    ([1] * 10, [1] * 10, 1.5, False, False, "x works in 10 of 10 new worlds, and takes 1.5 times as long as before"),
]  # fmt: skip


@pytest.mark.parametrize(("before", "after", "slower", "fell", "rose", "said"), CHANGES)
def test_changes(
    before: list[int], after: list[int], slower: float, fell: bool, rose: bool, said: str
) -> None:
    """Four lost of ten worlds and none won may be chance (p = 0.125), five are not (p = 0.0625)."""
    change = ScoreChange(make_score(before, 10.0), make_score(after, 10.0 * slower))
    assert (change.has_fallen, change.has_risen, change.describe()) == (fell, rose, said)


def test_a_flag_at_its_own_word_does_not_fall() -> None:
    """Where it counts wherever it is raised, raising it less often may be a mend."""
    scores = make_score([1] * 10, 10.0), make_score([0] * 10, 10.0)
    assert not ScoreChange(*scores, is_measured=False).has_fallen
    assert ScoreChange(*scores).has_fallen


SAID = [  # works, is it measured, is that what success means now -> whether the goal is said
    ([1] * 9 + [0], True, True, ""),
    ([1] * 9 + [0], False, True, " (GOAL)"),
    ([0] * 10, False, True, ""),  # nothing counts
    ([0] * 10, True, False, " (GOAL)"),
]


@pytest.mark.parametrize(("works", "is_measured", "is_present", "said"), SAID)
def test_by_what_it_is_measured_is_said_where_that_is_no_matter_of_course(
    works: list[int], is_measured: bool, is_present: bool, said: str
) -> None:
    score = make_score(works, 10.0)
    change = ScoreChange(score, score, "GOAL", is_measured=is_measured, is_goal_present=is_present)
    assert change.describe() == f"{score.describe()}{said}"


def test_a_few_of_many_worlds_are_no_fall() -> None:
    """Nine lost of 200 are beyond chance, and less than 5 %."""
    ways = [make_score([1] * (200 - lost) + [0] * lost, 10.0) for lost in (0, 9, 10)]
    assert [ScoreChange(ways[0], each).has_fallen for each in ways] == [False, False, True]


def test_the_first_score_has_nothing_to_compare_with() -> None:
    change = ScoreChange(None, make_score([0, 1], 10.0))
    assert not change.has_fallen
    assert change.describe() == "x works in 1 of 2 new worlds"


def make_score(works: list[int], seconds: float) -> LessonScore:
    return LessonScore("x", np.array(works, np.bool_), np.where(works, seconds, np.nan))
