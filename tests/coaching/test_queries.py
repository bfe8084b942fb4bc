"""A robot in testing, or taught live, that says when it is unsure."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import degrees

from tests.make.goto_sessions import GOTO, make_goto_session

from understudy.coaching.questions import QueryPolicy, Question, UncertaintyQueries
from understudy.coaching.reasons_to_ask import DoubtReason
from understudy.model.learner_options import LearnerOptions, SklearnOptions
from understudy.model.library import Library
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT
from understudy.sim.target_lookup import find_target_place
from understudy.sim.world import World
from understudy.training.session import Session
from understudy.training.trainee import Mode


def make_session_without_view() -> Session:
    """A robot that looks away from the station, which it was never shown."""
    body = World(find_scenario("forage"), [5])
    session = Session(body, Library(FORAGE_KIT), make_goto_session(GOTO), targets={"A": "station"})
    session.test()
    body.place(0, 5.0, 5.0, 0.0)
    session.note_moved()
    bearing = session.view().features["angle_to(A)"]
    body.place(0, 5.0, 5.0, bearing + 3.14159)
    session.note_moved()
    return session


def test_it_asks_once_and_goes_on_when_let() -> None:
    session = make_session_without_view()
    asking = UncertaintyQueries(session)
    question = asking.find_question()
    assert isinstance(question, Question)
    assert question.sentence.startswith("I am not sure: I would ")
    assert "behind you" in question.sentence
    assert asking.find_question() is None
    before = session.capture()
    session.tick()
    session.rewind(before)  # not yet asked, as the clock has it; but it was let go on
    later = UncertaintyQueries(session, unsure=question.doubt.amount)
    assert later.find_question() is not None
    later._last_s = -9.0
    assert later.find_question() is None


def test_where_nothing_can_be_learned_any_more_it_asks_nothing() -> None:
    """Three neighbors cannot be found among two examples: an undo that leaves so few ends the test."""
    lesson = make_goto_session((*GOTO, ("left", "forward", "directive", 1.0, 10)))
    learner = SklearnOptions("KNeighborsClassifier", {"n_neighbors": 3})
    body = World(find_scenario("forage"), [5])
    session = Session(
        body,
        Library(FORAGE_KIT),
        replace(lesson, options=LearnerOptions(learner=learner)),
        targets={"A": "station"},
    )
    session.direct("forward")
    session.tick()
    session.test()
    asking = UncertaintyQueries(session)
    session.undo()
    assert session.mode is Mode.TRAINING
    assert asking.find_question() is None


def test_after_a_question_it_rests() -> None:
    session = make_session_without_view()
    asking = UncertaintyQueries(session, QueryPolicy.MARK, unsure=0.0)
    for _ in range(45):
        asking.find_question()
        session.tick()
    times = [question.time_s for question in asking.marked]
    assert len(times) > 1
    assert all(later - sooner >= 2.0 - 1e-9 for sooner, later in pairwise(times))


def test_it_marks_and_the_moment_can_be_gone_back_to() -> None:
    session = make_session_without_view()
    asking = UncertaintyQueries(session, QueryPolicy.MARK)
    began = session.body.time_s
    for _ in range(20):
        assert asking.find_question() is None
        session.tick()
    first = asking.marked[0]
    assert (first.time_s, first.state) == (began, "start")
    assert first.instant is not None
    session.rewind(first.instant)
    assert session.body.time_s == began
    assert tuple(session.view().features.values()) == first.values


def test_it_asks_nothing_in_training_or_unless_wanted() -> None:
    session = make_session_without_view()
    assert UncertaintyQueries(session, QueryPolicy.NEVER).find_question() is None
    session.train()
    assert session.mode is Mode.TRAINING
    assert UncertaintyQueries(session).find_question() is None


def test_an_answer_settles_it() -> None:
    session = make_session_without_view()
    asking = UncertaintyQueries(session)
    before = asking.find_question()
    assert before is not None
    session.direct("left")
    session.tick()
    session.rewind(session.capture())
    session.test()
    again = asking.find_question()
    assert again is None or again.doubt.amount < before.doubt.amount


def test_taught_live_it_asks_only_where_it_has_hardly_any_grounds() -> None:
    session = make_session_without_view()
    asking = UncertaintyQueries(session)
    assert asking.unsure == 0.5
    session.teach()
    assert asking.unsure == 0.7


def test_the_likely_answers_come_first() -> None:
    question = UncertaintyQueries(make_session_without_view()).find_question()
    assert question is not None
    assert question.state == "start"
    assert question.answers[0] == question.next
    assert set(question.answers) == {"start", "forward", "left", "done"}
    assert question.answers.index("done") == 3  # it was never shown in this state


def test_it_asks_where_the_robot_switches_back_and_forth() -> None:
    """The target is always 2 m away, from where it was shown to drive on, and to turn."""
    lesson = make_goto_session(
        (
            ("start", "forward", "directive", 2.0, 0),
            ("forward", "left", "directive", 2.0, 0),
            ("left", "forward", "directive", 2.0, 0),
        )
    )
    body = World(find_scenario("forage"), [5])
    session = Session(body, Library(FORAGE_KIT), lesson, targets={"A": "station"})
    session.teach()
    asking, reasons = UncertaintyQueries(session, unsure=1.0), []
    for _ in range(25):
        question = asking.find_question()
        reasons += [question.doubt.because] if question is not None else []
        session.tick()
    assert DoubtReason.FIDGETING in reasons
    assert reasons.count(DoubtReason.FIDGETING) <= 2  # once in each state, until the lesson changes


def test_it_asks_over_a_whole_round_where_the_robot_turns_for_ever() -> None:
    """A turn takes 5.2 s. It asks in the third one, and then a quarter of a turn farther each time, four times in all;
    a lesson that changes is asked about again.
    """
    body = World(find_scenario("forage"), [5])
    session = Session(body, Library(FORAGE_KIT), make_goto_session(()), targets={"A": "station"})
    session.teach()
    session.direct("left")
    session.tick()
    asking, found = UncertaintyQueries(session, unsure=1.0), []
    for tick in range(900):
        question = asking.find_question()
        if question is not None and question.doubt.because is DoubtReason.REPEATING:
            found.append(question)
        if tick == 600:
            session.confirm()
        session.tick()
    first, again = (
        [question for question in found if before <= question.time_s < before + 60.0]
        for before in (0.0, 60.1)
    )
    assert len(first) == 4
    assert again
    assert found[0].sentence.startswith("I have been in left for ")
    assert found[0].sentence.endswith(
        ", and come back to where I was. Where in this round should I do something else?"
    )
    bearings = [round(degrees(question.values[1])) for question in first]
    steps = [(sooner - later) % 360 for sooner, later in pairwise(bearings)]
    assert all(abs(step - 90) <= 20 for step in steps)


def test_a_mark_that_the_robot_repeats_itself_stays_until_the_lesson_changes() -> None:
    body = World(find_scenario("forage"), [5])
    session = Session(body, Library(FORAGE_KIT), make_goto_session(()), targets={"A": "station"})
    session.teach()
    session.direct("left")
    session.tick()
    asking = UncertaintyQueries(session, QueryPolicy.MARK, unsure=1.0)
    for _ in range(200):
        asking.find_question()
        session.tick()
    mark = asking.marked[-1]
    assert mark.doubt.because is DoubtReason.REPEATING
    assert asking.is_still_uncertain(mark)
    session.direct("forward")
    session.tick()
    assert not asking.is_still_uncertain(mark)


def test_before_a_flag_it_asks_from_less_doubt_on_than_before_other_switches() -> None:
    """Only one example says done, at 0.3 m ahead; 0.4 m away and well aside, the lesson would say it, too."""
    lesson, found = make_goto_session((*GOTO, ("forward", "forward", "confirmation", 2.0, 0))), {}
    for unsure in (None, 0.7):
        body = World(find_scenario("forage"), [5])
        session = Session(body, Library(FORAGE_KIT), lesson, targets={"A": "station"})
        session.teach()
        session.direct("forward")
        session.tick()
        station = find_target_place(body, "station", 0)
        assert station is not None
        asked = []
        for step in range(20):
            body.place(0, station[0] - 0.4, station[1], -0.1 * step)
            session.note_moved()
            question = UncertaintyQueries(session, unsure=unsure).find_question()
            if question is not None:
                asked.append((question.next, round(question.doubt.amount, 2)))
        found[unsure] = asked
    assert any(following == "done" and 0.5 <= amount < 0.7 for following, amount in found[None])
    assert all(amount >= 0.7 for following, amount in found[None] if following != "done")
    assert all(amount >= 0.7 for _, amount in found[0.7])
