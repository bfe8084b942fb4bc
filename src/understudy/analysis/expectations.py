"""Outcomes tried: a world put back to where a lesson promised something, and the automaton let go in it."""

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
    """How an outcome came out: after how many seconds, or None where it did not; `problem` is why it could not be
    tried at all.
    """

    outcome: Expectation
    took_s: float | None
    problem: str = ""

    @property
    def was_met(self) -> bool:
        """Whether it came as promised."""
        return self.took_s is not None


def make_expectation(session: Session, *, flag: str, within_s: float) -> Expectation:
    """The outcome that from this moment of a session on its automaton, started afresh, raises a flag in time.

    SessionError where the body is no simulation, or many worlds; UnknownName where no state raises the flag.
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
    """Add to a session's lesson, as a step that can be undone, what is to come of it from here on: see
    `make_expectation`.
    """
    outcome = make_expectation(session, flag=flag, within_s=within_s)
    session.change_design(outcomes=(*session.lesson.outcomes, outcome))
    return outcome


def run_expectation(
    outcome: Expectation, name: str, library: Library, libraries: Libraries = MappingProxyType({})
) -> ExpectationResult:
    """The automaton `name` of a library let go where the outcome was promised; the other agents idle.

    Of a coordinator, `libraries` has what its members know, by sort of agents.
    """
    try:
        return ExpectationResult(outcome, _let_go(outcome, name, library, libraries))
    except UnderstudyError as error:
        return ExpectationResult(outcome, None, str(error))
    except KeyError as error:
        return ExpectationResult(outcome, None, f"its world has agents of the unknown sort {error}")


def _let_go(outcome: Expectation, name: str, library: Library, libraries: Libraries) -> float | None:
    """After how many seconds the outcome came; None where it did not."""
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
