"""A behavior that runs in several worlds side by side: alone on all agents of a body, or in a team.

Goals and metrics of one's own are read from it between ticks.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError, UnknownName
from understudy.judging.named_reading import NamedReading, find_reading
from understudy.model.features import Percept
from understudy.model.library import Library
from understudy.model.value_kinds import Column
from understudy.runtime.body import Body, list_reading_keys
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import Program
from understudy.runtime.team.coordinator_body import CoordinatorBody
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
        chosen: Column = column[:, self.chosen]
        return chosen


class BehaviorRun(ABC):
    """A behavior that runs in B worlds, each with as many agents.

    Parameters
    ----------
    body
        The body of the robots, or of those who run the behavior.
    worlds
        The number of worlds.
    """

    team: Team | None = None
    """The team, if not all robots run the behavior by themselves."""
    own_robots: NDArray[np.bool_] | None = None
    """Which simulated robots of a world [N] run the behavior, or follow who does. None: all count."""

    def __init__(self, body: Body, worlds: int) -> None:
        self.body, self.worlds = body, worlds
        self.ticks = 0
        """The number of ticks since the run began."""
        self._began_s = self._now_s = body.time_s

    @property
    def is_fused(self) -> bool:
        """Whether many ticks can be run at once."""
        return False

    @property
    def knows_times(self) -> bool:
        """True if `find_raised_s` can be called at any time after a flag was raised."""
        return False

    @property
    def world(self) -> World | None:
        """The simulated worlds; None if the robots are not simulated."""
        ground = self.body.ground if isinstance(self.body, CoordinatorBody) else self.body
        return ground if isinstance(ground, World) else None

    def get_world(self) -> World:
        """Return the simulated worlds; TypeError if the robots are not simulated."""
        if self.world is None:
            raise TypeError("a body that is not simulated")
        return self.world

    @property
    def time_s(self) -> float:
        """The time since the run began, s; in simulated worlds, which may end apart, by the number of ticks."""
        return self.ticks * self.body.tick_s if self.world is not None else self._now_s - self._began_s

    def count_ticks_left(self, limit_s: Column) -> NDArray[np.int64]:
        """Count the ticks that end before the time limit of each world [B], s; of a body with its own clock, 0 or 1."""
        if self.world is not None:
            return np.floor(limit_s / self.body.tick_s + 1e-9).astype(np.int64) - self.ticks
        return (self.time_s + self.body.tick_s <= limit_s + 1e-9).astype(np.int64)

    def advance(self, ticks: int, *, to_goal: bool = False, ended: NDArray[np.bool_] | None = None) -> None:
        """Run ticks.

        Parameters
        ----------
        ticks
            The number of ticks.
        to_goal
            Whether worlds of a scenario may stop where they reach its goal.
        ended
            The worlds that may stay as they are [B]. None: none.

        Raises
        ------
        SettingError
            If a body that is not simulated does not advance its time.
        """
        self._advance(ticks, to_goal=to_goal, ended=ended)
        self.ticks += ticks
        if self.world is None:
            before, self._now_s = self._now_s, self.body.time_s
            if not self._now_s > before:
                raise SettingError(
                    where="the body",
                    setting="time_s",
                    problem=f"stood still at {before} s during a tick",
                    remedy="let `act` advance it",
                )

    def _advance(self, ticks: int, *, to_goal: bool, ended: NDArray[np.bool_] | None) -> None:
        for _ in range(ticks):
            self._tick()

    @abstractmethod
    def _tick(self) -> None:
        """Let all agents sense, decide and act once."""

    def find_raised(self, flag: str) -> NDArray[np.bool_]:
        """Return in which worlds [B] all agents that run the behavior have raised a flag."""
        return np.asarray(self.find_raised_agents(flag).all(axis=1))

    @abstractmethod
    def find_raised_agents(self, flag: str) -> NDArray[np.bool_]:
        """Return which of the n agents of each world that run the behavior have raised a flag [B, n]."""

    def find_raised_s(self, flag: str) -> NDArray[np.float64]:
        """Return when each of the n agents of each world that run it raised a flag [B, n], s; NaN where one has not."""
        raise TypeError("a run that does not know when flags were raised")

    @abstractmethod
    def find_reading(self, text: str) -> RunReading:
        """Find a reading by its name, such as "range(station)"; UnknownName or SettingError if there is none."""


class ProgramRun(BehaviorRun):
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
    agent
        The only agent of each world that runs the behavior. None: all do.
    others
        What the agents of each world run, one program each; that at `agent` is not used.
    """

    def __init__(
        self,
        body: Body,
        program: Program,
        library: Library,
        binding: Mapping[str, str],
        *,
        agent: int | None = None,
        others: Sequence[Program] = (),
    ) -> None:
        worlds = body.worlds if isinstance(body, World) else 1
        super().__init__(body, worlds)
        self._chosen = mark_agent(agent, body.agents // worlds)
        self.own_robots = None if agent is None or not isinstance(body, World) else self._chosen
        programs = [program] * (body.agents // worlds)
        if agent is not None:
            programs = [*others]
            programs[agent] = program
        self.engine = Engine(body, programs * worlds)
        self._library, self._binding = library, binding
        self._plan = self.engine.plan() if isinstance(body, World) else None

    @property
    def is_fused(self) -> bool:
        """Whether many ticks can be run at once."""
        return self._plan is not None

    @property
    def knows_times(self) -> bool:
        """True in simulated worlds, where the time at which a flag was raised can be read later."""
        return isinstance(self.body, World)

    def _advance(self, ticks: int, *, to_goal: bool, ended: NDArray[np.bool_] | None) -> None:
        if self._plan is not None and isinstance(self.body, World):
            self.body.advance(self._plan, ticks, until_finished=to_goal, ended=ended)
        else:
            super()._advance(ticks, to_goal=to_goal, ended=ended)

    def _tick(self) -> None:
        self.engine.tick()

    def find_raised_agents(self, flag: str) -> NDArray[np.bool_]:
        """Return which of the n agents of each world that run it have raised a flag [B, n]."""
        return self.engine.find_raised(flag).reshape(self.worlds, -1)[:, self._chosen]

    def find_raised_s(self, flag: str) -> NDArray[np.float64]:
        """Return when each of the n agents of each world that run it raised a flag [B, n], s; NaN where one has not."""
        times = find_raised_times(self.engine, flag, worlds=self.worlds, began_s=self._began_s)
        return times[:, self._chosen]

    def find_reading(self, text: str) -> RunReading:
        """Find a reading by its name."""
        reading = find_reading(text, self._library, self.body, binding=self._binding, where="the body")
        return RunReading(reading, lambda: self.body.sense(reading.keys), self.worlds, self._chosen)


class TeamRun(BehaviorRun):
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
        super().__init__(team.ground, team.ground.worlds if isinstance(team.ground, World) else 1)
        self.team = self._team = team
        self._libraries, self._roots, self._agent = libraries, roots, agent

    def _tick(self) -> None:
        self._team.tick()

    def find_raised_agents(self, flag: str) -> NDArray[np.bool_]:
        """Return which of the n agents of each world that run the behavior have raised a flag [B, n]."""
        raised = find_raised_members(self._team, self._roots, flag, self.worlds)
        return raised[:, mark_agent(self._agent, raised.shape[1])]

    def find_reading(self, text: str) -> RunReading:
        """Find a reading of those who run the behavior, or else of a type of robots."""
        names: list[str] = []
        for sort in dict.fromkeys((*self._roots, *self._team.tree.types)):
            layer = self._team.layer(sort)
            binding = dict(self._roots[sort][1]) if sort in self._roots else {}
            try:
                reading = find_reading(
                    text, self._libraries[sort], layer.body, binding=binding, where="the team"
                )
            except UnknownName as error:
                if error.what == "target":
                    raise
                names += error.known
                continue
            self._team.sense_also(sort, reading.keys)
            if sort in self._team.tree.types:
                chosen = select_type(self._team, sort)
            else:
                chosen = mark_agent(self._agent, layer.body.agents // self.worlds)
            return RunReading(reading, partial(self._sense, layer), self.worlds, chosen)
        name = text.partition("(")[0].strip()
        names = list(dict.fromkeys(names))
        raise UnknownName(what="feature or reading", name=name, where="the team", known=names)

    def _sense(self, layer: AgentLayer) -> Percept:
        self._team.sense()
        return layer.percept

    def sense_all(self) -> None:
        """Let those who run the behavior sense all their readings from now on, so that each can be read later."""
        for sort in self._roots:
            self._team.sense_also(sort, list_reading_keys(self._team.layer(sort).body))


def mark_agent(agent: int | None, agents: int) -> NDArray[np.bool_]:
    """Return which agents of a world [N] are an agent; all if None."""
    return np.ones(agents, np.bool_) if agent is None else np.arange(agents) == agent


def select_type(team: Team, sort: str) -> NDArray[np.bool_]:
    """Return which robots of a world [N] are of a type."""
    return np.asarray(np.array(team.tree.type_of) == team.tree.types.index(sort))


def find_raised_members(team: Team, sorts: Collection[str], flag: str, worlds: int) -> NDArray[np.bool_]:
    """Return which of the n agents of these sorts in each world have raised a flag [B, n]."""
    columns = [np.empty((worlds, 0), np.bool_)]
    for sort in sorts:
        raised = team.find_raised(sort, [flag]).reshape(worlds, -1)
        # robots of all types are in one layer
        columns.append(raised[:, select_type(team, sort)] if sort in team.tree.types else raised)
    return np.concatenate(columns, axis=1)


def find_raised_times(engine: Engine, flag: str, *, worlds: int, began_s: float = 0.0) -> NDArray[np.float64]:
    """Compute when each of the n agents of each world raised a flag [B, n], s since the run began; NaN where none has.

    An agent stays in the state that raises the flag, so the time at which it entered that state can be read later.
    """
    tick_s = engine.body.tick_s
    entered = np.rint(engine.stacks.entered[:, 0] / tick_s) - round(began_s / tick_s)
    return tick_s * np.where(engine.find_raised(flag), entered + 1, np.nan).reshape(worlds, -1)
