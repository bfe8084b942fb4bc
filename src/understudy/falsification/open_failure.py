"""Sessions that begin shortly before a behavior went wrong in a failing world, so that a press can correct it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from understudy.errors import SessionError, UnknownName
from understudy.falsification.failing_world import FailingWorld, read_failing_world
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.runtime.interpreter import Interpreter, StackFrame
from understudy.runtime.program import link
from understudy.runtime.run_loop import Run
from understudy.sim.world import World
from understudy.training.other_agents import SessionSnapshot
from understudy.training.session import Session
from understudy.training.trainee import Mode

BEFORE_S = 3.0
"""The time before the failure at which a session begins by default, s."""


@dataclass(frozen=True, slots=True)
class FailureMoment:
    """A moment some seconds before a behavior went wrong in a failing world.

    `world` is the world then, and `agent` the robot. `name` is the automaton to correct, `lesson` its lesson, `targets`
    are those of its parameters, and `states` is its run state and that of the automata below it. `behavior` with
    `binding` is what all robots run.
    """

    world: World
    agent: int
    name: str
    lesson: Lesson
    targets: Mapping[str, str]
    states: tuple[StackFrame, ...]
    behavior: str
    binding: Mapping[str, str]

    def restore_in(self, session: Session) -> None:
        """Continue the run of this moment in a session of the automaton, on the world of this moment."""
        if self.world.agents > 1:
            session.other_agents.set_behavior(self.behavior, self.binding)
        session.teach()
        others = session.other_agents.snapshot()
        session.rewind(SessionSnapshot(self.world.snapshot(), self.states, Mode.LIVE, others))


def open_failure(
    failing: FailingWorld | Path | str,
    library: Library,
    *,
    name: str | None = None,
    before_s: float = BEFORE_S,
) -> Session:
    """Open a live session some seconds before a behavior went wrong in a failing world.

    The robot runs as it ran in the search until then, and the session goes on from there with one of the automata that
    were running. A press corrects it; `save_automaton` keeps it. Other robots begin the behavior anew.

    Parameters
    ----------
    failing
        The failing world, or its folder.
    library
        The library with the behavior, and with the lesson to correct.
    name
        Name of the automaton to correct. None: the innermost one that ran then.
    before_s
        How long before the failure it begins, s; at the start of the run if that was later.

    Returns
    -------
    Session
        The session. Nothing has been recorded.

    Raises
    ------
    FileError
        If the folder does not have a failing world.
    UnknownName
        If the library does not have the behavior, or no automaton of that name ran then.
    SessionError
        If the automaton has no lesson, or the world is that of a team with coordinators.
    """
    found = failing if isinstance(failing, FailingWorld) else read_failing_world(failing)
    moment = find_failure_moment(found, library, name=name, before_s=before_s)
    session = Session(moment.world, library, moment.lesson, targets=moment.targets, agent=moment.agent)
    moment.restore_in(session)
    return session


def find_failure_moment(
    failing: FailingWorld,
    library: Library,
    *,
    name: str | None = None,
    before_s: float = BEFORE_S,
    wrong_s: float | None = None,
) -> FailureMoment:
    """Run a failing world until some seconds before the behavior goes wrong.

    Parameters
    ----------
    failing
        The failing world.
    library
        The library with the behavior, and with the lesson to correct.
    name
        Name of the automaton to correct. None: the innermost one that ran then.
    before_s
        How long before the failure, s; at the start of the run if that was later.
    wrong_s
        When it goes wrong, s. None: as it was kept.

    Returns
    -------
    FailureMoment
        The moment.

    Raises
    ------
    UnknownName
        If the library does not have the behavior, or no automaton of that name ran then.
    SessionError
        If the automaton has no lesson, or the world is that of a team with coordinators.
    """
    scenario, facts = failing.trial.scenario, failing.facts
    if scenario.squads:
        raise SessionError(
            "a team with coordinators cannot be corrected from a failing world: correct its automata in the studio, "
            "and run the failing world again"
        )
    world = World(scenario, [failing.trial.seed])
    program = link(library, facts.behavior, facts.binding)
    drivers = [Interpreter(program, now=world.time_s) for _ in range(world.agents)]
    run, driver = Run(world, drivers), drivers[facts.robot]
    until_s = (facts.wrong_s if wrong_s is None else wrong_s) - before_s
    for _ in range(max(1, round(until_s / world.tick_s))):
        run.tick()
    level = _choose_level(driver, name)
    machine = driver.active[level]
    lesson = library.taught[machine.automaton.name].lesson
    if lesson is None:
        raise SessionError(f"{machine.automaton.name!r} has no lesson: nothing was recorded when it was made")
    return FailureMoment(
        world,
        facts.robot,
        machine.automaton.name,
        lesson,
        machine.instance.binding,
        driver.snapshot(world.time_s)[level:],
        facts.behavior,
        facts.binding,
    )


def _choose_level(driver: Interpreter, name: str | None) -> int:
    """Return the position of an automaton among those that run, the root first."""
    names = [machine.automaton.name for machine in driver.active]
    if name is None:
        return len(names) - 1
    if name not in names:
        raise UnknownName(what="automaton", name=name, where="the run at this moment", known=names)
    return names.index(name)
