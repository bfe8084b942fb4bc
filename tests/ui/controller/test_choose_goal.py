"""What success means for a behavior without a flag: it is asked, chosen, undone, saved, and then measured."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from msgspec import structs
from tests.sim.patrollers import ROBOTS, SCENARIO
from tests.ui.terminal.desks import Wall

from understudy.errors import SessionError
from understudy.judging.properties.run_property import Verdict
from understudy.learning.fit import learn
from understudy.model.library import Library
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.sim.team.libraries import collect_libraries, make_coordinator_body
from understudy.sim.world import World
from understudy.storage.library_folder import open_library
from understudy.training.session import Session
from understudy.ui.controller.coach import change_reaction_time, correct_slip
from understudy.ui.controller.lesson_actions import (
    choose_goal,
    choose_next_goal,
    quarantine_examples,
    release_examples,
)
from understudy.ui.controller.open_session import OpenSession, begin_session
from understudy.ui.controller.score_keeper import LessonScoreKeeper
from understudy.ui.controller.trainer import Trainer
from understudy.ui.controller.training_plan import LessonChoices, TrainingPlan, make_session_start

ARENA = structs.replace(find_scenario("arena"), goal=None)
KIT = make_scenario_kit(ARENA)
TOUCHES, COVERS = "never touches anything", "covers at least 3.75 m² of ground in 60 s"
ASKS = "not measured: choose what success means"


def make_plan(folder: Path) -> TrainingPlan:
    library = open_library(folder, KIT, learn).library if folder.exists() else Library(KIT)
    choices = LessonChoices(live=False, states=["forward", "rotate_left"], features=["sonar_rear"], flags=[])
    return TrainingPlan("wander", folder, ARENA, library, choices, 3)


def begin(folder: Path) -> OpenSession:
    plan = make_plan(folder)
    start = make_session_start(plan)
    assert start is not None
    return begin_session(plan, start, Wall())


@pytest.fixture
def open_session(tmp_path: Path) -> OpenSession:
    """Opened with one press, and with scores that are taken at once."""
    opened = begin(tmp_path / "library")
    trainer = opened.trainer
    trainer.score = LessonScoreKeeper(trainer.session, begin=lambda work: work(), worlds=6)
    trainer.press("rotate_left")
    trainer.tick()
    return opened


def test_it_is_asked_chosen_measured_and_undone(open_session: OpenSession) -> None:
    trainer, score = open_session.trainer, open_session.trainer.score
    assert (score.describe(), score.goal, score.is_goal_chosen) == (ASKS, "", False)
    assert [each.name for each in score.offers] == [TOUCHES, COVERS]
    said = choose_goal(trainer, TOUCHES)
    assert said.text == "Success: never touches anything; undo reverts this"
    assert (score.describe(), score.goal) == ("wander works in 3 of 3 new worlds", TOUCHES)
    choose_goal(trainer, COVERS)
    assert score.describe() == "wander works in 0 of 3 new worlds"
    assert score.change is not None
    assert score.change.before is None, "two goals cannot be compared"
    trainer.undo()
    assert score.describe() == "wander works in 3 of 3 new worlds"
    choose_goal(trainer, None)
    assert (score.describe(), score.goal) == (ASKS, "")
    open_session.close()


def open_in_squad(folder: Path, *, leads: bool) -> OpenSession:
    """Open a lesson without a flag for the third of four robots, or for their coordinator, with one press."""
    body: World | CoordinatorBody
    if leads:
        libraries = collect_libraries(SCENARIO, ROBOTS)
        body, library = make_coordinator_body(SCENARIO, "patrol", libraries, seed=1), libraries["patrol"]
        choices = LessonChoices(states=["out=wander"], features=["someone_sees(intruder)"], flags=[])
    else:
        body, library = World(SCENARIO, [1]), ROBOTS
        choices = LessonChoices(states=["left"], features=["sonar_rear"], flags=[])
    plan = TrainingPlan("new", folder, SCENARIO, library, choices, 1)
    start = make_session_start(plan)
    assert start is not None
    opened = begin_session(plan, start, Wall(), body=body, agent=0 if leads else 2)
    trainer = opened.trainer
    trainer.score = LessonScoreKeeper(trainer.session, begin=lambda work: work(), worlds=6)
    trainer.press("out" if leads else "left")
    trainer.tick()
    return opened


IN_SQUAD = [  # whether the coordinator is in training, the first offer -> the score
    (False, "never touches anything", "new works in 3 of 3 new worlds (the other robots idle)"),
    (True, "never lets its robots touch anything", "new works in 3 of 3 new worlds"),
]


@pytest.mark.parametrize(("leads", "goal", "score"), IN_SQUAD, ids=["robot", "coordinator"])
def test_it_is_chosen_and_measured_among_others(tmp_path: Path, leads: bool, goal: str, score: str) -> None:
    opened = open_in_squad(tmp_path, leads=leads)
    trainer = opened.trainer
    assert (trainer.score.describe(), trainer.score.offers[0].name) == (ASKS, goal)
    with pytest.raises(SessionError, match="not measured: choose what success means first"):
        trainer.continuation.begin()
    choose_goal(trainer, goal)
    assert (trainer.score.describe(), trainer.score.goal) == (score, goal)
    result = trainer.continuation.begin()()
    assert result.held + len(result.mistakes) == result.worlds >= 121
    opened.close()


def test_one_key_chooses_the_next(open_session: OpenSession) -> None:
    found = []
    for _ in range(3):
        choose_next_goal(open_session.trainer)
        found.append(open_session.trainer.score.goal)
    assert found == [TOUCHES, COVERS, ""]
    open_session.close()


def test_only_what_is_offered_can_be_chosen(open_session: OpenSession) -> None:
    with pytest.raises(
        SessionError, match="not offered: 'flies'; offered are: never touches anything; covers"
    ):
        choose_goal(open_session.trainer, "flies")
    open_session.close()


def test_keep_going_counts_what_was_chosen(open_session: OpenSession) -> None:
    trainer = open_session.trainer
    with pytest.raises(SessionError, match="not measured: choose what success means first"):
        trainer.continuation.begin()
    choose_goal(trainer, COVERS)
    result = trainer.continuation.begin()()
    assert (result.verdict, result.held) == (Verdict.FAILS, 0)
    said = trainer.continuation.finish(result).text
    assert f"Here, in 3.0 s: this does not hold: it {COVERS}. Press what it should do, and resume" in said
    open_session.close()


def test_a_chosen_goal_can_be_taken_back_beside_a_flag_that_came_later(open_session: OpenSession) -> None:
    trainer, score = open_session.trainer, open_session.trainer.score
    choose_goal(trainer, TOUCHES)
    trainer.change_design(LessonChoices(flags=["done"]))
    assert (score.goal, score.is_goal_chosen) == (TOUCHES, True)
    assert TOUCHES in [each.name for each in score.offers]
    choose_goal(trainer, None)
    assert (score.goal, score.offers) == ("done is raised, wherever that is", ())
    open_session.close()


QUIET_CHANGES: dict[str, Callable[[Trainer], object]] = {
    "quarantine": lambda trainer: quarantine_examples(trainer, [1]),
    "release": lambda trainer: release_examples(trainer, [1]),
    "slip": lambda trainer: correct_slip(trainer, 1, "forward"),
    "reaction": lambda trainer: change_reaction_time(trainer, 0.2),
}


@pytest.mark.parametrize("what", QUIET_CHANGES)
def test_each_change_of_what_is_learned_from_is_scored(open_session: OpenSession, what: str) -> None:
    trainer = open_session.trainer
    choose_goal(trainer, TOUCHES)
    before = trainer.score.change
    QUIET_CHANGES[what](trainer)
    assert trainer.score.change is not before
    open_session.close()


def test_it_is_saved_with_the_lesson(open_session: OpenSession, tmp_path: Path) -> None:
    choose_goal(open_session.trainer, TOUCHES)
    assert open_session.trainer.has_unsaved_changes
    open_session.trainer.save()
    assert not open_session.trainer.has_unsaved_changes
    open_session.close()
    lesson = open_library(tmp_path / "library", KIT, learn).library.taught["wander"].lesson
    assert lesson is not None
    assert lesson.goal == open_session.trainer.session.lesson.goal


def test_it_survives_a_kill(open_session: OpenSession, tmp_path: Path) -> None:
    choose_goal(open_session.trainer, TOUCHES)
    session, copy = open_session.trainer.session, tmp_path / "journal"
    copy.write_bytes(open_session.journal.read_bytes())
    again = Session.resume(copy, session.body, session.library)
    assert again.lesson.goal == session.lesson.goal
    again.close()
    open_session.close()
