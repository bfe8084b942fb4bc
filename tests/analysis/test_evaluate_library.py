"""A behavior judged on many worlds: beside the yardstick where there is one, by the scenario's goal elsewhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace
from tests.sim.patrollers import ROBOTS, SCENARIO
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.errors import SettingError, UnboundParameter, UnknownName
from understudy.judging.baseline import LENIENCE, ControllerRun
from understudy.judging.behavior_run import ProgramRun
from understudy.judging.evaluate import evaluate, find_success_flag
from understudy.judging.outcomes import measure_success
from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature, TimeInState, feature
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.value_kinds import Column, Continuous
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.runtime.run_loop import Run
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT, ForageSettings
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import format_scenario
from understudy.sim.scenario.schema import Goal, Scenario
from understudy.sim.team.libraries import collect_libraries
from understudy.sim.world import World
from understudy_lab.tree_builder import build_automaton, split_below

FORAGE, TEAM, ARENA = (find_scenario(name) for name in ("forage", "forage-team", "arena"))
LIBRARY = Library.from_automata(FORAGE_KIT, *AUTOMATA)
LAZY = Automaton("lazy")


def test_side_by_side_as_one_by_one() -> None:
    together = evaluate(LIBRARY, "forage", FORAGE, range(5, 9))
    alone = [evaluate(LIBRARY, "forage", FORAGE, [seed]) for seed in range(5, 9)]
    assert together.taught.seconds.tolist() == [each.taught.seconds[0] for each in alone]
    assert together.expert is not None
    assert together.expert.seconds.tolist() == [each.expert.seconds[0] for each in alone if each.expert]
    assert together.relative_to_expert == np.median([each.relative_to_expert for each in alone])
    assert together.success == 1.0


@pytest.mark.parametrize("scenario", [FORAGE, TEAM], ids=lambda each: each.name)
def test_as_interpreters_would(scenario: Scenario) -> None:
    """In one go or tick by tick, with limits that some worlds reach and others do not."""
    library = Library.from_automata(make_scenario_kit(scenario), *AUTOMATA)
    program, limits = link(library, "forage"), np.array([20.0, 300.0, 95.05, 0.0])
    fused = measure_success(ProgramRun(World(scenario, range(4)), program, library, {}), limits)
    world = World(scenario, range(4))
    run = Run.from_program(world, program)
    ticked = measure_success(ControllerRun(world, run.decide, run.keys), limits)
    assert np.array_equal(fused.seconds, ticked.seconds, equal_nan=True)
    assert fused.delivered.tolist() == ticked.delivered.tolist()


def test_worlds_that_ended_at_different_times_have_no_one_time() -> None:
    program, world = link(LIBRARY, "forage"), World(FORAGE, range(2))
    measure_success(ProgramRun(world, program, LIBRARY, {}), 300.0)
    for attempt in (lambda: Engine.from_program(world, program), lambda: world.time_s):
        with pytest.raises(SettingError, match=r"time_s differs between its worlds.*reset"):
            attempt()
    assert world.view(0).time_s != world.view(1).time_s
    world.reset([0, 1])
    Engine.from_program(world, program).tick()
    assert world.time_s == world.tick_s


@feature(Continuous())
def read_range_twice(robot: object) -> Column:
    """A function, so that nothing runs in one go."""
    return np.asarray(2.0 * robot.food_stored)  # type: ignore[attr-defined]


def test_functions_are_judged_the_same() -> None:
    forage = AUTOMATA[-1]
    computing = Automaton(
        forage.name,
        forage.states,
        (*forage.features, BoundFeature(read_range_twice)),
        transitions=forage.transitions,
    )
    library = Library.from_automata(FORAGE_KIT, *AUTOMATA[:-1], computing)
    plain, computed = (evaluate(each, "forage", FORAGE, range(3)) for each in (LIBRARY, library))
    assert computed.taught.seconds.tolist() == plain.taught.seconds.tolist()
    assert computed.taught.delivered.tolist() == plain.taught.delivered.tolist()


def test_in_batches_as_all_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = evaluate(LIBRARY, "forage", FORAGE, range(5))
    monkeypatch.setattr("understudy.judging.evaluation_task.WORLDS_AT_ONCE", 2)
    calls: list[tuple[int, int]] = []
    parts = evaluate(
        LIBRARY, "forage", FORAGE, range(5), progress=lambda done, total: calls.append((done, total))
    )
    assert parts.taught.seconds.tolist() == whole.taught.seconds.tolist()
    assert parts.relative_to_expert == whole.relative_to_expert
    assert [done for done, _ in calls] == sorted(done for done, _ in calls)
    assert (calls[0], calls[-1]) == ((0, 5), (5, 5))


@pytest.mark.parametrize("after", [0, 1, 700])
def test_an_evaluation_is_ended_by_what_its_progress_raises(after: int) -> None:
    """While the yardstick runs, too, of which no world counts as through."""
    calls = list[int]()

    def end(through: int, _: int) -> None:
        calls.append(through)
        if len(calls) > after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        evaluate(LIBRARY, "forage", FORAGE, range(3), progress=end)
    assert calls == [0] * (after + 1)


def test_who_does_nothing_fails_at_three_times_the_yardstick() -> None:
    library = Library.from_automata(FORAGE_KIT, LAZY)
    judged = evaluate(library, "lazy", FORAGE, range(3))
    assert (judged.success, judged.relative_to_expert) == (0.0, 0.0)
    assert judged.expert is not None
    assert judged.taught.limit_s.tolist() == (LENIENCE * judged.expert.seconds).tolist()


def test_a_goal_of_any_scenario() -> None:
    """GoTo drives to the flag where nothing is in the way; there is no yardstick, but the limit of the scenario."""
    library = Library.from_automata(make_scenario_kit(ARENA), AUTOMATA[0])
    free = replace(ARENA, obstacles=(), limit_s=80.0)
    judged = evaluate(library, "goto", free, range(4), binding={"A": "red_flag"})
    assert judged.success == 1.0
    assert judged.expert is None
    assert np.isnan(judged.relative_to_expert)
    assert judged.taught.limit_s.tolist() == [80.0] * 4
    assert evaluate(library, "rotate_left", free, range(4)).success == 0.0


def test_a_team_brings_food_home() -> None:
    judged = evaluate(Library.from_automata(make_scenario_kit(TEAM), *AUTOMATA), "forage", TEAM, range(3))
    assert (judged.taught.limit_s == TEAM.limit_s).all()
    assert judged.taught.delivered.sum() > 0


def test_numbers_may_differ_from_the_yardsticks_own() -> None:
    judged = evaluate(LIBRARY, "forage", ForageSettings(capacity=10, width=8.0).scenario(), range(2))
    assert judged.expert is not None
    assert judged.expert.seconds.min() > 0


def test_a_scenario_without_a_goal_cannot_be_judged() -> None:
    with pytest.raises(SettingError, match=r"goal is missing.* give it a \[goal\]"):
        evaluate(LIBRARY, "forage", replace(FORAGE, goal=None), [1])


def test_a_behavior_that_says_when_it_is_done_is_judged_by_that() -> None:
    """Whatever the scenario's goal is, tick by tick as an interpreter would; the yardstick is of the goal only."""
    judged = evaluate(LIBRARY, "goto", FORAGE, range(6), binding={"A": "station"})
    assert (judged.flag, judged.success, judged.expert) == ("done", 1.0, None)
    program = link(LIBRARY, "goto", {"A": "station"})
    for seed, seconds in zip(judged.seeds, judged.taught.seconds.tolist(), strict=True):
        run = Run.from_program(World(FORAGE, [seed]), program)
        while run.interpreters[0].root.flag is None:
            run.tick()
        assert run.body.time_s == seconds
    assert evaluate(LIBRARY, "forage", FORAGE, range(2)).flag is None


