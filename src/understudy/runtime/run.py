"""Runs: the loop sense, decide, act over a body whose agents run programs of a library."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np

from understudy.errors import SettingError
from understudy.model.feature import Percept
from understudy.model.kinds import Column
from understudy.runtime.acting import Acting
from understudy.runtime.body import Body
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.program import Program
from understudy.runtime.sensing import Sensing


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
        self.acting = Acting(program.basics, body)
        self.keys = (*self.sensing.keys, *self.acting.keys)
