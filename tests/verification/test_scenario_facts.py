"""What a scenario guarantees of the end of its runs, and of a robot that stands."""

from __future__ import annotations

import msgspec
import pytest
from tests.ui.cli.forage_parts import ALWAYS, AUTOMATA

from understudy.addons.checks.verification.check_library import check_library
from understudy.addons.checks.verification.finding import Finding, FindingKind
from understudy.addons.checks.verification.scenario_facts import (
    collect_scenario_facts,
    list_goal_ties,
    list_still_readings,
)
from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature
from understudy.model.library import Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT
from understudy.sim.scenario.schema import Goal, RandomWalk, Scenario

FORAGE = find_scenario("forage")
LIBRARY = Library.from_automata(FORAGE_KIT, *AUTOMATA)


def change(**fields: object) -> Scenario:
    return msgspec.structs.replace(FORAGE, **fields)


def with_robots(**fields: object) -> Scenario:
    return change(robots=tuple(msgspec.structs.replace(each, **fields) for each in FORAGE.robots))


def with_food(**fields: object) -> Scenario:
    of_food = [msgspec.structs.replace(each, **fields) if each.amount else each for each in FORAGE.objects]
    return change(objects=tuple(of_food))


def with_sensors(**fields: object) -> Scenario:
    forager = FORAGE.types["forager"]
    first, *others = forager.sensors
    sensors = (msgspec.structs.replace(first, **fields), *others)
    return change(types={"forager": msgspec.structs.replace(forager, sensors=sensors)})


STILL = [  # a scenario, and whether the distance and the food that is left stand still while the robot idles
    (FORAGE, True, True),
    (with_robots(count=2), False, False),
    (with_food(walk=RandomWalk(speed=0.1)), False, False),
    (with_sensors(noise_range=0.1), False, True),
    (with_sensors(rate_hz=2.0), False, True),
]


@pytest.mark.parametrize(("scenario", "distance", "left"), STILL)
def test_what_stands_still_with_the_robot(scenario: Scenario, distance: bool, left: bool) -> None:
    still = list_still_readings(scenario)
    assert ("range" in still, "food_left" in still) == (distance, left)


GOALS = [  # a scenario, and the ends of its runs in words
    (FORAGE, ["the run ends once food_left is no and food_stored is 0"]),
    (with_robots(count=2), []),  # the other one may still carry food
    (change(goal=None), []),
    (with_sensors(noise_range=0.1), []),
    (change(goal=Goal(target="station", within=0.4)), ["distance_to(station) is at most 0.4 m"]),
]


@pytest.mark.parametrize(("scenario", "ends"), GOALS)
def test_readings_that_mean_that_the_goal_is_reached(scenario: Scenario, ends: list[str]) -> None:
    found = [each.sentence for each in list_goal_ties(scenario, LIBRARY)]
    assert len(found) == len(ends)
    assert all(end in text for end, text in zip(ends, found, strict=True))


LEFT, STORED = (BoundFeature(FORAGE_KIT.features[name]) for name in ("food_left", "food_stored"))


def home(then: int, otherwise: int) -> Tree:
    """A tree that answers one state with no food left and none on board, and another elsewhere."""
    left = Node(TestKind.LABEL, 0, branches=(1, 2))
    stored = Node(TestKind.BELOW, 1, high=1.0, yes=3, no=2)
    return Tree((left, stored, make_leaf(otherwise), make_leaf(then)))


def find_chatter(scenario: Scenario) -> list[Finding]:
    """The chatter of an automaton that goes to and fro with no food left and none on board, and only there."""
    states = (START, State("to", "forward"), State("fro", "rotate_left"))
    trees = {"start": ALWAYS, "to": home(2, 1), "fro": home(1, 2)}
    pace = Library.from_automata(FORAGE_KIT, Automaton("pace", states, (LEFT, STORED), transitions=trees))
    found = check_library(pace, facts=collect_scenario_facts(scenario, pace)).findings
    return [each for each in found if each.kind is FindingKind.CHATTER]


def test_what_happens_only_after_the_end_is_not_reported() -> None:
    assert len(find_chatter(change(goal=None))) == 1
    assert len(find_chatter(with_robots(count=2))) == 1
    assert not find_chatter(FORAGE)


def test_states_of_the_end_are_entered() -> None:
    """That the run ends within 0.4 m does not mean that done, from 0.3 m on, is never entered."""
    scenario = change(goal=Goal(target="station", within=0.4))
    report = check_library(LIBRARY, facts=collect_scenario_facts(scenario, LIBRARY))
    assert FindingKind.NEVER_ENTERED not in {each.kind for each in report.findings}
