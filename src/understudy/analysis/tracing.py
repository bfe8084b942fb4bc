"""Following agents through a run: every question that their automata were asked, and what they answered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from understudy.model.features import Percept
from understudy.model.kinds import Column
from understudy.model.tree import STAY
from understudy.runtime.body import Body
from understudy.runtime.interpreter import Interpreter, RunningAutomaton
from understudy.runtime.program import Program
from understudy.runtime.run_loop import Run
from understudy.runtime.team.members import AgentLayer, Runner
from understudy.runtime.team.squad_body import SquadBody
from understudy.runtime.team.team import Team


@dataclass(frozen=True, slots=True)
class TransitionQuery:
    """What a state's transition function was asked at a time, and the state after it (the same: it stayed)."""

    time_s: float
    before: int
    after: int
    values: tuple[float, ...]

    @property
    def is_switch(self) -> bool:
        """Whether the state was left."""
        return self.after != self.before


@dataclass(frozen=True, slots=True)
class ActiveAutomaton:
    """One running automaton at a moment: when its state was entered, what it was asked in the last tick (None: its
    state has no transition function), and the query that had entered its state (None: it was started there).
    """

    machine: RunningAutomaton
    entered_s: float
    asked: TransitionQuery | None
    entry: TransitionQuery | None


class TracedRun(Run):
    """Interpreters, some of which are followed."""

    def __init__(
        self, body: Body, interpreters: Sequence[Interpreter], others: Sequence[Program] = ()
    ) -> None:
        super().__init__(body, interpreters, others)
        self._seen: dict[int, Interpreter] = {}
        self._asked: dict[RunningAutomaton, TransitionQuery] = {}
        self._entries: dict[RunningAutomaton, TransitionQuery] = {}
        self._agents: set[int] = set()
        self._body = body
        self.last: tuple[RunningAutomaton, TransitionQuery] | None = None
        """The last switch before this tick of those that are followed; of several in a tick that of the highest level,
        which the others follow from."""

    def follow(self, agent: int) -> None:
        """Follow an agent from now on."""
        self._agents.add(agent)

    def decide(self, percept: Percept) -> dict[str, Column]:
        """Pulse every agent; what those that are followed were asked is kept until the next tick."""
        switched = (each for each in self._asked.items() if each[1].is_switch)
        self.last = next(switched, self.last)
        self._asked.clear()
        for agent in self._agents:
            interpreter = self.interpreters[agent]
            if self._seen.get(agent) is not interpreter:  # it was ordered to run something else
                self._seen[agent] = interpreter
                interpreter.observe_queries(self._witness)
        return super().decide(percept)

    def _witness(self, machine: RunningAutomaton, state: int, answer: int, values: Sequence[float]) -> None:
        query = TransitionQuery(self._body.time_s, state, state if answer == STAY else answer, tuple(values))
        self._asked[machine] = query
        if query.is_switch:
            self._entries[machine] = query

    def list_active(self, agent: int) -> tuple[ActiveAutomaton, ...]:
        """The running automata of an agent that is followed, from the root down."""
        return tuple(self._stood(machine) for machine in self.interpreters[agent].active)

    def _stood(self, machine: RunningAutomaton) -> ActiveAutomaton:
        entry = self._entries.get(machine)
        if entry is not None and (entry.time_s != machine.entered or entry.after != machine.state):
            entry = None  # it was started again since
        return ActiveAutomaton(machine, machine.entered, self._asked.get(machine), entry)


def make_tracing_runner(body: Body, programs: Sequence[Program], others: Sequence[Program]) -> Runner:
    """What runs the agents of a team so that they can be followed."""
    return TracedRun(body, [Interpreter(program, now=body.time_s) for program in programs], others)


@dataclass(frozen=True, slots=True)
class AgentRef:
    """An agent of a team: its sort, its number among them, who runs it, and what it was ordered to do by the one above
    it (None: it is under nobody).
    """

    sort: str
    agent: int
    layer: AgentLayer
    squad: tuple[SquadBody, int] | None

    @property
    def last_order(self) -> str | None:
        """What it was last ordered to do, as it has heard; "" is nothing yet."""
        if self.squad is None:
            return None
        squads, member = self.squad
        duty = squads.ordering.duty[member]
        return "" if duty is None else str(duty)


def list_chain_of_command(team: Team, robot: int) -> tuple[AgentRef, ...]:
    """A robot of a team and all above it, the topmost first."""
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
    """The squads that an agent is a member of, their layer, and which member it is."""
    for upper in team.layers:
        if isinstance(upper.body, SquadBody):
            roster = upper.body.roster
            for member, (band, place) in enumerate(
                zip(roster.band.tolist(), roster.row.tolist(), strict=True)
            ):
                if place == row and upper.body.bands[band].layer is layer:
                    return upper.body, upper, member
    return None
