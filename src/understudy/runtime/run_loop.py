"""Runs: the loop of sensing, deciding and acting over a body whose agents run programs; and the paths they took."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.model.drawing import Axes, call_markup, call_plot, format_number_of, format_repr
from understudy.model.features import Percept
from understudy.model.value_kinds import Column
from understudy.runtime.body import Body, Viewable
from understudy.runtime.command_columns import CommandColumns
from understudy.runtime.feature_columns import FeatureColumns
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import Program
from understudy.runtime.thinning_buffer import ThinningBuffer

MOST_MOMENTS, LEAST_MOMENTS, MOST_PLACES = 4_000, 300, 400_000
"""The largest number of recorded moments, its least value with many robots, and the largest number of places."""


class RecordedMoment(NamedTuple):
    """One moment of a run: a view of its world, and the outermost state of each robot in it."""

    view: Any
    doing: tuple[str, ...]


class PathRecorder:
    """A recorder of one world of a run; of long runs it keeps every second, fourth … moment.

    SettingError if the body cannot be drawn, or has no such world.
    """

    def __init__(self, run: Run, world: int = 0) -> None:
        body = run.body
        if not isinstance(body, Viewable):
            raise SettingError(
                where="run",
                setting="body",
                problem=f"is a {type(body).__name__}, which does not say where its agents are",
                remedy="give it a method view that returns a WorldView, as that of World does",
            )
        worlds = getattr(body, "worlds", 1)
        if not 0 <= world < worlds:
            problem, remedy = f"is {world} of {worlds}", "count from 0"
            raise SettingError(where="run", setting="world", problem=problem, remedy=remedy)
        self._body, self._world, self._robots = body, world, run.body.agents // worlds
        fitting = max(LEAST_MOMENTS, MOST_PLACES // max(1, self._robots))
        self._kept: ThinningBuffer[RecordedMoment] = ThinningBuffer(min(MOST_MOMENTS, fitting))

    def add(self, run: Run) -> None:
        """Record the present moment."""
        first = self._world * self._robots
        doing = tuple((*run.path(agent), "")[0] for agent in range(first, first + self._robots))
        self._kept.append(RecordedMoment(self._body.view(self._world), doing))

    @property
    def moments(self) -> list[RecordedMoment]:
        """The moments kept, with the first and the last one."""
        return self._kept.items


class Run:
    """A body with an interpreter for each of its agents.

    Parameters
    ----------
    body
        The body.
    interpreters
        The interpreter of each agent.
    others
        Further programs, which agents may `begin` later.
    """

    def __init__(
        self, body: Body, interpreters: Sequence[Interpreter], others: Sequence[Program] = ()
    ) -> None:
        if len(interpreters) != body.agents:
            raise SettingError(
                where="run",
                setting="interpreters",
                problem=f"are {len(interpreters)} for {body.agents} agents",
                remedy="give one per agent",
            )
        self.body = body
        self._channels = [channel.name for channel in body.channels]
        self._recorder: PathRecorder | None = None
        self.interpreters = list(interpreters)
        self._known: dict[int, _ProgramGroup] = {}
        for program in others:
            self._group(program, [])
        self._regroup()

    def _regroup(self) -> None:
        each = [interpreter.program for interpreter in self.interpreters]
        groups: dict[int, list[int]] = {}
        for agent, program in enumerate(each):
            groups.setdefault(id(program), []).append(agent)
        self._groups = [self._group(each[agents[0]], agents) for agents in groups.values()]
        self.keys = tuple(dict.fromkeys(key for group in self._known.values() for key in group.keys))

    def _group(self, program: Program, agents: list[int]) -> _ProgramGroup:
        if id(program) not in self._known:
            self._known[id(program)] = _ProgramGroup(self.body, program)
        group = self._known[id(program)]
        group.agents = agents
        group.rows = slice(None) if len(agents) == self.body.agents else np.array(agents, np.intp)
        return group

    @classmethod
    def from_program(cls, body: Body, program: Program) -> Self:
        """Make a run in which every agent runs the same program.

        Parameters
        ----------
        body
            The body.
        program
            The program, as `link` makes it.

        Returns
        -------
        Run
            The run, before its first tick.
        """
        return cls(body, [Interpreter(program, now=body.time_s) for _ in range(body.agents)])

    def tick(self) -> None:
        """Sense, decide and act once."""
        self.body.act(self.decide(self.body.sense(self.keys)))
        if self._recorder is not None:
            self._recorder.add(self)

    def decide(self, percept: Percept) -> dict[str, Column]:
        """Pulse every agent on one snapshot.

        Parameters
        ----------
        percept
            A column [N] for each key that the programs read.

        Returns
        -------
        dict
            A column [N] of commands for each channel.
        """
        now = self.body.time_s
        commands = np.empty((len(self._channels), self.body.agents))
        for group in self._groups:
            values = group.sensing.columns(percept).T[group.rows].tolist()
            running = np.zeros(self.body.agents, dtype=np.intp)
            running[group.rows] = [
                self.interpreters[agent].pulse(row, now)
                for agent, row in zip(group.agents, values, strict=True)
            ]
            commands[:, group.rows] = group.acting.commands(running, percept, self._entered)[:, group.rows]
        return dict(zip(self._channels, commands, strict=True))

    def _entered(self) -> Column:
        return np.array([interpreter.behavior_start_s for interpreter in self.interpreters])

    def begin(self, agents: Sequence[int] | NDArray[np.intp], program: Program) -> None:
        """Let agents begin a program.

        Parameters
        ----------
        agents
            Indices of the agents.
        program
            One of the programs that the run was made with.
        """
        for agent in agents:
            interpreter = self.interpreters[agent]
            if interpreter.program is program:
                interpreter.start(self.body.time_s)
            else:
                self.interpreters[agent] = Interpreter(program, now=self.body.time_s)
        self._regroup()

    def path(self, agent: int) -> tuple[str, ...]:
        """Return what an agent is doing.

        Parameters
        ----------
        agent
            Index of the agent.

        Returns
        -------
        tuple
            The current state of every level, from the root down.
        """
        return self.interpreters[agent].path

    def record_paths(self, world: int = 0) -> None:
        """Record from now on where the agents are and what they do, for `plot`; an earlier record is dropped.

        Parameters
        ----------
        world
            The index of the world to record, from 0.

        Raises
        ------
        SettingError
            If the body does not say where its agents are, or has no such world.
        """
        self._recorder = PathRecorder(self, world)
        self._recorder.add(self)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Plot the paths of the robots since `record_paths`, with the things in their world.

        The path of a single robot shows its outermost state. Up to eight robots differ in color and line, many have
        faint trails.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw into. None: in a new figure.

        Returns
        -------
        Axes
            The axes, in m.

        Raises
        ------
        SettingError
            If nothing was recorded.
        """
        if self._recorder is None:
            remedy = "call record_paths() before the ticks to plot"
            raise SettingError(where="run", setting="paths", problem="are not recorded", remedy=remedy)
        return call_plot("run_plot:plot_run", self._recorder.moments, ax)

    def __repr__(self) -> str:
        agents, body = format_number_of(self.body.agents, "agent"), type(self.body).__name__
        return format_repr(self, f"of {agents}", f"on a {body}", f"at {self.body.time_s:.1f} s")

    def _repr_html_(self) -> str:
        return call_markup("html_cards:write_run_html", self)

    def find_raised(self, flag: str) -> NDArray[np.bool_]:
        """Find the agents whose root has raised a flag.

        Parameters
        ----------
        flag
            Name of the flag.

        Returns
        -------
        array
            True for each such agent [N].
        """
        return np.array([interpreter.root.flag == flag for interpreter in self.interpreters])


class _ProgramGroup:
    """The agents that run one program."""

    def __init__(self, body: Body, program: Program) -> None:
        self.program, self.agents = program, list[int]()
        self.rows: slice | NDArray[np.intp] = slice(0)
        """The rows of its agents in columns: quick to select if it has all."""
        self.sensing = FeatureColumns(program.features, body)
        self.acting = CommandColumns(program.basics, body)
        self.keys = (*self.sensing.keys, *self.acting.keys)
