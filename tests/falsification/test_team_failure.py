"""A failing world of a team with a coordinator: a session begins before it goes wrong, as the team was then."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from msgspec.structs import replace as with_changes
from tests.sim.patrollers import ROBOTS, SCENARIO
from tests.training.test_squad_session import LESSON as LEAD
from tests.training.test_squad_session import coordinator_body, teach_patrol

from understudy.addons.checks.falsification.failing_world import FailingWorld, FailureFacts
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.open_failure import BEFORE_S, open_failure
from understudy.errors import SessionError, UnknownName
from understudy.model.library import Library, TrainedAutomaton
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.runtime.team.team import Team
from understudy.sim.scenario.files import add_markers
from understudy.sim.team.libraries import Libraries, collect_libraries, make_scenario_team
from understudy.sim.world import World
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy.training.trainee import Mode

SEED, WRONG_S = 5, 16.0
ROOTS = {"patrol": ("lead", dict[str, str]())}
WORLD = add_markers(SCENARIO)


def teach_lead() -> TrainedAutomaton:
    """Teach a coordinator as a person does in two minutes."""
    libraries = collect_libraries(SCENARIO, ROBOTS)
    session = Session(coordinator_body(), libraries["patrol"], LEAD)
    teach_patrol(session, 120.0)
    return session.make_trained_automaton()


@pytest.fixture(scope="module")
def lead() -> TrainedAutomaton:
    return teach_lead()


def make_wander() -> TrainedAutomaton:
    """A wander as a person taught it: forward, and on."""
    lesson = new_lesson(ROBOTS, "wander", states=["forwards"], features=["stuck"], live=True)
    session = Session(World(SCENARIO, [1]), ROBOTS, lesson)
    session.direct("forwards")
    session.run_for(1.0)
    return session.make_trained_automaton()


def make_team_libraries(lead: TrainedAutomaton, *, robots: Library = ROBOTS) -> Libraries:
    return collect_libraries(SCENARIO, robots, lambda _, kit: Library(kit).with_automaton(lead))


def make_failing(robot: int = 2, wrong_s: float = WRONG_S) -> FailingWorld:
    """A world that counts as one that goes wrong at a time, for a robot."""
    facts = FailureFacts(
        behavior="lead", binding={}, seed=SEED, limit_s=60.0, robustness=-1.0, wrong_s=wrong_s, end_hash="",
        robot=robot, found_by="random", steps=(), why=(),
    )  # fmt: skip
    return FailingWorld(Path("nowhere"), Trial(SCENARIO, SEED), facts)


def make_run(libraries: Libraries, ticks: int) -> Team:
    """The same team, run from the start without a session."""
    team = make_scenario_team(World(WORLD, [SEED]), WORLD, libraries, ROOTS, seeds=[SEED])
    for _ in range(ticks):
        team.tick()
    return team


def places(world: object) -> list[tuple[float, float, float]]:
    """Where the robots are."""
    assert isinstance(world, World)
    robots = world.view().robots
    return list(zip(robots.x.tolist(), robots.y.tolist(), robots.heading.tolist(), strict=True))


def test_a_coordinator_is_opened_and_its_team_goes_on_bit_for_bit(lead: TrainedAutomaton) -> None:
    """Without a press, the session runs on as the team does, through changes of orders."""
    libraries = make_team_libraries(lead)
    session = open_failure(make_failing(), libraries)
    assert isinstance(session.body, CoordinatorBody)
    assert (session.automaton.name, session.agent, session.mode) == ("lead", 0, Mode.LIVE)
    assert session.body.time_s == pytest.approx(WRONG_S - BEFORE_S)
    team = make_run(libraries, round((WRONG_S - BEFORE_S) / SCENARIO.tick_s))
    orders = set[str]()
    for _ in range(200):
        assert places(session.body.ground) == places(team.ground)
        assert session.body.team.paths == team.paths
        orders.add(team.paths[2][0])
        session.tick()
        team.tick()
    assert len(orders) > 1


def test_a_press_corrects_the_coordinator(lead: TrainedAutomaton) -> None:
    libraries = make_team_libraries(lead)
    session = open_failure(make_failing(), libraries)
    assert isinstance(session.body, CoordinatorBody)
    other = "home" if session.view().state != "home" else "out"
    session.direct(other)
    session.tick()
    assert session.view().state == other
    assert len(session.examples) > len(lead.lesson.examples if lead.lesson is not None else ())
    assert {path[0] for path in session.body.team.paths} == {"servo(home)" if other == "home" else "wander"}


def test_a_coordinator_is_opened_at_the_start(lead: TrainedAutomaton) -> None:
    libraries = make_team_libraries(lead)
    session = open_failure(make_failing(wrong_s=0.1), libraries)
    team = make_run(libraries, 0)
    assert isinstance(session.body, CoordinatorBody)
    assert (session.view().state, session.body.time_s) == ("start", 0.0)
    for _ in range(100):
        assert places(session.body.ground) == places(team.ground)
        session.tick()
        team.tick()


def test_a_member_is_opened_where_its_automaton_has_a_lesson(lead: TrainedAutomaton) -> None:
    """It goes on exactly until orders change; then others keep their last orders, since nobody gives new ones."""
    wander = make_wander()
    libraries = make_team_libraries(lead, robots=ROBOTS.with_automaton(wander))
    wrong_s = 5.0
    session = open_failure(make_failing(wrong_s=wrong_s), libraries, name="wander", before_s=0.5)
    assert isinstance(session.body, World)
    assert (session.automaton.name, session.agent) == ("wander", 2)
    again = make_run(libraries, round(session.body.time_s / SCENARIO.tick_s))
    while again.paths[2][:1] == ("wander",):
        assert places(session.body) == places(again.ground)
        session.tick()
        again.tick()
    assert again.ground.time_s > 6.0
    session.tick()
    assert session.view().path == ("forwards",)
    assert open_failure(make_failing(wrong_s=wrong_s), libraries).automaton.name == "wander"
    assert open_failure(make_failing(wrong_s=wrong_s), libraries, name="lead").automaton.name == "lead"


def test_what_cannot_be_opened_is_said(lead: TrainedAutomaton) -> None:
    libraries = make_team_libraries(lead)
    with pytest.raises(UnknownName, match=r"'march'.*lead"):
        open_failure(make_failing(), libraries, name="march")
    bare = {
        **libraries,
        "patrol": Library(libraries["patrol"].kit).with_automaton(replace(lead, lesson=None)),
    }
    with pytest.raises(SessionError, match="has no lesson"):
        open_failure(make_failing(), bare)
    without = replace(make_failing(), trial=Trial(with_changes(SCENARIO, squads={}), SEED))
    with pytest.raises(UnknownName, match="lead"):
        open_failure(without, ROBOTS)
