"""The robot put into the situation that advice is about."""

from __future__ import annotations

import numpy as np
import pytest
from tests.bodies import Scripted
from tests.bodies import kit as scripted_kit
from tests.make.goto_sessions import ANGLE, DISTANCE, DONE, FOOD, A, make_goto_session

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.give_advice import give_advice
from understudy.coaching.pose_sampling import sample_posed_situations
from understudy.coaching.situation_setup import set_up_situation
from understudy.errors import SessionError, SettingError
from understudy.learning.fit import learn, learn_automaton
from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature, CounterFeature, TimeInState
from understudy.model.lesson import Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree_regions import ValueSet, make_full_value_set
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT
from understudy.sim.world import World
from understudy.training.session import Session
from understudy.training.trainee import Mode

ANYTHING = make_full_value_set(DISTANCE.kind)
SURELY = ValueSet(((1.0, 2.0),), False)


def session(lesson: Lesson, library: Library | None = None) -> Session:
    body = World(find_scenario("forage"), [5])
    targets = {"A": "station"} if lesson.automaton.parameters else {}
    return Session(body, library or Library(FORAGE_KIT), lesson, targets=targets)


def values(session: Session) -> tuple[float, ...]:
    return tuple(session.view().features.values())


def test_the_robot_stands_where_the_advice_points_in_the_state_it_names() -> None:
    lesson = make_goto_session()
    taught = session(lesson)
    places = [each for each in give_advice(lesson, learn(lesson)) if each.region is not None]
    assert places
    for each in places:
        staged = set_up_situation(taught, each)
        assert staged.there, (each, staged)
        assert taught.view().state == each.state
        assert each.region is not None
        assert all(value in part for value, part in zip(values(taught), each.region, strict=True))


def test_nothing_is_recorded_and_the_next_press_is_one_from_there() -> None:
    lesson = make_goto_session()
    taught = session(lesson)
    taught.test()
    first = next(each for each in give_advice(lesson, learn(lesson)) if each.state == "left")
    set_up_situation(taught, first)
    assert taught.examples == lesson.examples
    assert taught.mode is Mode.TESTING
    here = values(taught)
    taught.direct("forward")
    taught.tick()
    shown = taught.examples[len(lesson.examples)]
    assert (shown.state, shown.next, shown.values) == ("left", "forward", here)


def test_another_draw_is_another_place() -> None:
    taught = session(make_goto_session())
    behind = Advice(AdviceKind.GAP, "", "left", 1.0, (ANYTHING, ValueSet(((3.0, 3.3),), False)))
    found = set()
    for draw in range(4):
        assert set_up_situation(taught, behind, draw=draw).there
        found.add(values(taught))
    assert len(found) == 4


def test_what_cannot_be_set_up_is_named_and_the_robot_is_as_near_as_can_be() -> None:
    taught = session(make_goto_session())
    nowhere = Advice(
        AdviceKind.GAP, "", "forward", 1.0, (ValueSet(((50.0, 60.0),), False), ValueSet(((3.0, 3.3),), False))
    )
    staged = set_up_situation(taught, nowhere)
    assert not staged.there
    assert "distance_to(A)" in staged.missed
    assert "distance_to(A)" in staged.sentence
    assert values(taught)[0] > 3.0


def test_worlds_of_other_seeds_are_tried_where_this_one_has_no_such_place(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lesson = Lesson(Automaton("look", (START, State("forward", "forward")), (FOOD,)))
    taught = session(lesson)
    none_left = Advice(AdviceKind.GAP, "", "forward", 1.0, (ValueSet(((0.0, 1.0),), False),))
    tried: list[int] = []
    reset = taught.reset

    def note_seed(seed: int) -> None:
        tried.append(seed)
        reset(seed)

    monkeypatch.setattr(taught, "reset", note_seed)
    assert set_up_situation(taught, none_left, seeds=[6, 7], tries=5).missed == ("food_left",)
    assert tried == [6, 7]
    assert taught.body.time_s == 0.0


def test_time_in_state_counters_and_a_childs_flag_are_set() -> None:
    own = (
        BoundFeature(TimeInState()),
        BoundFeature(CounterFeature("tries")),
        DONE,
    )
    automaton = Automaton("errand", (START, State("go", "goto", A)), own, ("A",))
    library = Library(FORAGE_KIT).with_automaton(make_goto())
    taught = session(Lesson(automaton), library)
    raised = ValueSet(((1.0, 2.0),), False)
    wanted = Advice(AdviceKind.GAP, "", "go", 1.0, (ValueSet(((3.0, 9.0),), False), SURELY, raised))
    assert set_up_situation(taught, wanted).there
    assert taught.view().path == ("go", "done")
    seconds, tries, flag = values(taught)
    assert (3.0 <= seconds < 9.0, 1.0 <= tries < 2.0, flag) == (True, True, 1.0)


def make_goto() -> TrainedAutomaton:
    lesson = make_goto_session()
    return TrainedAutomaton(learn_automaton(lesson), lesson)


def test_a_flag_that_nothing_raises_there_is_missed() -> None:
    automaton = Automaton("drive", (START, State("forward", "forward")), (DONE,))
    taught = session(Lesson(automaton))
    raised = Advice(AdviceKind.GAP, "", "forward", 1.0, (ValueSet(((1.0, 2.0),), False),))
    assert set_up_situation(taught, raised).missed == ("done",)


def test_advice_about_no_place_and_flag_states_are_refused() -> None:
    taught = session(make_goto_session())
    with pytest.raises(SessionError, match="about no place"):
        set_up_situation(taught, Advice(AdviceKind.OUTLOOK, "Enough.", "", 0.1))
    with pytest.raises(SessionError, match="raises a flag and is never left"):
        set_up_situation(taught, Advice(AdviceKind.NEVER_ENTERED, "", "done", 0.5))


def test_a_body_that_cannot_be_placed_is_refused() -> None:
    library = Library(scripted_kit)
    lesson = Lesson(Automaton("taught", (START, State("forward", "forward")), ()))
    taught = Session(Scripted(), library, lesson)
    with pytest.raises((SessionError, SettingError), match="drive the robot into position"):
        set_up_situation(taught, Advice(AdviceKind.NEVER_LEFT, "", "forward", 0.6))


def test_situations_of_a_world_are_such_as_its_robot_senses() -> None:
    body = World(find_scenario("forage"), [5])
    found = sample_posed_situations(body, (DISTANCE, ANGLE, DONE), {"A": "station"}, count=50)
    assert found.shape == (50, 3)
    assert np.isnan(found[:, 2]).all()
    assert (found[:, 0] > 0).all()
    assert np.ptp(found[:, 1]) > 5.0
