"""What a session runs is run in other worlds in the same way: the same robots, others and coordinator."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from msgspec.structs import replace
from tests.sim.patrollers import ROBOTS, SCENARIO
from tests.training.test_squad_session import LESSON, teach_patrol

from understudy.addons.checks.falsification import new_worlds
from understudy.addons.checks.falsification.new_worlds import NewWorlds
from understudy.addons.checks.falsification.session_setup import SessionSetup
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import IDLE_PROGRAM, link
from understudy.sim.scenario.squad_schema import CommsSpec
from understudy.sim.team.libraries import collect_libraries, make_coordinator_body
from understudy.sim.world import World
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

SEEDS, TICKS = [7, 9], 200
BAD_RADIO = CommsSpec(delay_s=0.3, loss=0.3)


def teach_robot() -> Session:
    """The third of four robots drives forwards, and backs off for good as soon as it is stuck."""
    lesson = new_lesson(
        ROBOTS,
        "roam",
        states=["forwards", "backwards"],
        flags=["done"],
        features=["stuck"],
        live=True,
    )
    session = Session(World(SCENARIO, [1]), ROBOTS, lesson, agent=2)
    session.direct("forwards")
    session.run_for(1.0)
    session.direct("done")
    session.tick()
    return session


def teach_saved() -> Session:
    """The other robots run the same behavior as it was saved before."""
    session = teach_robot()
    session.set_other_agents("roam", library=session.library.with_automaton(session.make_trained_automaton()))
    return session


def teach_among_turning() -> Session:
    session = teach_robot()
    session.set_other_agents("left")
    return session


def teach_among_different() -> Session:
    """Each of the others goes on with what it did, as beside a robot of a failing world."""
    session, turn = teach_robot(), link(ROBOTS, "left")
    members = [Interpreter(program) for program in (turn, IDLE_PROGRAM, IDLE_PROGRAM, turn)]
    session.other_agents.take_over(members)
    session.teach()
    return session


def teach_coordinator(radio: CommsSpec, lesson: Lesson = LESSON) -> Session:
    scenario = replace(SCENARIO, radio=radio)
    libraries = collect_libraries(scenario, ROBOTS)
    body = make_coordinator_body(scenario, "patrol", libraries, seed=5)
    session = Session(body, libraries["patrol"], lesson)
    teach_patrol(session, 60.0)
    return session


def teach_second_coordinator() -> Session:
    """Two squads of two robots: the coordinator of the second is trained, that of the first orders to go home."""
    patrol = SCENARIO.squads["patrol"]
    pairs = {"robots": replace(patrol.members["robots"], preferred=2, most=2)}
    squads = {"patrol": replace(patrol, members=pairs, count=2)}
    scenario = replace(SCENARIO, squads=squads)
    libraries = collect_libraries(scenario, ROBOTS)
    body = make_coordinator_body(scenario, "patrol", libraries, seed=5)
    session = Session(body, libraries["patrol"], LESSON, agent=1)
    session.set_other_agents("servo", {"A": "home"})
    teach_patrol(session, 60.0)
    return session


SESSIONS: list[tuple[str, Callable[[], Session], str]] = [
    ("others idle", teach_robot, "the other robots idle"),
    ("trained alike", teach_saved, "the other robots run roam as saved"),
    ("others turn", teach_among_turning, "the other robots run left"),
    ("others differ", teach_among_different, "the other robots run left"),
    ("coordinator", lambda: teach_coordinator(CommsSpec()), ""),
    ("second coordinator", teach_second_coordinator, "the other coordinator runs servo(home)"),
    ("coordinator on a bad radio", lambda: teach_coordinator(BAD_RADIO), ""),
]


def find_setup(session: Session) -> tuple[SessionSetup, Library]:
    setup = SessionSetup.from_session(session)
    assert setup is not None
    return setup, session.library.with_automaton(session.make_trained_automaton())


@pytest.mark.parametrize(
    ("make", "others"), [each[1:] for each in SESSIONS], ids=[each[0] for each in SESSIONS]
)
def test_a_session_in_another_world_runs_as_its_run_there_bit_for_bit(
    make: Callable[[], Session], others: str
) -> None:
    session = make()
    setup, library = find_setup(session)
    assert setup.describe_others(session.automaton.name) == others
    run = setup.start(SEEDS, library, session.automaton.name, {})
    run.advance(TICKS)
    assert isinstance(run.body, World)
    for row, seed in enumerate(SEEDS):
        session.reset(seed)
        session.test()
        for _ in range(TICKS):
            session.tick()
        ground = getattr(session.body, "ground", session.body)
        assert isinstance(ground, World)
        for what in ("x", "y", "heading"):
            there = run.body.state.robots[what].reshape(len(SEEDS), -1)[row]
            assert np.array_equal(ground.state.robots[what], there), (seed, what)


def test_only_the_trained_robot_counts() -> None:
    """The others run the same behavior, are stuck sooner or later, and do not matter."""
    session = teach_saved()
    setup, library = find_setup(session)
    run = setup.start(SEEDS, library, "roam", {})
    run.advance(TICKS)
    every = run.engine.find_raised("done").reshape(len(SEEDS), -1)  # type: ignore[union-attr]
    assert run.find_raised_agents("done").tolist() == every[:, 2:3].tolist()
    assert run.find_raised("done").tolist() == every[:, 2].tolist()
    assert run.find_raised_s("done").shape == (len(SEEDS), 1)
    assert run.find_reading("stuck").read().shape == (len(SEEDS), 1)


def test_a_coordinator_is_judged_by_what_it_decided_on() -> None:
    """It is done when all are at home; being done, it orders nothing more, and nobody reports to be there."""
    flagged = new_lesson(
        collect_libraries(SCENARIO, ROBOTS)["patrol"],
        "lead",
        states=["out=wander", "attack=servo(intruder)", "home=servo(home)"],
        flags=["done"],
        features=["all_done", "someone_done", "someone_sees(intruder)"],
        live=False,
    )
    session = teach_coordinator(CommsSpec(), flagged)
    for seed in (6, 7):  # at home, it is over
        session.reset(seed)
        session.train()
        while session.view().state != "home":
            teach_patrol(session, session.body.time_s + 0.5)
        while not session.view().features["all_done"]:
            session.tick()
        session.direct("done")
        session.tick()
    for example in [each for each in session.examples if (each.state, each.next) == ("home", "out")]:
        session.delete(example.number)
    setup, library = find_setup(session)
    result = NewWorlds(setup, range(20, 50)).run(library, "lead", {})
    assert result.works.sum() > 20
    assert all(each.why.startswith("it is not done") for each in result.mistakes)


@pytest.mark.parametrize(("doing", "expected"), [(None, 600.0), ("left", 30.0)])
def test_a_baseline_sets_the_limit_where_no_robot_idles(
    monkeypatch: pytest.MonkeyPatch, doing: str | None, expected: float
) -> None:
    """The baseline drives all robots: three times its 10 s are no limit for one robot beside idle ones."""

    class Expert:
        spent_s = np.array([10.0])

    session = teach_robot()
    session.set_other_agents(doing)
    monkeypatch.setattr(new_worlds, "find_baseline", lambda _: object())
    monkeypatch.setattr(new_worlds, "measure_baseline", lambda *_: Expert)
    worlds = NewWorlds(find_setup(session)[0], [1])
    assert np.max(worlds.limits_s) == expected


def test_there_are_no_other_worlds_of_a_body_without_a_scenario() -> None:
    class Body:
        """The same robots, which nobody simulates."""

        def __init__(self, world: World) -> None:
            self._world = world

        def __getattr__(self, name: str) -> object:
            return getattr(self._world, name)

    lesson = new_lesson(ROBOTS, "roam", states=["forwards"], features=["stuck"], live=True)
    session = Session(Body(World(SCENARIO, [1])), ROBOTS, lesson)  # type: ignore[arg-type]
    assert SessionSetup.from_session(session) is None
