"""Properties from stored moments: the world is restored to a moment of a session, and the automaton runs from there."""

from __future__ import annotations

from functools import cache
from types import MappingProxyType

from understudy.errors import SessionError, UnderstudyError
from understudy.judging.behavior_run import ProgramRun
from understudy.judging.properties.monitor import monitor_property
from understudy.judging.properties.run_property import PropertyResult
from understudy.model.binding import Binding
from understudy.model.library import Library
from understudy.model.property import RAISED, Property, PropertyKind, StoredMoment
from understudy.runtime.body import is_rewindable
from understudy.runtime.link import IDLE_PROGRAM, link
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.sim.scenario.files import format_scenario, parse_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, make_coordinator_body
from understudy.sim.world import World
from understudy.training.session import Session


def make_moment_property(session: Session, *, flag: str, within_s: float) -> Property:
    """Make the property that a session's automaton, started from this moment, raises a flag within a time (s).

    SessionError is raised if no state raises the flag, or the body is not a single simulated world.
    """
    automaton, body = session.automaton, session.body
    if flag not in {state.flag for state in automaton.states}:
        flags = [state.flag for state in automaton.states if state.flag is not None]
        raise SessionError(
            f"{automaton.name!r} never raises {flag!r}; its flags are {', '.join(flags) or 'none'}"
        )
    ground = body.ground if isinstance(body, CoordinatorBody) else body
    if not isinstance(ground, World) or not is_rewindable(body) or ground.worlds != 1:
        raise SessionError("a property needs a single simulated world, which can be restored to this moment")
    scenario = ground.scenario
    start = StoredMoment(
        scenario.name,
        format_scenario(scenario),
        body.snapshot(),
        session.agent,
        body.squads.squad.name if isinstance(body, CoordinatorBody) else "",
    )
    targets = Binding(dict(session.view().targets))
    what = f"{flag}{RAISED}"
    return Property(kind=PropertyKind.ALWAYS, what=what, seconds=within_s, start=start, targets=targets)


def add_moment_property(session: Session, *, flag: str, within_s: float) -> Property:
    """Add a property that starts at the present moment to a session's lesson; see `make_moment_property`.

    It is a step of the session that can be undone.
    """
    added = make_moment_property(session, flag=flag, within_s=within_s)
    session.change_design(properties=(*session.lesson.properties, added))
    return added


def run_moment_property(
    subject: Property, name: str, library: Library, libraries: Libraries = MappingProxyType({})
) -> PropertyResult:
    """Test a property of the automaton `name`: restore the world and run the automaton while other agents idle.

    If the automaton is a coordinator's, `libraries` has the libraries of its members, by sort of agent.
    """
    if not isinstance(subject.start, StoredMoment):
        raise TypeError("a property of seeded worlds has no stored moment")
    try:
        run = start_at_moment(subject, subject.start, name, library, libraries)
        outcomes = monitor_property(subject, run, library.automaton(name).flags)
    except UnderstudyError as error:
        return PropertyResult.from_problem(subject, str(error))
    except KeyError as error:
        return PropertyResult.from_problem(subject, f"its world has agents of the unknown sort {error}")
    return PropertyResult(subject, (), outcomes)


def start_at_moment(
    subject: Property, start: StoredMoment, name: str, library: Library, libraries: Libraries
) -> ProgramRun:
    """Start a behavior of one agent at a stored moment, while all other agents idle.

    Parameters
    ----------
    subject
        The property, which binds the behavior's parameters.
    start
        The moment.
    name
        Name of the behavior.
    library
        The library that has it.
    libraries
        For a coordinator, the library of each sort of agents.

    Returns
    -------
    ProgramRun
        The run before the first tick, whose flags and readings are those of the agent only.
    """
    body = _make_body(start, {**libraries, start.sort: library})
    body.restore(start.snapshot)
    if not 0 <= start.agent < body.agents:
        raise SessionError(f"there is no agent {start.agent} in its world: they are counted from 0")
    program, others = link(library, name, subject.targets), [IDLE_PROGRAM] * body.agents
    return ProgramRun(body, program, library, subject.targets, agent=start.agent, others=others)


def _make_body(start: StoredMoment, libraries: Libraries) -> World | CoordinatorBody:
    scenario = _parse_scenario(start.scenario)
    return make_coordinator_body(scenario, start.sort, libraries) if start.sort else World(scenario)


@cache
def _parse_scenario(text: str) -> Scenario:
    return parse_scenario(text)
