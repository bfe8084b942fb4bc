"""Keep going: what is in training is tested in new worlds, and goes on where it goes wrong, until it holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.sim.patrollers import ROBOTS, SCENARIO
from tests.ui.terminal.desks import Wall, fail_by_presses, make_plan, right

from understudy.addons.checks.falsification.holding_test import HoldingResult
from understudy.addons.checks.falsification.new_worlds import Mistake, NewWorlds, NewWorldsResult
from understudy.addons.checks.falsification.session_setup import SessionSetup
from understudy.errors import SessionError
from understudy.judging.properties.run_property import Verdict
from understudy.model.library import Library
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.sim.forage import FORAGE_KIT
from understudy.sim.team.libraries import collect_libraries, make_coordinator_body
from understudy.sim.world import World
from understudy.training.trainee import Mode
from understudy.ui.controller import coach, keep_going
from understudy.ui.controller.open_session import OpenSession, begin_session
from understudy.ui.controller.trainer import Trainer
from understudy.ui.controller.training_plan import LessonChoices, TrainingPlan, make_session_start


@pytest.fixture
def open_session(tmp_path: Path) -> OpenSession:
    chosen = make_plan(tmp_path / "library")
    start = make_session_start(chosen)
    assert start is not None
    return begin_session(chosen, start, Wall())


def show(trainer: Trainer, seeds: range) -> None:
    """Show GoTo as a person's eye would, from the start of some worlds."""
    for seed in seeds:
        trainer.load_world(seed)
        for _ in range(400):
            wanted = right(trainer.session_view)
            if wanted is not None and wanted != trainer.session_view.state:
                trainer.press(wanted)
            trainer.tick()


def test_it_ends_where_the_behavior_holds(open_session: OpenSession) -> None:
    """Two worlds are not enough; a person presses where it stops, and it holds after some rounds."""
    trainer = open_session.trainer
    show(trainer, range(3, 5))
    said = []
    for _ in range(12):
        said.append(trainer.keep_going().text)
        if " holds, " in said[-1]:
            break
        assert trainer.paused
        assert trainer.session.mode is Mode.TESTING
        trainer.pause()
        for _ in range(600):
            wanted = right(trainer.session_view)
            if wanted is not None and wanted != trainer.session_view.state:
                trainer.press(wanted)
            trainer.tick()
    assert " holds, " in said[-1], said
    assert "in at least 95 % of worlds (" in said[-1]
    open_session.close()


def make_result(*mistakes: Mistake, verdict: Verdict = Verdict.FAILS) -> HoldingResult:
    return HoldingResult(Library(FORAGE_KIT), verdict, 80, 121, (0.5, 0.8), mistakes)


def test_the_situation_is_three_seconds_before_the_mistake(open_session: OpenSession) -> None:
    trainer = open_session.trainer
    show(trainer, range(3, 6))
    examples = trainer.session.examples
    trainer.continuation.begin()
    mistake = Mistake(
        77, {"A": "nearest_food"}, 4.0, "done where distance_to(A) is 2.1 m, shown at 0.2 to 0.4 m"
    )
    said = trainer.continuation.finish(make_result(mistake)).text
    assert trainer.body.time_s == pytest.approx(1.0)
    assert trainer.seed == 77
    assert dict(trainer.session_view.targets) == {"A": "nearest_food"}
    assert trainer.session.examples == examples, "nothing is recorded from silence on the way"
    assert said == (
        "goto works in 80 of 121 new worlds. Here, in 3.0 s: done where distance_to(A) is 2.1 m, shown at 0.2 to "
        "0.4 m. Press what it should do, and resume"
    )
    open_session.close()


def open_on(
    folder: Path, body: World | CoordinatorBody, library: Library, choices: LessonChoices, agent: int
) -> Trainer:
    """Open a lesson on a body in which other agents are, and press its first state and *done* in it."""
    chosen = TrainingPlan("new", folder, SCENARIO, library, choices, 1)
    start = make_session_start(chosen)
    assert start is not None
    trainer = begin_session(chosen, start, Wall(), body=body, agent=agent).trainer
    assert choices.states is not None
    trainer.press(str(choices.states[0]).partition("=")[0])
    for _ in range(10):
        trainer.tick()
    trainer.press("done")
    trainer.tick()
    return trainer


def open_robot(folder: Path) -> Trainer:
    choices = LessonChoices(states=["forwards"], features=["stuck"], flags=["done"])
    trainer = open_on(folder, World(SCENARIO, [1]), ROBOTS, choices, 2)
    trainer.session.set_other_agents("left")
    return trainer


