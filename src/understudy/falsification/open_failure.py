"""Sessions that begin shortly before a behavior went wrong in a failing world, so that a press can correct it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from understudy.errors import SessionError, UnknownName
from understudy.falsification.failing_world import FailingWorld, read_failing_world
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.runtime.interpreter import Interpreter, StackFrame
from understudy.runtime.program import link
from understudy.runtime.run_loop import Run
from understudy.sim.scenario.files import add_markers
from understudy.sim.world import World
from understudy.training.other_agents import SessionSnapshot
from understudy.training.session import Session
from understudy.training.trainee import Mode

BEFORE_S = 3.0
"""The time before the failure at which a session begins by default, s."""

AFTER_S = 1.0
"""The time after the end of progress at which the innermost automaton is taken for the one that made the mistake, s."""


@dataclass(frozen=True, slots=True)
class FailureMoment:
    """A moment some seconds before a behavior went wrong in a failing world.

    `world` is the world then, with markers to place by hand, and `agent` the robot. `name` is the automaton to correct,
    `lesson` its lesson, `targets` are those of its parameters, and `states` is its run state and that of the automata
    below it, empty before the first decision. `behavior` with `binding` is what all robots run.
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
        if not self.states:
            return
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
    were running. A press corrects it; `save_automaton` keeps it. Other robots restart the behavior.

    Parameters
    ----------
    failing
        The failing world, or its folder.
    library
        The library with the behavior, and with the lesson to correct.
    name
        Name of the automaton to correct. None: the innermost one with a lesson that ran when it went wrong.
    before_s
        How long before the failure it begins, s; later if the run, or that automaton, began later.

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
        Name of the automaton to correct. None: the innermost one with a lesson that ran when it went wrong.
    before_s
        How long before the failure, s; later if the run, or that automaton, began later.
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
    scenario, facts = add_markers(failing.trial.scenario), failing.facts
    if scenario.squads:
        raise SessionError(
            "a team with coordinators cannot be corrected from a failing world: correct its automata in the studio, "
            "and run the failing world again"
        )
    world = World(scenario, [failing.trial.seed])
    program = link(library, facts.behavior, facts.binding)
    drivers = [Interpreter(program, now=world.time_s) for _ in range(world.agents)]
    run, driver, start = Run(world, drivers), drivers[facts.robot], world.snapshot()
    at_s = facts.wrong_s if wrong_s is None else wrong_s
    ticks = round((at_s - before_s) / world.tick_s)
    first = max(1, ticks)
    after_s = AFTER_S if facts.property is None else 0.0
    for _ in range(first - 1):
        run.tick()
    instants = list[_Instant]()
    for _ in range(first, max(first, round((at_s + after_s) / world.tick_s)) + 1):
        run.tick()
        active = [(each.automaton.name, each.instance.binding) for each in driver.active]
        instants.append(_Instant(world.snapshot(), active, driver.snapshot(world.time_s)))
    instant, level = _choose_instant(instants, library, name)
    automaton, targets = instant.active[level]
    lesson = library.taught[automaton].lesson
    if lesson is None:
        raise SessionError(f"{automaton!r} has no lesson: nothing was recorded when it was made")
    # The first tick shows which automata run, but its decision may be the wrong one.
    is_start = ticks < 1 and instant is instants[0]
    world.restore(start if is_start else instant.world)
    states = () if is_start else instant.states[level:]
    return FailureMoment(
        world, facts.robot, automaton, lesson, targets, states, facts.behavior, facts.binding
    )


class _Instant(NamedTuple):
    """An instant of the run: the world, and the automata that run, the root first, with their targets."""

    world: bytes
    active: Sequence[tuple[str, Mapping[str, str]]]
    states: tuple[StackFrame, ...]


def _choose_instant(instants: Sequence[_Instant], library: Library, name: str | None) -> tuple[_Instant, int]:
    """Return the instant at which to begin, and the level of the automaton to correct.

    Without a name that automaton is the innermost one with a lesson in the end, and it begins as soon as it runs
    without a break until then; else as soon as the automaton of that name runs.
    """
    end = instants[-1].active
    if name is not None:
        for instant in instants:
            names = [each for each, _ in instant.active]
            if name in names:
                return instant, names.index(name)
        known = [each for each, _ in end]
        raise UnknownName(what="automaton", name=name, where="the run at this moment", known=known)
    taught = [level for level, (each, _) in enumerate(end) if library.taught[each].lesson is not None]
    level = taught[-1] if taught else len(end) - 1
    began = len(instants) - 1
    while began and instants[began - 1].active[: level + 1] == end[: level + 1]:
        began -= 1
    return instants[began], level
