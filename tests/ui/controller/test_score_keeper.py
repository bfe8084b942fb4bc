"""The score of what is trained: after each press, beside the one before, in worlds that are used once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.sim.patrollers import ROBOTS, SCENARIO
from tests.ui.terminal.desks import right

from understudy.addons.checks.falsification.lesson_score import LessonScore, ScoreChange, score_behavior
from understudy.addons.checks.falsification.new_worlds import NewWorlds
from understudy.addons.checks.falsification.session_setup import SessionSetup
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.sim.world import World
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy.ui.controller import score_keeper
from understudy.ui.controller.coach import CoachController
from understudy.ui.controller.explainer import DecisionExplainer
from understudy.ui.controller.score_keeper import FIRST_SEED, LessonScoreKeeper

STATES = ["forward", "rotate_left", "rotate_right"]


def make_session(flags: tuple[str, ...] = ("done",)) -> Session:
    library = Library(FORAGE_KIT)
    lesson = new_lesson(
        library,
        "goto",
        states=STATES,
        flags=flags,
        features=["distance_to(A)", "angle_to(A)"],
        parameters=["A"],
        options=LearnerOptions(live=True, watched=True),
    )
    return Session(Forage([3]), library, lesson, targets={"A": "station"})


class Later:
    """Work that is begun and done when the test says so."""

    def __init__(self) -> None:
        self.work: list[Callable[[], None]] = []

    def __call__(self, work: Callable[[], None]) -> None:
        self.work.append(work)

    def finish(self) -> None:
        while self.work:
            self.work.pop(0)()


def press(session: Session, state: str, keeper: LessonScoreKeeper) -> None:
    session.direct(state)
    session.tick()
    keeper.note_change()


def test_each_press_is_scored_beside_the_one_before_in_worlds_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    runs = []

    def note(library: Library, name: str, worlds: NewWorlds, *args: Any, **named: Any) -> LessonScore:
        runs.append((list(worlds.seeds), len(library.taught[name].automaton.transitions)))
        return score_behavior(library, name, worlds, *args, **named)

    monkeypatch.setattr(score_keeper, "score_behavior", note)
    session, begin = make_session(), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=4)
    assert keeper.describe() == ""
    press(session, "forward", keeper)
    assert keeper.is_running
    begin.finish()
    assert not keeper.is_running
    assert keeper.describe() == "goto works in 0 of 4 new worlds"
    session.run_for(1.0)
    press(session, "rotate_left", keeper)
    begin.finish()
    first, second = range(FIRST_SEED, FIRST_SEED + 4), range(FIRST_SEED + 4, FIRST_SEED + 8)
    assert runs == [(list(first), 2), (list(second), 2), (list(second), 3)]


def test_presses_during_runs_are_scored_together() -> None:
    session, begin = make_session(), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=2)
    press(session, "forward", keeper)
    press(session, "rotate_left", keeper)
    press(session, "forward", keeper)
    assert len(begin.work) == 1
    begin.finish()
    change = keeper.take_change()
    assert change is not None
    assert change.before is None
    assert keeper.take_change() is None


def test_one_robot_among_others_is_scored_beside_what_they_do() -> None:
    lesson = new_lesson(ROBOTS, "roam", states=["forwards"], flags=["done"], features=["stuck"], live=True)
    session, begin = Session(World(SCENARIO, [1]), ROBOTS, lesson, agent=2), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=2)
    press(session, "forwards", keeper)
    begin.finish()
    assert keeper.describe() == "roam works in 0 of 2 new worlds (the other robots idle)"
    session.set_other_agents("left")
    press(session, "done", keeper)
    begin.finish()
    assert keeper.describe() == (
        "roam works in 2 of 2 new worlds (the other robots run left) (done counts wherever it is raised)"
    )


@pytest.mark.parametrize(
    ("most_robots", "worlds"), [(6_000, 100), (160, 40), (100, 30)]
)  # of four robots: at most as many worlds as robots allow, and at least 30
def test_many_robots_are_run_in_fewer_worlds(
    monkeypatch: pytest.MonkeyPatch, most_robots: int, worlds: int
) -> None:
    monkeypatch.setattr(score_keeper, "MOST_ROBOTS", most_robots)
    lesson = new_lesson(ROBOTS, "roam", states=["forwards"], flags=["done"], features=["stuck"], live=True)
    session, begin = Session(World(SCENARIO, [1]), ROBOTS, lesson), Later()
    keeper = LessonScoreKeeper(session, begin=begin)
    press(session, "forwards", keeper)
    begin.finish()
    assert keeper.change is not None
    assert keeper.change.after.worlds == worlds


def test_taught_well_it_works_and_what_spoils_it_is_announced() -> None:
    """Shown by a person's eye in six worlds; then all that was shown of being done is deleted, and comes back."""
    session, begin = make_session(), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=20)
    session.teach()
    for seed in range(3, 9):
        session.reset(seed)
        for _ in range(400):
            wanted = right(session.view())
            if wanted is not None and wanted != session.view().state:
                session.direct(wanted)
            session.tick()
    keeper.note_change()
    begin.finish()
    assert keeper.change is not None
    assert keeper.change.after.count >= 18
    arrivals = [each.number for each in session.examples if each.next == "done"]
    for number in arrivals:
        session.delete(number)
    keeper.note_change()
    begin.finish()
    assert "before the last change in" in keeper.describe()
    assert (keeper.trend, keeper.change.has_fallen) == ("falling", True)
    for _ in arrivals:
        session.undo()
    keeper.note_change()
    begin.finish()
    assert keeper.describe().endswith("up from 0")