def open_coordinator(folder: Path) -> Trainer:
    libraries = collect_libraries(SCENARIO, ROBOTS)
    choices = LessonChoices(states=["out=wander"], features=["someone_sees(intruder)"], flags=["done"])
    body = make_coordinator_body(SCENARIO, "patrol", libraries, seed=1)
    return open_on(folder, body, libraries["patrol"], choices, 0)


AMONG_OTHERS = [(open_robot, " (the other robots run left)"), (open_coordinator, "")]


@pytest.mark.parametrize(("make", "others"), AMONG_OTHERS, ids=["robot among others", "coordinator"])
def test_among_others_the_situation_is_that_of_the_test(
    tmp_path: Path, make: Callable[[Path], Trainer], others: str
) -> None:
    """Three seconds before the mistake all robots are where they were in the test, bit for bit."""
    trainer = make(tmp_path)
    session = trainer.session
    trainer.continuation.begin()
    said = trainer.continuation.finish(make_result(Mistake(77, {}, 9.0, "done where stuck is no"))).text
    assert said.startswith(
        f"new works in 80 of 121 new worlds{others}. Here, in 3.0 s: done where stuck is no."
    )
    setup = SessionSetup.from_session(session)
    assert setup is not None
    library = session.library.with_automaton(session.make_trained_automaton())
    run = setup.start([77], library, "new", {})
    run.advance(round(6.0 / SCENARIO.tick_s))
    assert isinstance(run.body, World)
    for what in ("x", "y", "heading"):
        there = run.body.state.robots[what]
        assert trainer.body.state.robots[what].tolist() == there.tolist()
    session.close()


@pytest.mark.parametrize("make", [open_robot, open_coordinator], ids=["robot among others", "coordinator"])
def test_among_others_it_is_tested_until_it_is_decided(
    tmp_path: Path, make: Callable[[Path], Trainer]
) -> None:
    """Once shown, *done* comes at once or never."""
    trainer = make(tmp_path)
    result = trainer.continuation.begin()()
    assert result.worlds >= 121
    assert result.verdict is (Verdict.HOLDS if result.held == result.worlds else Verdict.FAILS)
    assert result.held + len(result.mistakes) == result.worlds
    trainer.session.close()


def test_a_limit_of_presses_ends_it(open_session: OpenSession, monkeypatch: pytest.MonkeyPatch) -> None:
    trainer = open_session.trainer
    show(trainer, range(3, 4))
    trainer.continuation.begin()
    monkeypatch.setattr(keep_going, "MOST_PRESSES", 0)
    said = trainer.continuation.finish(make_result(Mistake(7, {"A": "station"}, 4.0, "")))
    assert said.text == "goto does not hold yet, as it is: it works in 80 of 121 new worlds"
    assert said.tone == "error"
    open_session.close()


def press(trainer: Trainer, *states: str) -> None:
    for state in states:
        trainer.press(state)
        trainer.step()


def begin_with_press(trainer: Trainer) -> None:
    """Begin a lesson of goto with a single press."""
    trainer.load_world(3)
    press(trainer, "forward")


