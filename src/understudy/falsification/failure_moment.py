"""Moments of runs that failed, at which a session can begin: the body, the automaton to correct, and its state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from understudy.errors import SessionError, UnknownName
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.runtime.interpreter import Interpreter, StackFrame
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.sim.world import World
from understudy.training.other_agents import RunStates, SessionSnapshot
from understudy.training.session import Session
from understudy.training.trainee import Mode


@dataclass(frozen=True, slots=True)
class FailureMoment:
    """A moment some seconds before a behavior went wrong in a failing world.

    `world` is the world then, with markers to place by hand. `body` is what the session trains on, the world or the
    coordinators of a sort of squads, and `agent` the robot or coordinator. `name` is the automaton to correct, `lesson`
    its lesson, `library` the library that it is in, `targets` are those of its parameters, and `states` is its run
    state and that of the automata below it, empty before the first decision. `behavior` with `binding` is what the
    other agents of the body run. In a team `members` are the robots' interpreters, which go on with their last orders
    where a robot is corrected. `others` are the run states of all agents of the body; None: they restart.
    """

    world: World
    body: World | CoordinatorBody
    agent: int
    name: str
    lesson: Lesson
    library: Library
    targets: Mapping[str, str]
    states: tuple[StackFrame, ...]
    behavior: str
    binding: Mapping[str, str]
    members: Sequence[Interpreter] = ()
    others: RunStates | None = None

    @property
    def sort(self) -> str | None:
        """The sort of squads whose coordinator is corrected; None if it is a robot."""
        return self.body.squads.squad.name if isinstance(self.body, CoordinatorBody) else None

    def restore_in(self, session: Session) -> None:
        """Continue the run of this moment in a session of the automaton, on the body of this moment."""
        if self.members:
            session.other_agents.take_over(self.members)
        elif self.body.agents > 1:
            session.other_agents.set_behavior(self.behavior, self.binding)
        session.teach()
        if not self.states:
            session.other_agents.start()
            return
        others = session.other_agents.snapshot() if self.others is None else self.others
        session.rewind(SessionSnapshot(self.body.snapshot(), self.states, Mode.LIVE, others))


class RunInstant(NamedTuple):
    """An instant of a run: the body, the automata that an agent runs, the root first, with their targets and states.

    `members` and `others` are those of `FailureMoment`.
    """

    body: bytes
    active: Sequence[tuple[str, Mapping[str, str]]]
    states: tuple[StackFrame, ...]
    members: Sequence[Interpreter] = ()
    others: RunStates | None = None


def choose_instant(
    instants: Sequence[RunInstant], library: Library, name: str | None
) -> tuple[RunInstant, int]:
    """Return the instant at which to begin, and the level of the automaton to correct.

    Without a name that automaton is the innermost one with a lesson in the end, and it begins as soon as it runs
    without a break until then; else as soon as the automaton of that name runs.
    """
    end = instants[-1].active
    if not any(instant.active for instant in instants):
        raise SessionError("it runs no automaton at this moment: there is nothing to correct")
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


def find_lesson(library: Library, name: str) -> Lesson:
    """Return the lesson of an automaton; SessionError if it has none."""
    lesson = library.taught[name].lesson
    if lesson is None:
        raise SessionError(f"{name!r} has no lesson: nothing was recorded when it was made")
    return lesson


def list_active(interpreter: Interpreter) -> list[tuple[str, Mapping[str, str]]]:
    """List the automata that an interpreter runs, the root first, with their targets."""
    return [(each.automaton.name, each.instance.binding) for each in interpreter.active]
