"""Runs: the loop sense, decide, act over a body whose agents run programs of a library."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, SettingError, UnknownName
from understudy.model.feature import Percept, ReadingKey, Readings, returned
from understudy.model.kinds import Column
from understudy.runtime.body import Body, every_key
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.program import GroundBehavior, Program
from understudy.runtime.sensing import Sensing, check_targets, floats


class Acting:
    """From the basic behavior each agent runs to the columns of commands that a body obeys."""

    def __init__(self, program: Program, body: Body) -> None:
        self.channels = [channel.name for channel in body.channels]
        self.rest = np.array([channel.rest for channel in body.channels])
        self.basics = program.basics
        self.table = np.tile(self.rest, (len(program.basics), 1))
        self.computed = [index for index, ground in enumerate(program.basics) if ground.behavior.function]
        self.keys: tuple[ReadingKey, ...] = every_key(body) if self.computed else ()
        for index, ground in enumerate(program.basics):
            check_targets(body, ground.binding)
            for channel, value in ground.behavior.command.items():
                if channel not in self.channels:
                    raise self._unknown(channel, ground)
                self.table[index, self.channels.index(channel)] = value

    def commands(self, running: NDArray[np.intp], percept: Percept) -> NDArray[np.float64]:
        """Commands [C, N] for the agents that run the basic behaviors `running` [N]."""
        commands: NDArray[np.float64] = self.table[running].T
        for index in self.computed:
            chosen = running == index
            if chosen.any():
                for channel, column in self._compute(index, percept, chosen).items():
                    commands[self.channels.index(channel), chosen] = column
        return commands

    def _compute(self, index: int, percept: Percept, chosen: NDArray[np.bool_]) -> dict[str, Column]:
        """What the agents that run a basic behavior which is a function command by channel."""
        ground = self.basics[index]
        function = ground.behavior.function
        if function is None:
            return {}
        targets = [Readings(percept, ground.binding[parameter]) for parameter in ground.behavior.parameters]
        found = returned(f"behavior {ground}", function, [Readings(percept), *targets])
        remedy = "return a command: a number for every agent, by channel"
        if not isinstance(found, Mapping):
            raise DefinitionError(
                what=f"behavior {ground}", problem=f"it returned {found!r:.60}", remedy=remedy
            )
        computed = {}
        for channel, values in found.items():
            if channel not in self.channels:
                raise self._unknown(channel, ground)
            what = f"behavior {ground}, channel {channel!r}"
            column = floats(values, what=what, remedy=remedy)
            if column.shape not in ((), chosen.shape):
                problem = f"it returned shape {column.shape} for {len(chosen)} agents"
                raise DefinitionError(what=what, problem=problem, remedy=remedy)
            computed[channel] = np.broadcast_to(column, chosen.shape)[chosen]
            if not np.all(np.isfinite(computed[channel])):
                raise DefinitionError(
                    what=f"behavior {ground}",
                    problem=f"its command for channel {channel!r} is not finite for some agent",
                    remedy="return a finite number for every agent, or leave the channel out",
                )
        return computed

    def _unknown(self, channel: str, ground: GroundBehavior) -> UnknownName:
        where = f"the body, for behavior {ground},"
        return UnknownName(what="channel", name=channel, where=where, known=self.channels)


class Run:
    """A body with an interpreter for each of its agents."""

    def __init__(self, body: Body, interpreters: Sequence[Interpreter]) -> None:
        if len(interpreters) != body.agents:
            raise SettingError(
                where="run",
                setting="interpreters",
                problem=f"are {len(interpreters)} for {body.agents} agents",
                remedy="give one per agent",
            )
        self.body = body
        self.interpreters = list(interpreters)
        each = [interpreter.program for interpreter in interpreters]
        groups: dict[int, list[int]] = {}
        for agent, program in enumerate(each):
            groups.setdefault(id(program), []).append(agent)
        self._groups = [_Group(body, each[agents[0]], agents) for agents in groups.values()]
        self.keys = tuple(dict.fromkeys(key for group in self._groups for key in group.keys))

    @classmethod
    def of(cls, body: Body, program: Program) -> Self:
        """A run of one program by every agent."""
        return cls(body, [Interpreter(program, now=body.time_s) for _ in range(body.agents)])

    def tick(self) -> None:
        """Sense, decide and act once."""
        self.body.act(self.decide(self.body.sense(self.keys)))

    def decide(self, percept: Percept) -> dict[str, Column]:
        """Pulse every agent on one snapshot; the commands of all."""
        now = self.body.time_s
        channels = [channel.name for channel in self.body.channels]
        commands = np.empty((len(channels), self.body.agents))
        for group in self._groups:
            rows = group.sensing.columns(percept).T[group.agents].tolist()
            running = np.zeros(self.body.agents, dtype=np.intp)
            running[group.agents] = [
                self.interpreters[agent].pulse(row, now)
                for agent, row in zip(group.agents, rows, strict=True)
            ]
            commands[:, group.agents] = group.acting.commands(running, percept)[:, group.agents]
        return dict(zip(channels, commands, strict=True))


class _Group:
    """The agents that run one program."""

    def __init__(self, body: Body, program: Program, agents: list[int]) -> None:
        self.agents = agents
        self.sensing = Sensing(program.features, body)
        self.acting = Acting(program, body)
        self.keys = (*self.sensing.keys, *self.acting.keys)