FLAGS = [  # what a behavior can raise; what it is judged by
    ((), None),
    (("done",), "done"),
    (("there",), "there"),
    (("there", "done"), "done"),
    (("failed",), None),
    (("seen", "lost"), None),
    (("there", "failed"), "there"),
]


@pytest.mark.parametrize(("flags", "judged_by"), FLAGS)
def test_a_behavior_is_judged_by_its_own_goal(flags: tuple[str, ...], judged_by: str | None) -> None:
    states = (START, *(State(flag, flag=flag) for flag in flags))
    library = Library(FORAGE_KIT).with_automaton(TrainedAutomaton(Automaton("go", states)))
    assert find_success_flag(library, "go") == judged_by
    assert find_success_flag(library, "forward") is None


def test_who_says_done_too_late_has_failed() -> None:
    """By one tick, in worlds with different times; and without a goal, too."""
    seconds = evaluate(LIBRARY, "goto", FORAGE, range(6), binding={"A": "station"}).taught.seconds
    limit_s = float(np.sort(seconds)[3])
    short = replace(FORAGE, goal=None, limit_s=limit_s)
    judged = evaluate(LIBRARY, "goto", short, range(6), binding={"A": "station"})
    assert judged.taught.finished.tolist() == (seconds <= limit_s).tolist()
    assert judged.success == pytest.approx(4 / 6)
    shorter = evaluate(
        LIBRARY, "goto", replace(short, limit_s=limit_s - 0.1), range(6), binding={"A": "station"}
    )
    assert shorter.success == pytest.approx(3 / 6)


