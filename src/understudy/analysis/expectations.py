"""Tests of expectations: the world is restored to the moment of an expectation, and the automaton runs from there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

from understudy.errors import SessionError, UnderstudyError
from understudy.model.binding import Binding
from understudy.model.expectation import Expectation
from understudy.model.library import Library
from understudy.runtime.body import is_rewindable
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.program import IDLE_PROGRAM, link
from understudy.runtime.run_loop import Run
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.sim.scenario.files import format_scenario, parse_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, make_coordinator_body
from understudy.sim.world import World
from understudy.training.session import Session


@dataclass(frozen=True, slots=True)
class ExpectationResult:
    """The result of testing an expectation.

    `took_s` is the time until it was met, in s; None if it was not. `problem` is the reason why it could not be
    tested; empty if it could.
    """

    outcome: Expectation
    took_s: float | None
    problem: str = ""

    @property
    def was_met(self) -> bool:
        """True if the flag was raised in time."""
        return self.took_s is not None


def make_expectation(session: Session, *, flag: str, within_s: float) -> Expectation:
    """Make the expectation that a session's automaton, started from this moment, raises a flag within a time (s).

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
        raise SessionError("an outcome needs a single simulated world, which can be restored to this moment")
    scenario = ground.scenario
    return Expectation(
        flag,
        within_s,
        scenario.name,
        format_scenario(scenario),
        body.snapshot(),
        session.agent,
        body.squads.squad.name if isinstance(body, CoordinatorBody) else "",
        Binding(dict(session.view().targets)),
    )


def add_expectation(session: Session, *, flag: str, within_s: float) -> Expectation:
    """Add an expectation about the present moment to a session's lesson; see `make_expectation`.

    It is a step of the session that can be undone.
    """
    outcome = make_expectation(session, flag=flag, within_s=within_s)
    session.change_design(outcomes=(*session.lesson.outcomes, outcome))
    return outcome


def run_expectation(
    outcome: Expectation, name: str, library: Library, libraries: Libraries = MappingProxyType({})
) -> ExpectationResult:
    """Test an expectation of the automaton `name`: restore the world and run the automaton while other agents idle.

    If the automaton is a coordinator's, `libraries` has the libraries of its members, by sort of agent.
    """
    try:
        return ExpectationResult(outcome, _let_go(outcome, name, library, libraries))
    except UnderstudyError as error:
        return ExpectationResult(outcome, None, str(error))
    except KeyError as error:
        return ExpectationResult(outcome, None, f"its world has agents of the unknown sort {error}")


def _let_go(outcome: Expectation, name: str, library: Library, libraries: Libraries) -> float | None:
    """Return the time in s until the expectation was met, or None if it was not."""
    body = _body(outcome, {**libraries, outcome.sort: library})
    body.restore(outcome.snapshot)
    if not 0 <= outcome.agent < body.agents:
        raise SessionError(f"there is no agent {outcome.agent} in its world: they are counted from 0")
    doer = Interpreter(link(library, name, outcome.targets), now=body.time_s)
    agents = [Interpreter(IDLE_PROGRAM, now=body.time_s) for _ in range(body.agents)]
    agents[outcome.agent] = doer
    run, began = Run(body, agents), body.time_s
    while doer.root.flag is None and body.time_s - began < outcome.within_s - body.tick_s / 2:
        run.tick()
    return round(body.time_s - began, 6) if doer.root.flag == outcome.flag else None


def _body(outcome: Expectation, libraries: Libraries) -> World | CoordinatorBody:
    scenario = _scenario(outcome.scenario)
    return make_coordinator_body(scenario, outcome.sort, libraries) if outcome.sort else World(scenario)


@cache
def _scenario(text: str) -> Scenario:
    return parse_scenario(text)