def test_a_slip_far_off_is_announced_where_it_says_that_more_is_right() -> None:
    """Done was pressed twice beside the station. Then it is pressed 3 m away, as if that were right, too."""
    session, begin = make_session(), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=20)
    session.teach()
    for seed in (3, 4):
        session.reset(seed)
        for _ in range(400):
            wanted = right(session.view())
            if wanted is not None and wanted != session.view().state:
                session.direct(wanted)
            session.tick()
    session.reset(6)
    while not 2.0 < session.view().features["distance_to(A)"] < 5.0 or session.view().state == "start":
        session.tick()
    keeper.note_change()
    begin.finish()
    press(session, "done", keeper)
    begin.finish()
    assert keeper.change is not None
    assert keeper.change.has_fallen
    assert "distance_to(A) was 0." in keeper.describe()


OTHER_DESIGNS = [  # what is changed -> the score of what is learned then, which is compared with nothing
    ({"flags": []}, "goto works in 0 of 1 new worlds"),
    ({"flags": ["arrived"], "names": {"done": "arrived"}}, "goto works in 0 of 2 new worlds"),
    ({"parameters": ["A", "B"], "targets": {"B": "nearest_food"}}, "goto works in 0 of 2 new worlds"),
]


@pytest.mark.parametrize(("change", "said"), OTHER_DESIGNS, ids=["no flag", "another flag", "parameter"])
def test_another_goal_or_other_parameters_are_not_compared(change: Any, said: str) -> None:
    session, begin = make_session(), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=2)
    press(session, "forward", keeper)
    begin.finish()
    session.change_design(**change)
    keeper.note_change()
    begin.finish()
    assert keeper.describe() == said
    assert keeper.change is not None
    assert keeper.change.before is None


def test_targets_are_those_of_presses() -> None:
    """A target that it is only turned to, before an undo, was not taught."""
    session = make_session()
    keeper = LessonScoreKeeper(session, begin=Later(), worlds=2)
    assert keeper.list_bindings() == [{"A": "station"}]
    press(session, "forward", keeper)
    session.bind_targets(A="nearest_food")
    keeper.note_change()
    assert keeper.list_bindings() == [{"A": "station"}]
    press(session, "rotate_left", keeper)
    assert keeper.list_bindings() == [{"A": "station"}, {"A": "nearest_food"}]
    again = Session(Forage([4]), session.library, session.lesson, targets={"A": "station"})
    assert LessonScoreKeeper(again).list_bindings() == keeper.list_bindings(), "opened again"


