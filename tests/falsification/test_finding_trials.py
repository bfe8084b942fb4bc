"""Trials of findings: a robot that turns 3 m from a ball, so that what needs the ball near never happens."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import msgspec
import pytest
from tests.sim.patrollers import ROBOTS, lead
from tests.sim.patrollers import SCENARIO as PATROL

from understudy.addons.checks.falsification.finding_trials import try_findings
from understudy.addons.checks.verification.check_library import CheckReport, check_library
from understudy.addons.checks.verification.finding import Finding, FindingCell, FindingKind, Severity
from understudy.addons.checks.verification.scenario_facts import collect_scenario_facts
from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature
from understudy.model.library import Library
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.model.tree_regions import ValueSet
from understudy.sim.scenario.schema import (
    ObjectClass,
    RobotGroup,
    RobotType,
    Scenario,
    TargetLocator,
    TargetSpec,
)
from understudy.sim.team.libraries import collect_libraries
from understudy.sim.world import World

SCENARIO = Scenario(
    size=(10.0, 10.0),
    limit_s=5.0,
    objects=(ObjectClass(name="ball", at=((5.0, 5.0),)),),
    types={
        "robot": RobotType(
            sensors=(TargetLocator(),),
            behaviors={"left": {"turn": 1.0}, "right": {"turn": -1.0}, "ahead": {"drive": 1.0}},
        )
    },
    robots=(RobotGroup(type="robot", at=((2.0, 5.0, 0.0),)),),
    targets={"ball": TargetSpec(object="ball")},
)
KIT = World(SCENARIO).kit
LEFT, RIGHT, AHEAD = State("left", "left"), State("right", "right"), State("ahead", "ahead")


def distance(target: str) -> BoundFeature:
    return BoundFeature(KIT.features["distance_to"], Binding(A=target))


def always(outcome: int) -> Tree:
    return Tree((make_leaf(outcome),))


def near(then: int, otherwise: int) -> Tree:
    """A tree that answers one state within 1 m, and another elsewhere."""
    return Tree((Node(TestKind.BELOW, 0, high=1.0, yes=1, no=2), make_leaf(then), make_leaf(otherwise)))


TURN = Automaton(
    "turn",
    (START, LEFT, RIGHT, AHEAD),
    (distance("A"),),
    ("A",),
    transitions={"start": always(1), "left": near(3, 2), "right": always(1), "ahead": near(1, STAY)},
)
"""Left and right undo each other from 1 m on; left and ahead within 1 m, where it never is."""
SPIN = Automaton(
    "spin",
    (START, State("turn", "turn", Binding(A="ball"))),
    (distance("ball"),),
    transitions={"start": always(1), "turn": near(0, 1)},
)
READY = Automaton(
    "ready", (START, State("done", flag="done")), (distance("ball"),), transitions={"start": near(STAY, 1)}
)
WAIT = Automaton(
    "wait",
    (START, State("ready", "ready"), LEFT),
    (distance("ball"),),
    transitions={"start": always(1), "ready": near(2, 1)},
)
"""Ready is done from 1 m on, and wait stays there for good."""


def check(*automata: Automaton, worlds: int = 3, limit_s: float = 5.0) -> CheckReport:
    library = Library.from_automata(KIT, *automata)
    scenario = replace_limit(limit_s)
    report = check_library(library, facts=collect_scenario_facts(scenario, library), kit_known=True)
    return try_findings(report, library, scenario, worlds=worlds)


def replace_limit(limit_s: float) -> Scenario:
    return msgspec.structs.replace(SCENARIO, limit_s=limit_s)


def find(report: CheckReport, kind: FindingKind) -> list[Finding]:
    return [each for each in report.findings if each.kind is kind]


def test_what_happens_comes_before_what_does_not() -> None:
    """The cells of turn are about A, which spin binds to the ball."""
    found = find(check(TURN, SPIN), FindingKind.CHATTER)
    happens, never = (each for each in found if each.automaton == "turn")
    assert (happens.states, never.states) == (("left", "right"), ("left", "ahead"))
    assert str(happens.trial) == "happens in 3 of 3 worlds"
    assert str(never.trial) == "did not happen in 3 worlds"
    assert happens.trial is not None
    # of 50 ticks, all but those until it has come back to left for the first time
    assert happens.trial.share == pytest.approx(47 / 50, abs=1e-9)


def test_a_dead_end_happens_where_it_stays() -> None:
    (found,) = find(check(READY, WAIT), FindingKind.DEAD_END)
    assert found.severity == "error"  # nothing but the robot moves
    assert found.trial is not None
    assert found.trial.happened == 3
    assert found.trial.share == pytest.approx(1 / 3)  # start, done, and it has stayed: then no more


def test_what_cannot_happen_in_so_short_a_run_does_not() -> None:
    (found,) = find(check(READY, WAIT, limit_s=0.1), FindingKind.DEAD_END)
    assert found.trial is not None
    assert found.trial.happened == 0


def test_what_no_behavior_runs_is_not_tried() -> None:
    (first, second) = find(check(TURN), FindingKind.CHATTER)  # turn has a parameter, and nothing runs it
    assert first.trial is None
    assert second.trial is None


def test_an_automaton_of_another_sort_is_not_taken_for_one_of_the_robots() -> None:
    findings = [
        Finding(FindingKind.NEVER_LEFT, Severity.WARNING, name, "", ("left",))
        for name in ("turn", "squad/turn", "robot/turn")
    ]
    report = CheckReport(tuple(findings), ())
    tried = try_findings(report, Library.from_automata(KIT, TURN, SPIN), SCENARIO, worlds=2).findings
    assert {each.automaton for each in tried if each.trial is not None} == {"turn", "robot/turn"}


def test_without_worlds_nothing_is_tried() -> None:
    report = check(TURN, SPIN, worlds=0)
    assert all(each.trial is None for each in report.findings)


def test_what_cannot_be_run_is_said() -> None:
    lost = replace(SPIN, states=(START, State("turn", "turn", Binding(A="moon"))))
    library = Library.from_automata(KIT, TURN, lost)
    report = try_findings(check_library(library), library, SCENARIO, worlds=2)
    assert any("spin" in reason and "moon" in reason for reason in report.unchecked)


def test_members_and_coordinators_of_a_team_are_tried() -> None:
    """The robots' patrol is run by itself, since the coordinator never orders it."""
    kit = collect_libraries(PATROL, ROBOTS)["patrol"].kit
    leading = Library.from_automata(kit, lead())
    libraries = collect_libraries(PATROL, ROBOTS, lambda _name, _kit: leading)
    findings = [
        Finding(FindingKind.NEVER_LEFT, Severity.WARNING, name, "", (states[1].name,))
        for name, states in (
            ("patrol/lead", lead().states),
            ("patrol", ROBOTS.automaton("patrol").states),
        )
    ]
    report = CheckReport(tuple(findings), ())
    scenario = msgspec.structs.replace(PATROL, limit_s=2.0)
    trials = [each.trial for each in try_findings(report, libraries, scenario, worlds=2).findings]
    assert [str(each) for each in trials] == ["happens in 2 of 2 worlds"] * 2


CELLS = [  # values of the distance of the cell, and in how many of two worlds the robot turns left there
    (ValueSet(((-inf, 1.0),), False), 0),
    (ValueSet(((1.0, inf),), False), 2),
    (ValueSet(((0.0, 1.0), (2.9, 3.1)), False), 2),
    (ValueSet((), True), 0),
]


@pytest.mark.parametrize(("values", "worlds"), CELLS)
def test_only_readings_in_the_cell_count(values: ValueSet, worlds: int) -> None:
    cell = FindingCell((distance("A"),), (values,), (0.0,), "")
    finding = Finding(FindingKind.NEVER_SHOWN, Severity.WARNING, "turn", "", ("left",), cells=(cell,))
    library = Library.from_automata(KIT, TURN, SPIN)
    (tried,) = try_findings(CheckReport((finding,), ()), library, SCENARIO, worlds=2).findings
    assert tried.trial is not None
    assert tried.trial.happened == worlds
