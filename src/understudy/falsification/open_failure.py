"""Sessions that begin shortly before a behavior went wrong in a failing world, so that a press can correct it."""

from __future__ import annotations

from pathlib import Path

from understudy.errors import SessionError, UnknownName
from understudy.falsification.failing_world import FailingWorld, read_failing_world
from understudy.model.library import Library
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.program import link
from understudy.runtime.run_loop import Run
from understudy.sim.world import World
from understudy.training.other_agents import SessionSnapshot
from understudy.training.session import Session
from understudy.training.trainee import Mode

BEFORE_S = 3.0
"""The time before the failure at which a session begins by default, s."""


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
    scenario, facts = found.trial.scenario, found.facts
    if scenario.squads:
        raise SessionError(
            "a team with coordinators cannot be corrected from a failing world; open it in the studio"
        )
    world = World(scenario, [found.trial.seed])
    program = link(library, facts.behavior, facts.binding)
    drivers = [Interpreter(program, now=world.time_s) for _ in range(world.agents)]
    run, driver, start = Run(world, drivers), drivers[facts.robot], world.snapshot()
    ticks = round((facts.wrong_s - before_s) / world.tick_s)
    for _ in range(max(1, ticks)):
        run.tick()
    level = _choose_level(driver, name)
    machine = driver.active[level]
    lesson = library.taught[machine.automaton.name].lesson
    if lesson is None:
        raise SessionError(f"{machine.automaton.name!r} has no lesson: nothing was recorded when it was made")
    if ticks < 1:  # the first tick showed which automata run, but its decision may be the wrong one
        world.restore(start)
    session = Session(world, library, lesson, targets=machine.instance.binding, agent=facts.robot)
    if world.agents > 1:
        session.other_agents.set_behavior(facts.behavior, facts.binding)
    session.teach()
    if ticks < 1:
        return session
    states = driver.snapshot(world.time_s)[level:]
    session.rewind(SessionSnapshot(world.snapshot(), states, Mode.LIVE, session.other_agents.snapshot()))
    return session


def _choose_level(driver: Interpreter, name: str | None) -> int:
    """Return the position of an automaton among those that run, the root first."""
    names = [machine.automaton.name for machine in driver.active]
    if name is None:
        return len(names) - 1
    if name not in names:
        raise UnknownName(what="automaton", name=name, where="the run at this moment", known=names)
    return names.index(name)