def test_what_the_last_press_made_worse_is_said_and_undo_leads_back(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    trainer = open_session.trainer
    fail_by_presses(monkeypatch, {1: 0.2, 2: 0.5})
    begin_with_press(trainer)
    said = trainer.keep_going().text
    assert said.startswith("goto works in 97 of 121 new worlds. Here, in 2.0 s: done too early. ")
    assert trainer.continuation.better is None
    press(trainer, "rotate_left")
    said = trainer.keep_going().text
    assert said == (
        "goto works in 73 of 146 new worlds: 97 of 121 after press 1, before the last press. Undo it, or go on here: "
        "in 2.0 s: done too early. Press what it should do, and resume"
    )
    better = trainer.continuation.better
    assert better is not None
    assert (better.steps, better.since) == (1, "the last press")
    trainer.undo()
    assert trainer.continuation.better is None, "it is that version again"
    open_session.close()


def test_several_presses_that_made_it_worse_are_undone_in_one_act(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the next world is another one in which the better version goes wrong."""
    trainer = open_session.trainer
    fail_by_presses(monkeypatch, {1: 0.2, 2: 0.5, 3: 0.5})
    begin_with_press(trainer)
    trainer.keep_going()
    first, examples = trainer.seed, trainer.session.examples
    press(trainer, "rotate_left", "forward")
    assert (
        ": 97 of 121 after press 1, before the last 2 presses. Undo them, or go on"
        in trainer.keep_going().text
    )
    said = trainer.go_back()
    assert said.text == (
        "goto is as after press 1 again; redo brings back the last 2 presses. Here, in 2.0 s: done too early. Press "
        "what it should do, and resume"
    )
    shown = [each for each in trainer.session.examples if each.is_from_press]
    assert shown == [each for each in examples if each.is_from_press]
    assert trainer.seed is not None
    assert first is not None
    assert trainer.seed == first + 1
    assert trainer.continuation.better is None
    trainer.redo()
    trainer.redo()
    assert keep_going.count_presses(trainer.session.lesson) == 3
    open_session.close()


def test_an_edit_since_the_best_version_is_a_change(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    trainer = open_session.trainer
    fail_by_presses(monkeypatch, {1: 0.2, 2: 0.5})
    begin_with_press(trainer)
    trainer.keep_going()
    press(trainer, "rotate_left")
    shown = [each.number for each in trainer.session.examples if each.is_shown]
    trainer.edit(shown[-1], next="done")
    assert ", before the last 2 changes. Undo them, or go on" in trainer.keep_going().text
    open_session.close()


def test_a_difference_by_chance_is_not_said(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    """97 of 121 and 102 of 146: by Fisher's exact test, so few by chance in 1 of 30 cases."""
    trainer = open_session.trainer
    fail_by_presses(monkeypatch, {1: 0.2, 2: 0.3})
    begin_with_press(trainer)
    trainer.keep_going()
    press(trainer, "rotate_left")
    assert trainer.keep_going().text.startswith("goto works in 102 of 146 new worlds. Here, in ")
    with pytest.raises(SessionError, match="no better version is known"):
        trainer.go_back()
    open_session.close()


def test_at_the_limit_the_best_version_is_named(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also one that was better by no more than chance; then undo leads back to it."""
    trainer = open_session.trainer
    fail_by_presses(monkeypatch, {1: 0.2, 2: 0.3})
    begin_with_press(trainer)
    trainer.keep_going()
    press(trainer, "rotate_left")
    monkeypatch.setattr(keep_going, "MOST_PRESSES", 1)
    said = trainer.keep_going()
    assert said.tone == "error"
    assert said.text == (
        "goto does not hold yet, after 1 press: it works in 102 of 146 new worlds. The best version works in 97 of 121 "
        "after press 1, before the last press: undo it to keep that"
    )
    trainer.go_back()
    assert keep_going.count_presses(trainer.session.lesson) == 1
    open_session.close()


def test_versions_by_another_measure_are_not_compared(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Tested with a target that was not there before, it fails in more worlds."""
    trainer = open_session.trainer
    fail_by_presses(monkeypatch, {1: 0.2, 2: 0.5})
    begin_with_press(trainer)
    trainer.keep_going()
    trainer.cycle_targets()
    press(trainer, "rotate_left")
    assert trainer.keep_going().text.startswith("goto works in 74 of 146 new worlds. Here, in ")
    open_session.close()


def test_nothing_is_offered_once_undone_presses_were_replaced(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Undo leads back to no version that was itself undone."""
    trainer = open_session.trainer
    fail_by_presses(monkeypatch, {2: 0.2, 1: 0.3, 3: 0.6})
    begin_with_press(trainer)
    press(trainer, "rotate_left")
    trainer.keep_going()
    trainer.undo()
    press(trainer, "rotate_right", "forward")
    assert trainer.keep_going().text.startswith("goto works in 58 of 146 new worlds. Here, in ")
    open_session.close()


def list_seeds(trainer: Trainer, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Test the present lesson, and list the seeds of its worlds."""
    seeds = list[int]()

    def note(worlds: NewWorlds, *_: object, **__: object) -> NewWorldsResult:
        seeds.extend(worlds.seeds)
        return NewWorldsResult(np.ones(len(worlds.seeds), np.bool_), np.ones(len(worlds.seeds)), ())

    monkeypatch.setattr(NewWorlds, "run", note)
    assert " holds, " in trainer.keep_going().text
    return seeds


def test_no_world_is_used_twice(open_session: OpenSession, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor after it held, as it may have been taught there; nor when the lesson is opened again."""
    trainer = open_session.trainer
    show(trainer, range(3, 4))
    first, second = list_seeds(trainer, monkeypatch), list_seeds(trainer, monkeypatch)
    assert len(first) >= 100
    show(trainer, range(4, 5))
    trainer.continuation = keep_going.LessonContinuation(trainer)
    third = list_seeds(trainer, monkeypatch)
    assert len({*first, *second, *third}) == len(first) + len(second) + len(third)
    open_session.close()


def go_on_to_the_next_world(trainer: Trainer) -> None:
    trainer.new_world()


def choose_a_situation(trainer: Trainer) -> None:
    coach.go_to_next_situation(trainer)


@pytest.mark.parametrize("go_on", [go_on_to_the_next_world, choose_a_situation])
def test_no_world_that_was_seen_after_a_mistake_is_evidence(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch, go_on: Callable[[Trainer], None]
) -> None:
    """It goes wrong in the last world of its test, so the next worlds are those that are tested next."""
    trainer = open_session.trainer
    begin_with_press(trainer)

    def fail(worlds: NewWorlds, *_: object, **__: object) -> NewWorldsResult:
        count = len(worlds.seeds)
        mistake = Mistake(worlds.seeds[-1], {"A": "station"}, 4.0, "so")
        return NewWorldsResult(np.zeros(count, np.bool_), np.full(count, np.nan), (mistake,))

    with monkeypatch.context() as patch:
        patch.setattr(NewWorlds, "run", fail)
        trainer.keep_going()
    assert trainer.seed is not None
    following = trainer.seed + 1
    go_on(trainer)
    assert following in trainer.seen_seeds
    press(trainer, "rotate_left")
    assert trainer.seen_seeds.isdisjoint(list_seeds(trainer, monkeypatch))
    open_session.close()


def test_while_it_is_tested_it_is_not_tested_again(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    trainer = open_session.trainer
    show(trainer, range(3, 4))
    test = trainer.continuation.begin()
    with pytest.raises(SessionError, match="goto is being tested in new worlds already: wait for the result"):
        trainer.continuation.begin()

    def fail(*_: object, **__: object) -> NewWorldsResult:
        raise ValueError("broken")

    with monkeypatch.context() as patch:
        patch.setattr(NewWorlds, "run", fail)
        with pytest.raises(ValueError, match="broken"):
            test()
    trainer.continuation.begin()
    open_session.close()


def test_without_a_change_it_goes_to_the_next_mistake_of_the_same_test(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pressed twice, it tests once; after the last mistake it tests in other worlds."""
    trainer, tested = open_session.trainer, list[int]()
    show(trainer, range(3, 4))

    def fail(worlds: NewWorlds, *_: object, **__: object) -> NewWorldsResult:
        tested.append(worlds.seeds[0])
        count = len(worlds.seeds)
        mistakes = [Mistake(seed, {"A": "station"}, 4.0, "so") for seed in worlds.seeds[:2]]
        return NewWorldsResult(np.zeros(count, np.bool_), np.full(count, np.nan), tuple(mistakes))

    monkeypatch.setattr(NewWorlds, "run", fail)
    seeds = []
    for _ in range(3):
        trainer.keep_going()
        seeds.append(trainer.seed)
    assert seeds == [tested[0], tested[0] + 1, tested[1]]
    assert len(tested) == 2
    open_session.close()


def test_what_holds_is_said_again_without_a_test(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    trainer = open_session.trainer
    show(trainer, range(3, 4))
    assert list_seeds(trainer, monkeypatch)
    assert list_seeds(trainer, monkeypatch) == []
    trainer.session.change_design(options=replace(trainer.session.lesson.options, reaction_s=0.4))
    assert list_seeds(trainer, monkeypatch)
    open_session.close()


def test_what_was_changed_meanwhile_is_not_judged(open_session: OpenSession) -> None:
    trainer = open_session.trainer
    show(trainer, range(3, 4))
    trainer.continuation.begin()
    trainer.undo()
    said = trainer.continuation.finish(make_result(verdict=Verdict.HOLDS))
    assert said.text == "goto was changed while it was tested: keep going to test it as it is now"
    open_session.close()


def test_presses_that_are_undone_do_not_count(open_session: OpenSession) -> None:
    trainer = open_session.trainer
    show(trainer, range(3, 4))
    trainer.continuation.begin()
    trainer.continuation.finish(make_result(Mistake(7, {"A": "station"}, 4.0, "")))
    trainer.undo()
    trainer.continuation.begin()
    said = trainer.continuation.finish(make_result(verdict=Verdict.HOLDS))
    assert said.text.startswith("goto holds, as it is: ")
    open_session.close()


def test_what_cannot_be_tested_is_refused(open_session: OpenSession, monkeypatch: pytest.MonkeyPatch) -> None:
    trainer = open_session.trainer
    with pytest.raises(SessionError, match="nothing to test yet"):
        trainer.keep_going()
    monkeypatch.setattr(SessionSetup, "from_session", lambda _: None)
    with pytest.raises(SessionError, match="no other worlds"):
        trainer.keep_going()
    open_session.close()
