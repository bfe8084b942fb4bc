"""The situation in which a press teaches most: found in fresh worlds, and gone to exactly; nothing is learned so."""

from __future__ import annotations

from itertools import pairwise
from math import tau

import pytest
from msgspec import structs
from tests.bodies import Scripted
from tests.make.sessions import make_session as scripted_session
from tests.make.sessions import play

from understudy.coaching.next_situation import NextSituation, find_next_situation, go_to_situation
from understudy.coaching.questions import UncertaintyQueries
from understudy.coaching.reasons_to_ask import DoubtReason
from understudy.errors import SessionError
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Library
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.schema import RobotGroup
from understudy.sim.world import World
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy.training.trainee import Mode

FRESH = range(100, 120)
DISTANCE, ANGLE = "distance_to(nearest_food)", "angle_to(nearest_food)"


def teach_goto(*presses: str, features: tuple[str, ...] = (DISTANCE, ANGLE)) -> Session:
    """A lesson of going to food, taught live with presses half a second apart."""
    library = Library(FORAGE_KIT)
    lesson = new_lesson(
        library,
        "goto",
        states=["forward", "rotate_left", "rotate_right"],
        flags=["done"],
        features=features,
        options=LearnerOptions(watched=True),
    )
    session = Session(Forage([0]), library, lesson)
    for state in presses:
        session.direct(state)
        for _ in range(5):
            session.tick()
    return session


def find_situation(session: Session, seeds: range = FRESH) -> NextSituation:
    found = find_next_situation(session, seeds=seeds)
    assert found is not None
    return found


@pytest.mark.parametrize("features", [(DISTANCE, ANGLE), (ANGLE, "time_in_state")])
@pytest.mark.parametrize("mode", [Mode.LIVE, Mode.TESTING])
def test_the_robot_is_where_the_question_was_found(features: tuple[str, ...], mode: Mode) -> None:
    session = teach_goto("rotate_left", "forward", features=features)
    if mode is Mode.TESTING:
        session.test()
    session.reset(0)  # silence until here was consent
    found = find_situation(session)
    examples = session.examples
    go_to_situation(session, found)
    view = session.view()
    assert (view.state, tuple(view.features.values())) == (found.question.state, found.question.values)
    assert view.time_s == pytest.approx(found.question.time_s)
    assert session.examples == examples  # not even from silence
    assert session.is_watching
    assert session.mode is mode


def test_it_is_in_a_fresh_world_and_the_same_every_time() -> None:
    session = teach_goto("rotate_left", "forward")
    before = session.capture()
    found = find_situation(session)
    assert found.seed in FRESH
    assert find_situation(session) == found
    assert session.capture() == before


def test_what_was_answered_is_not_asked_again() -> None:
    session = teach_goto("rotate_left", "forward")
    asked = set()
    for _ in range(8):
        found = find_situation(session)
        question = found.question
        assert 0.0 <= found.change <= 1.0
        assert question.answers[0] == question.next
        assert (question.state, question.values) not in asked
        asked.add((question.state, question.values))
        go_to_situation(session, found)
        angle = question.values[1]
        right = "forward" if not 0.4 < angle < 5.9 else "rotate_left" if angle < 3.14 else "rotate_right"
        if right == question.state:
            session.confirm()
        else:
            session.direct(right)
        session.tick()


def test_an_empty_lesson_meets_no_decision() -> None:
    assert find_next_situation(teach_goto(), seeds=FRESH) is None


def test_other_robots_of_the_world_go_on_as_they_are_set_to() -> None:
    forage = find_scenario("forage")
    group = RobotGroup(type=next(iter(forage.types)), count=3)
    scenario = structs.replace(forage, robots=(group,))
    library = Library(make_scenario_kit(scenario))
    lesson = new_lesson(library, "turn", states=["forward", "rotate_left"], features=[ANGLE])
    session = Session(World(scenario, [0]), library, lesson, agent=1)
    session.other_agents.set_behavior("forward")
    play(session, "forward", 3, "rotate_left", 3)
    found = find_situation(session)
    go_to_situation(session, found)
    assert tuple(session.view().features.values()) == found.question.values


def test_where_there_is_nothing_to_go_to() -> None:
    training = teach_goto("forward")
    training.train()
    with pytest.raises(SessionError, match="nothing happens without you"):
        find_next_situation(training, seeds=FRESH)
    other = play(scripted_session(body=Scripted(), options=LearnerOptions(live=True)), "forward", 3)
    with pytest.raises(SessionError, match="only a robot of a simulated world"):
        find_next_situation(other, seeds=FRESH)


def test_a_robot_that_turns_for_ever_is_shown_where_it_was_told_to_leave_the_turn_before() -> None:
    session = teach_goto("rotate_left")
    session.reset(0)
    found = find_situation(session)
    question = found.question
    assert (question.doubt.because, question.state, question.next) == (
        DoubtReason.REPEATING,
        "rotate_left",
        "rotate_left",
    )
    assert "come back to where I was" in found.sentence
    assert question.time_s > 4.0  # once around, at least
    queries = UncertaintyQueries(session)
    bearings = []
    for _ in range(4):  # all around
        again = find_next_situation(session, seeds=FRESH, queries=queries)
        assert again is not None
        assert again.question.doubt.because is DoubtReason.REPEATING
        bearings.append(again.question.values[1])
        queries.note_asked(again.question)
    steps = [(sooner - later) % tau for sooner, later in pairwise(bearings)]
    assert all(step == pytest.approx(tau / 4, abs=0.7) for step in steps)
    again = find_next_situation(session, seeds=FRESH, queries=queries)
    assert again is None or again.question.doubt.because is not DoubtReason.REPEATING