def test_what_is_undone_while_it_is_scored_has_no_score() -> None:
    session, begin = make_session(), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=2)
    press(session, "forward", keeper)
    session.undo()
    keeper.note_change()
    begin.finish()
    assert keeper.describe() == ""
    assert keeper.take_change() is None


FALLEN = ScoreChange(
    LessonScore("goto", np.ones(20, np.bool_), np.ones(20)),
    LessonScore("goto", np.zeros(20, np.bool_), np.full(20, np.nan)),
)


@pytest.mark.parametrize("scored_first", [True, False])
def test_a_fall_by_an_undone_press_is_announced_no_more(
    monkeypatch: pytest.MonkeyPatch, scored_first: bool
) -> None:
    """Undo beside it would take back another press."""
    monkeypatch.setattr(score_keeper, "ScoreChange", lambda *_, **__: FALLEN)
    session, begin = make_session(), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=2)
    press(session, "forward", keeper)
    press(session, "rotate_left", keeper)
    if scored_first:
        begin.finish()
        assert keeper.trend == "falling"
    session.undo()
    if not scored_first:
        keeper._run()
    keeper.note_change()
    assert (keeper.describe(), keeper.trend) == ("goto works in 0 of 20 new worlds", "")
    assert keeper.take_change() is None


def test_the_score_by_another_goal_is_not_shown() -> None:
    session, begin = make_session(), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=2)
    press(session, "forward", keeper)
    begin.finish()
    session.change_design(flags=[])
    keeper.note_change()
    assert keeper.describe() == "goto runs in new worlds…"


OBSTACLES = [
    ("turned off", "not measured: turned off"),
    ("one core", "not measured: this computer has a single core, which runs the world"),
    ("no worlds", "not measured: there are no other worlds to run it in"),
]


@pytest.mark.parametrize(("why", "said"), OBSTACLES)
def test_what_is_not_measured_is_said_and_nothing_waits(
    monkeypatch: pytest.MonkeyPatch, why: str, said: str
) -> None:
    session, begin = make_session(), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=2)
    if why == "turned off":
        keeper.turn(False)
    elif why == "one core":
        monkeypatch.setattr("os.cpu_count", lambda: 1)
    else:
        monkeypatch.setattr(SessionSetup, "from_session", lambda _: None)
    press(session, "forward", keeper)
    assert keeper.describe() == said
    assert begin.work == []


def test_a_failure_is_said_and_the_next_press_tries_again(monkeypatch: pytest.MonkeyPatch) -> None:
    session, begin = make_session(), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=2)

    def fail(*_: object, **__: object) -> LessonScore:
        raise ValueError("broken")

    with monkeypatch.context() as patch:
        patch.setattr(score_keeper, "score_behavior", fail)
        press(session, "forward", keeper)
        begin.finish()
    assert keeper.describe() == "not measured: internal error: ValueError: broken"
    press(session, "rotate_left", keeper)
    begin.finish()
    assert keeper.describe() == "goto works in 0 of 2 new worlds"


def test_turned_off_runs_end() -> None:
    session, begin = make_session(), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=2)
    press(session, "forward", keeper)
    keeper.turn(False)
    begin.finish()
    assert keeper.change is None
    keeper.turn(True)
    begin.finish()
    assert keeper.change is not None


def test_the_coach_advises_first_on_what_went_wrong_in_the_worlds_of_the_score() -> None:
    session, begin = make_session(), Later()
    keeper = LessonScoreKeeper(session, begin=begin, worlds=4)
    coach = CoachController(session, DecisionExplainer(session), keeper)
    for state in ("rotate_left", "forward", "rotate_left", "forward"):
        press(session, state, keeper)
        session.run_for(1.0)
    before = coach.compute_report()
    assert before is coach.compute_report()
    assert before is not None
    assert not any(each.evidence for each in before.advice)
    begin.finish()
    after = coach.compute_report()
    assert after is coach.compute_report()
    assert after is not None
    assert after.advice[0].evidence.startswith("I went wrong there in 4 of 4 new worlds")
    assert {each.sentence for each in after.advice} == {each.sentence for each in before.advice}
    keeper.turn(False)
    assert keeper.find_scored() is None
