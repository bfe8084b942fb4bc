"""Success of a behavior without a flag: by the goal that a person has chosen for it, in new worlds."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from multiprocessing.reduction import ForkingPickler

import numpy as np
import pytest
from msgspec import UNSET, structs

from understudy.addons.checks.falsification.holding_test import HoldingTest
from understudy.addons.checks.falsification.new_worlds import NewWorlds
from understudy.addons.checks.falsification.session_setup import SessionSetup
from understudy.judging.evaluate import evaluate
from understudy.judging.properties.monitor import PropertyRule
from understudy.judging.properties.run_property import Verdict
from understudy.learning.fit import learn_automaton
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.property import Property, PropertyKind, SeededWorlds
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.schema import RobotGroup
from understudy.training.lesson_design import new_lesson

ARENA = find_scenario("arena")
START = SeededWorlds("arena", (), 20.0)
TOUCHES = Property(
    kind=PropertyKind.NEVER, what="clearance is below 5 mm", start=START, name="never touches anything"
)
MOVES = Property(kind=PropertyKind.ALWAYS, what="covered is at least 1 m²", seconds=20.0, start=START)
AHEAD = Property(kind=PropertyKind.NEVER_LONGER, what="sonar_ahead is below 0.5 m", seconds=3.0, start=START)


def teach(state: str, goal: Property | None) -> Library:
    """Return the library with a behavior that begins one state, and stays in it."""
    library = Library(make_scenario_kit(ARENA))
    lesson: Lesson = new_lesson(library, "go", states=[state], features=["sonar_ahead"])
    lesson = replace(lesson, examples=(Example(1, "start", (1.0,), state, ExampleKind.DIRECTIVE),), goal=goal)
    return library.with_automaton(TrainedAutomaton(learn_automaton(lesson), lesson))


WORKS = [  # behavior, goal -> whether it works in all worlds, in some or in none
    ("forward", TOUCHES, "some"),
    ("rotate_left", TOUCHES, "all"),
    ("forward", MOVES, "all"),
    ("rotate_left", MOVES, "none"),
    ("forward", AHEAD, "some"),
    ("rotate_left", AHEAD, "all"),
]


@pytest.mark.parametrize(("state", "goal", "works"), WORKS)
def test_it_works_where_the_goal_holds(state: str, goal: Property, works: str) -> None:
    """A robot that only drives ahead runs into something in 20 s, in most worlds; one that turns touches nothing."""
    worlds = NewWorlds(SessionSetup(ARENA), range(40))
    result = worlds.run(teach(state, goal), "go", {})
    assert {40: "all", 0: "none"}.get(int(result.works.sum()), "some") == works
    assert (np.isnan(result.seconds) == ~result.works).all()
    assert [each.seed for each in result.mistakes] == np.flatnonzero(~result.works).tolist()
    assert all(0.0 <= each.wrong_s <= 20.0 for each in result.mistakes)


def test_a_mistake_says_what_does_not_hold() -> None:
    worlds = NewWorlds(SessionSetup(ARENA), range(40))
    named = worlds.run(teach("forward", TOUCHES), "go", {}).mistakes[0]
    assert named.why == "this does not hold: it never touches anything"
    claimed = worlds.run(teach("rotate_left", MOVES), "go", {}).mistakes[0]
    assert (claimed.wrong_s, claimed.why) == (
        20.0,
        "this does not hold: covered is at least 1 m² within 20 s",
    )


def test_reaching_the_goal_of_the_world_ends_no_run() -> None:
    """A robot passes the flag after 2 m, and runs into the edge of the arena after 10 m more."""
    flags = tuple(
        structs.replace(each, at=((4.0, y),), count=UNSET, within=None)
        for each, y in zip(ARENA.objects[:2], (5.0, 9.0), strict=True)
    )
    robots = (RobotGroup(type="rover", at=((2.0, 5.0, 0.0),)),)
    scenario = structs.replace(ARENA, obstacles=(), objects=(*flags, *ARENA.objects[2:]), robots=robots)
    worlds = NewWorlds(SessionSetup(scenario), [0])
    touches = replace(TOUCHES, start=replace(START, limit_s=60.0))
    assert worlds.run(teach("forward", touches), "go", {}).mistakes[0].wrong_s == pytest.approx(19.6, abs=0.2)
    reaches = replace(touches, what="goal is reached")
    assert worlds.run(teach("forward", reaches), "go", {}).mistakes[0].wrong_s == pytest.approx(3.2, abs=0.2)


def test_keep_going_tests_the_chosen_goal() -> None:
    holds = HoldingTest(partial(NewWorlds, SessionSetup(ARENA)), 500).test(
        teach("rotate_left", TOUCHES), "go", [{}]
    )
    assert (holds.verdict, holds.mistakes) == (Verdict.HOLDS, ())
    fails = HoldingTest(partial(NewWorlds, SessionSetup(ARENA)), 500).test(
        teach("rotate_left", MOVES), "go", [{}]
    )
    assert (fails.verdict, fails.held) == (Verdict.FAILS, 0)


def test_an_evaluation_counts_it() -> None:
    """The same worlds as in the score; the time of a success is how long the goal held."""
    library = teach("forward", TOUCHES)
    seeds = range(40)
    found = evaluate(library, "go", ARENA, seeds, goal=PropertyRule(TOUCHES))
    works = NewWorlds(SessionSetup(ARENA), seeds).run(library, "go", {})
    assert found.taught.finished.tolist() == works.works.tolist()
    assert set(found.taught.seconds[works.works]) == {20.0}
    assert (found.goal, found.flag, found.expert) == ("never touches anything", None, None)


def test_jobs_and_metrics_know_it() -> None:
    """A rule can be sent to other processes, and metrics are read where its worlds end."""
    library, rule = teach("forward", TOUCHES), PropertyRule(TOUCHES)
    alone = evaluate(library, "go", ARENA, range(200), goal=rule)
    with ThreadPoolExecutor(2) as executor:
        shared = evaluate(
            library, "go", ARENA, range(200), goal=ForkingPickler.loads(ForkingPickler.dumps(rule)), metrics=["bumper"],
            jobs=4, executor=executor,
        )  # fmt: skip
    assert shared.taught.finished.tolist() == alone.taught.finished.tolist()
    assert 0 < alone.success < 1
    assert (shared.metrics["bumper"][alone.taught.finished] == 0).all()
