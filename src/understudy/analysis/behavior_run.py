"""A behavior that runs in several worlds side by side: alone on all agents of a body, or in a team.

Goals and metrics of one's own are read from it between ticks.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from understudy.analysis.named_reading import NamedReading, find_reading
from understudy.errors import UnknownName
from understudy.model.features import Percept
from understudy.model.kinds import Column
from understudy.model.library import Library
from understudy.runtime.body import Body, list_reading_keys
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import Program
from understudy.runtime.team.members import AgentLayer
from understudy.runtime.team.team import Team
from understudy.sim.team.libraries import Libraries
from understudy.sim.world import World


@dataclass(frozen=True, slots=True)
class RunReading:
    """A reading of the agents of a run, in all its worlds."""

    reading: NamedReading
    sense: Callable[[], Percept]
    """Takes the present snapshot of the body that has it."""
    worlds: int
    chosen: NDArray[np.bool_] | None = None
    """Which agents of a world have it. None: all of the body."""

    def read(self) -> Column:
        """Return the present values [B, n], of n agents in each world; NaN where absent."""
        column = self.reading.read(self.sense()).reshape(self.worlds, -1)
        if self.chosen is None:
            return column
        found: Column = column[:, self.chosen]
        return found


class BehaviorRun(Protocol):
    """A behavior that runs in B worlds, each with as many agents."""

    @property
    def body(self) -> Body:
        """The body of the robots."""
        ...

    @property
    def team(self) -> Team | None:
        """The team, if not all robots run the behavior by themselves."""
        ...

    @property
    def is_fused(self) -> bool:
        """Whether many ticks can be run at once."""
        ...

    @property
    def own_robots(self) -> NDArray[np.bool_] | None:
        """Which simulated robots of a world [N] run the behavior, or follow who does. None: all count."""
        ...

    def tick(self) -> None:
        """Let all agents sense, decide and act once."""
        ...

    def advance(self, ticks: int) -> None:
        """Run ticks; worlds may stop where they reach the scenario's goal."""
        ...

    def advance_all(self, ticks: int) -> None:
        """Run ticks in all worlds, also in those that have reached the scenario's goal."""
        ...

    def find_raised(self, flag: str) -> NDArray[np.bool_]:
        """Return in which worlds [B] all agents that run the behavior have raised a flag."""
        ...

    def find_raised_agents(self, flag: str) -> NDArray[np.bool_]:
        """Return which of the n agents of each world that run the behavior have raised a flag [B, n]."""
        ...

    def find_reading(self, text: str) -> RunReading:
        """Find a reading by its name, such as "range(station)"; UnknownName or SettingError if there is none."""
        ...


