"""Tracing of agents through a run: each query of their transition functions and its answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from understudy.model.features import Percept
from understudy.model.tree import STAY
from understudy.model.value_kinds import Column
from understudy.runtime.body import Body
from understudy.runtime.interpreter import Interpreter, RunningAutomaton
from understudy.runtime.link import Program
from understudy.runtime.run_loop import Run
from understudy.runtime.team.members import AgentLayer, Runner
from understudy.runtime.team.squad_body import SquadBody
from understudy.runtime.team.team import Team


@dataclass(frozen=True, slots=True)
class TransitionQuery:
    """A query of a state's transition function at `time_s`, with feature vector `values`.

    `before` and `after` are the indices of the states before and after it.
    """

    time_s: float
    before: int
    after: int
    values: tuple[float, ...]

    @property
    def is_switch(self) -> bool:
        """True if the query led to another state."""
        return self.after != self.before


@dataclass(frozen=True, slots=True)
class ActiveAutomaton:
    """An automaton that is running at a moment.

    `entered_s` is when its state was entered. `query` is that of the last tick; None if the state has no
    transition function. `entry` is the query that entered the state; None if the automaton started there.
    """

    machine: RunningAutomaton
    entered_s: float
    query: TransitionQuery | None
    entry: TransitionQuery | None


class TracedRun(Run):
    """A run of interpreters that records the queries of selected agents."""

    def __init__(
        self, body: Body, interpreters: Sequence[Interpreter], others: Sequence[Program] = ()
    ) -> None:
        super().__init__(body, interpreters, others)
        self._seen: dict[int, Interpreter] = {}
        self._queries: dict[int, dict[RunningAutomaton, TransitionQuery]] = {}
        self._entries: dict[RunningAutomaton, TransitionQuery] = {}
        self._body = body
        self.last_switches: dict[int, tuple[RunningAutomaton, TransitionQuery]] = {}
        """The last switch before this tick of each followed agent that has switched.

        If several levels switched in one tick, it is that of the highest one, which caused the others.
        """

    def follow(self, agent: int) -> None:
        """Record the queries of an agent from now on."""
        self._queries.setdefault(agent, {})

    def decide(self, percept: Percept) -> dict[str, Column]:
        """Compute the commands of all agents for one tick, and record the queries of those that are followed."""
        for agent, queries in self._queries.items():
            switch = next((each for each in queries.items() if each[1].is_switch), None)
            if switch is not None:
                self.last_switches[agent] = switch
            queries.clear()
            interpreter = self.interpreters[agent]
            if self._seen.get(agent) is not interpreter:  # it was ordered to run something else
                self._seen[agent] = interpreter
                interpreter.observe_queries(partial(self._witness, queries))
        return super().decide(percept)

    def _witness(
        self,
        queries: dict[RunningAutomaton, TransitionQuery],
        machine: RunningAutomaton,
        state: int,
        answer: int,
        values: Sequence[float],
    ) -> None:
        query = TransitionQuery(self._body.time_s, state, state if answer == STAY else answer, tuple(values))
        queries[machine] = query
        if query.is_switch:
            self._entries[machine] = query

    def list_active(self, agent: int) -> tuple[ActiveAutomaton, ...]:
        """List the running automata of a followed agent, the root first."""
        queries = self._queries[agent]
        return tuple(
            self._stood(machine, queries.get(machine)) for machine in self.interpreters[agent].active
        )

    def _stood(self, machine: RunningAutomaton, query: TransitionQuery | None) -> ActiveAutomaton:
        entry = self._entries.get(machine)
        if entry is not None and (entry.time_s != machine.entered or entry.after != machine.state):
            entry = None  # it was started again since
        return ActiveAutomaton(machine, machine.entered, query, entry)


def make_tracing_runner(body: Body, programs: Sequence[Program], others: Sequence[Program]) -> Runner:
    """Make a run for agents of a team that records their queries."""
    return TracedRun(body, [Interpreter(program, now=body.time_s) for program in programs], others)


@dataclass(frozen=True, slots=True)
class AgentRef:
    """An agent of a team: its sort, its number within the sort, its layer, and its place in a squad.

    `squad` is None for an agent that has no coordinator above it.
    """

    sort: str
    agent: int
    layer: AgentLayer
    squad: tuple[SquadBody, int] | None

    @property
    def last_order(self) -> str | None:
        """The last order that the agent received; "" if none yet, None if no coordinator is above it."""
        if self.squad is None:
            return None
        squads, member = self.squad
        duty = squads.ordering.duty[member]
        return "" if duty is None else str(duty)


def list_chain_of_command(team: Team, robot: int) -> tuple[AgentRef, ...]:
    """List a robot of a team and all coordinators above it, the topmost first."""
    layer, row = team.layers[0], robot
    sort = team.tree.types[team.tree.type_of[robot]]
    chain: list[AgentRef] = []
    while True:
        above = _above(team, layer, row)
        chain.append(AgentRef(sort, row, layer, None if above is None else (above[0], above[2])))
        if above is None:
            return tuple(reversed(chain))
        squads, layer, member = above
        sort, row = squads.squad.name, int(squads.roster.squad[member])


def _above(team: Team, layer: AgentLayer, row: int) -> tuple[SquadBody, AgentLayer, int] | None:
    """Return the squads that an agent is a member of, their layer, and its member number; None if there are none."""
    for upper in team.layers:
        if isinstance(upper.body, SquadBody):
            roster = upper.body.roster
            for member, (band, place) in enumerate(
                zip(roster.band.tolist(), roster.row.tolist(), strict=True)
            ):
                if place == row and upper.body.bands[band].layer is layer:
                    return upper.body, upper, member
    return None