def test_all_robots_have_to_say_done() -> None:
    library = Library.from_automata(make_scenario_kit(TEAM), *AUTOMATA)
    program, limit_s = link(library, "goto", {"A": "station"}), 60.0
    goto = ProgramRun(World(TEAM, range(3)), program, library, {"A": "station"})
    outcomes = measure_success(goto, limit_s, flag="done")
    for seed, seconds in enumerate(outcomes.seconds.tolist()):
        run = Run.from_program(World(TEAM, [seed]), program)
        while run.body.time_s < limit_s - 0.05 and any(agent.root.flag is None for agent in run.interpreters):
            run.tick()
        done = all(agent.root.flag == "done" for agent in run.interpreters)
        assert (run.body.time_s if done else np.nan) == pytest.approx(seconds, nan_ok=True)


def test_a_world_by_name_or_path(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(format_scenario(replace(FORAGE, limit_s=1.0, goal=Goal(target="station"))))
    assert evaluate(LIBRARY, "forage", path, [1]).taught.limit_s.tolist() == [1.0]
    with pytest.raises(UnknownName, match="no world 'moon'; it has arena, boxes, forage"):
        evaluate(LIBRARY, "forage", "moon", [1])


def test_parameters_are_bound() -> None:
    evaluate(LIBRARY, "goto", FORAGE, [0], binding={"A": "station"})
    with pytest.raises(UnboundParameter, match="bind it to one of the targets"):
        evaluate(LIBRARY, "goto", FORAGE, [0])
    with pytest.raises(SettingError, match="seeds"):
        evaluate(LIBRARY, "forage", FORAGE, [])


def test_seeds_that_are_no_list_are_refused() -> None:
    with pytest.raises(SettingError, match="seeds are 5; give a list"):
        evaluate(LIBRARY, "forage", FORAGE, 5)  # type: ignore[arg-type]


def test_a_coordinator_is_done_when_it_says_so() -> None:
    """After two seconds of its order to wander, in every world; robots of a type are asked for theirs alone."""
    below = {"time": BoundFeature(TimeInState())}
    brief = build_automaton(
        "brief",
        {"start": "out", "out": split_below("time", 2.0, "out", "done")},
        readings=below,
        flags=("done",),
        runs={"out": "wander"},
    )
    known = collect_libraries(SCENARIO, ROBOTS, lambda name, kit: Library.from_automata(kit, brief))
    judged = evaluate(known, "patrol/brief", SCENARIO, range(3))
    assert (judged.flag, judged.success) == ("done", 1.0)
    assert judged.taught.seconds == pytest.approx([2.2] * 3, abs=0.11)
    with pytest.raises(SettingError, match="seeds are none"):
        evaluate(known, "patrol/brief", SCENARIO, [])