class ProgramRun:
    """A behavior that all agents of a body run; or one of each world, beside other programs.

    Parameters
    ----------
    body
        The body.
    program
        The behavior, ready to run.
    library
        The library of the behavior.
    binding
        The target of each parameter.
    worlds
        The number of worlds.
    agent
        The only agent of each world that runs the behavior. None: all do.
    others
        What the agents of each world run, one program each; that at `agent` is not used.
    """

    team: Team | None = None

    def __init__(
        self,
        body: Body,
        program: Program,
        library: Library,
        binding: Mapping[str, str],
        *,
        worlds: int = 1,
        agent: int | None = None,
        others: Sequence[Program] = (),
    ) -> None:
        self.body, self.worlds = body, worlds
        self._chosen = mark_agent(agent, body.agents // worlds)
        self.own_robots = None if agent is None or not isinstance(body, World) else self._chosen
        programs = [program] * (body.agents // worlds)
        if agent is not None:
            programs = [*others]
            programs[agent] = program
        self.engine = Engine(body, programs * worlds)
        self._library, self._binding = library, binding
        self._plan = self.engine.plan() if isinstance(body, World) else None

    def tick(self) -> None:
        """Let all agents sense, decide and act once."""
        self.engine.tick()

    def advance(self, ticks: int) -> None:
        """Run ticks; worlds of a scenario stop where they reach its goal if the whole program can be compiled."""
        self._advance(ticks, until_finished=True)

    def advance_all(self, ticks: int) -> None:
        """Run ticks in all worlds, also in those that have reached the scenario's goal."""
        self._advance(ticks, until_finished=False)

    def _advance(self, ticks: int, *, until_finished: bool) -> None:
        if self._plan is not None and isinstance(self.body, World):
            self.body.advance(self._plan, ticks, until_finished=until_finished)
            return
        for _ in range(ticks):
            self.engine.tick()

    @property
    def is_fused(self) -> bool:
        """Whether many ticks can be run at once."""
        return self._plan is not None

    def find_raised(self, flag: str) -> NDArray[np.bool_]:
        """Return in which worlds [B] all agents have raised a flag."""
        return np.asarray(self.find_raised_agents(flag).all(axis=1))

    def find_raised_agents(self, flag: str) -> NDArray[np.bool_]:
        """Return which of the n agents of each world that run it have raised a flag [B, n]."""
        return self.engine.find_raised(flag).reshape(self.worlds, -1)[:, self._chosen]

    def find_raised_s(self, flag: str) -> NDArray[np.float64]:
        """Return when each of the n agents of each world that run it raised a flag [B, n], s; NaN where one has not."""
        return find_raised_times(self.engine, flag, worlds=self.worlds)[:, self._chosen]

    def find_reading(self, text: str) -> RunReading:
        """Find a reading by its name."""
        found = find_reading(text, self._library, self.body, binding=self._binding, where="the body")
        return RunReading(found, lambda: self.body.sense(found.keys), self.worlds, self._chosen)


class TeamRun:
    """A behavior that agents of some sorts of a simulated team run; those below coordinators follow orders.

    Parameters
    ----------
    team
        The team.
    libraries
        The library of each sort that runs it.
    roots
        The behavior of each sort that runs it, with its targets.
    agent
        The only agent of a world that runs it, among those of one sort. None: all do.
    """

    def __init__(
        self,
        team: Team,
        libraries: Libraries,
        roots: Mapping[str, tuple[str, Mapping[str, str]]],
        *,
        agent: int | None = None,
    ) -> None:
        self.team, self.body = team, team.ground
        self._libraries, self._roots, self._agent = libraries, roots, agent
        self.worlds = self.body.worlds if isinstance(self.body, World) else 1
        self.own_robots: NDArray[np.bool_] | None = None

    def tick(self) -> None:
        """Let all agents sense, decide and act once."""
        self.team.tick()

    @property
    def is_fused(self) -> bool:
        """Whether many ticks can be run at once."""
        return False

    def advance(self, ticks: int) -> None:
        """Run ticks one by one."""
        for _ in range(ticks):
            self.team.tick()

    def advance_all(self, ticks: int) -> None:
        """Run ticks one by one."""
        self.advance(ticks)

    def find_raised(self, flag: str) -> NDArray[np.bool_]:
        """Return in which worlds [B] all agents that run the behavior have raised a flag."""
        return np.asarray(self.find_raised_agents(flag).all(axis=1))

    def find_raised_agents(self, flag: str) -> NDArray[np.bool_]:
        """Return which of the n agents of each world that run the behavior have raised a flag [B, n]."""
        raised = find_raised_members(self.team, self._roots, flag, self.worlds)
        return raised[:, mark_agent(self._agent, raised.shape[1])]

    def find_reading(self, text: str) -> RunReading:
        """Find a reading of those who run the behavior, or else of a type of robots."""
        known: list[str] = []
        for sort in dict.fromkeys((*self._roots, *self.team.tree.types)):
            layer = self.team.layer(sort)
            binding = dict(self._roots[sort][1]) if sort in self._roots else {}
            try:
                found = find_reading(
                    text, self._libraries[sort], layer.body, binding=binding, where="the team"
                )
            except UnknownName as error:
                if error.what == "target":
                    raise
                known += error.known
                continue
            self.team.sense_also(sort, found.keys)
            if sort in self.team.tree.types:
                chosen = select_type(self.team, sort)
            else:
                chosen = mark_agent(self._agent, layer.body.agents // self.worlds)
            return RunReading(found, partial(self._sense, layer), self.worlds, chosen)
        name = text.partition("(")[0].strip()
        known = list(dict.fromkeys(known))
        raise UnknownName(what="feature or reading", name=name, where="the team", known=known)

    def _sense(self, layer: AgentLayer) -> Percept:
        self.team.sense()
        return layer.percept

    def sense_all(self) -> None:
        """Let those who run the behavior sense all their readings from now on, so that each can be read later."""
        for sort in self._roots:
            self.team.sense_also(sort, list_reading_keys(self.team.layer(sort).body))


def mark_agent(agent: int | None, agents: int) -> NDArray[np.bool_]:
    """Return which agents of a world [N] are an agent; all if None."""
    return np.ones(agents, np.bool_) if agent is None else np.arange(agents) == agent


def select_type(team: Team, sort: str) -> NDArray[np.bool_]:
    """Return which robots of a world [N] are of a type."""
    return np.asarray(np.array(team.tree.type_of) == team.tree.types.index(sort))


def find_raised_by_all(team: Team, sorts: Collection[str], flag: str, worlds: int) -> NDArray[np.bool_]:
    """Return in which worlds [B] all agents of these sorts have raised a flag."""
    return np.asarray(find_raised_members(team, sorts, flag, worlds).all(axis=1))


def find_raised_members(team: Team, sorts: Collection[str], flag: str, worlds: int) -> NDArray[np.bool_]:
    """Return which of the n agents of these sorts in each world have raised a flag [B, n]."""
    found = [np.empty((worlds, 0), np.bool_)]
    for sort in sorts:
        raised = team.find_raised(sort, [flag]).reshape(worlds, -1)
        # robots of all types are in one layer
        found.append(raised[:, select_type(team, sort)] if sort in team.tree.types else raised)
    return np.concatenate(found, axis=1)


def find_raised_times(engine: Engine, flag: str, *, worlds: int) -> NDArray[np.float64]:
    """Compute when each of the n agents of each world raised a flag [B, n], in s; NaN where one has not.

    An agent stays in the state that raises the flag, so the time at which it entered that state can be read later.
    """
    tick_s = engine.body.tick_s
    ticks = np.where(engine.find_raised(flag), np.rint(engine.stacks.entered[:, 0] / tick_s) + 1, np.nan)
    return tick_s * ticks.reshape(worlds, -1)
