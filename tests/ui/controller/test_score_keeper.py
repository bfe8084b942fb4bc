"""The score of what is trained: after each press, beside the one before, in worlds that are used once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from tests.ui.tui.desks import right

from understudy.falsification.lesson_score import LessonScore, score_behavior
from understudy.falsification.new_worlds import NewWorlds
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT, Forage
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
    assert "before this press in" in keeper.describe()
    assert (keeper.trend, keeper.change.has_fallen) == ("falling", True)
    for _ in arrivals:
        session.undo()
    keeper.note_change()
    begin.finish()
    assert keeper.describe().endswith("up from 0")


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
        monkeypatch.setattr(score_keeper, "World", int)
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
