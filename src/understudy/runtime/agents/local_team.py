"""A team of agents in one process: each decides for itself, and they exchange messages over a `LocalNetwork`.

With a network that loses and delays nothing it does what `Team` does, tick by tick. Agents can be taken out and put
back, as if their computers died and came back.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from understudy.model.binding import Binding
from understudy.model.features import Percept, ReadingKey
from understudy.model.squad import Assignment
from understudy.runtime.agents.agent import Agent
from understudy.runtime.agents.coordinator import SquadCoordinator
from understudy.runtime.agents.network import LocalNetwork
from understudy.runtime.agents.team_plan import TeamPlan
from understudy.runtime.body import Body, Commands
from understudy.runtime.body_wrapper import BodyWrapper
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import IDLE_PROGRAM, Program
from understudy.runtime.run_loop import Run
from understudy.runtime.team.comms import HasFailures

LONGEST_TICK_S = 0.1
"""The longest time that a tick counts for leases and silence, s: with slow ticks, agents that are well would be silent.
"""


@cache
def _format_duty(behavior: str, *binding: tuple[str, str]) -> str:
    """Write what a member was ordered to do."""
    return str(Assignment(behavior, Binding(dict(binding))))


class SnapshotBody(BodyWrapper[Body]):
    """The body of all robots of a process, which is sensed once in a tick for all agents.

    Parameters
    ----------
    body
        The body.
    """

    def __init__(self, body: Body) -> None:
        super().__init__(body)
        self._failing: HasFailures | None = body if isinstance(body, HasFailures) else None  # slow to ask
        self._percept: dict[ReadingKey, NDArray[np.float64]] = {}
        self._failed: NDArray[np.bool_] | None = None

    def renew(self, keys: Sequence[ReadingKey]) -> Percept:
        """Take this tick's snapshot, with these readings."""
        self._percept, self._failed = dict(super().sense(keys)), None
        return self._percept

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return readings of this tick's snapshot, a column [N] for each key; others are sensed now."""
        if lacking := [key for key in keys if key not in self._percept]:
            self._percept = {**self._percept, **super().sense(lacking)}
        return {key: self._percept[key] for key in keys}

    @property
    def failed(self) -> NDArray[np.bool_]:
        """The agents that are out of action in this tick [N]."""
        if self._failed is None:
            failing = self._failing
            self._failed = np.zeros(self.agents, np.bool_) if failing is None else failing.failed
        return self._failed


class BodyRow(BodyWrapper[SnapshotBody]):
    """One agent of a body as a body of its own; its commands are kept until `LocalTeam` executes those of all."""

    def __init__(self, body: SnapshotBody, row: int) -> None:
        super().__init__(body)
        self.agents, self._row = 1, row
        self.commands: Commands = {}

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return the readings of this agent, a column [1] for each key."""
        row = slice(self._row, self._row + 1)
        return {key: np.asarray(column)[row] for key, column in super().sense(keys).items()}

    def act(self, commands: Commands) -> None:
        """Keep the commands of this tick."""
        self.commands = commands

    def find_unfitness(self) -> str:
        """Return why this agent must not be counted; empty if it is fit."""
        return "has failed" if self.ground.failed[self._row] else ""


class LocalTeam:
    """The agents of a team over the body of all robots.

    Parameters
    ----------
    ground
        The body of all robots.
    plan
        The team.
    network
        The network between the agents.
    """

    def __init__(self, ground: Body, plan: TeamPlan, network: LocalNetwork | None = None) -> None:
        self.ground, self.plan, self.network = ground, plan, network or LocalNetwork()
        self.snapshot = SnapshotBody(ground)
        """The body with this tick's readings."""
        self._now = 0.0
        """The time by which orders hold and members are silent, s: what holds up this process ends no order."""
        self.rows = {name: BodyRow(self.snapshot, row) for row, name in enumerate(plan.robots)}
        specs = [plan.make_agent_spec(name) for name in plan.robots]
        first = [Interpreter(spec.alone, now=ground.time_s) for spec in specs]
        programs = {id(program): program for spec in specs for program in spec.list_programs()}
        self.runner = Run(ground, first, list(programs.values()))
        """The run of the robots' programs."""
        reported = [spec.link.keys for spec in specs if spec.link is not None]
        self._keys = tuple(dict.fromkeys((*self.runner.keys, *(key for keys in reported for key in keys))))
        self._resting = {channel.name: channel.rest for channel in ground.channels}
        self.robots: dict[str, Agent] = {}
        self.coordinators: dict[str, dict[str, SquadCoordinator]] = {name: {} for name in plan.squads}
        """The coordinators of each squad, by the agent that they run on."""
        self.stopped: set[str] = set()
        """Agents whose program does not run now."""
        self.commands: Commands = {}
        """The commands of the last tick, a column [N] for each channel."""
        self.clear()

    def clear(self) -> None:
        """Restart all agents, without orders and memory; the first candidate leads each squad."""
        for name in (*self.plan.robots, *self.plan.squads):
            self.start(name, leads=True)

    def start(self, name: str, *, leads: bool = False) -> None:
        """Restart an agent, without any memory; `leads`: it leads the squads for which it is the first choice."""
        self.stop(name)
        self.stopped.discard(name)
        node = self.network.join(name)
        node.announce(name)
        if name in self.rows:
            row, number = self.rows[name], self.plan.robots.index(name)
            self.robots[name] = Agent(
                self.plan.make_agent_spec(name),
                row,
                node,
                unfit=row.find_unfitness,
                clock=lambda: self._now,
                shared=(self.runner, number),
            )
        for squad in self.plan.list_led_squads(name):
            self.coordinators[squad][name] = SquadCoordinator(
                self.plan.make_agent_spec(squad),
                self.plan.make_squad_spec(squad),
                host=name,
                candidates=self.plan.list_candidates(squad),
                clock=self.ground,
                network=node,
                leads=leads and self.plan.list_candidates(squad)[0] == name,
                lease_clock=lambda: self._now,
            )

    def stop(self, name: str) -> None:
        """Take an agent out, as if its program had been killed."""
        self.stopped.add(name)
        self.network.leave(name)
        if self.robots.pop(name, None) is not None:
            self.runner.begin([self.plan.robots.index(name)], IDLE_PROGRAM)
        for hosts in self.coordinators.values():
            hosts.pop(name, None)

    @property
    def _running(self) -> list[SquadCoordinator]:
        """All coordinators that run, bottom-up."""
        return [each for hosts in self.coordinators.values() for each in hosts.values()]

    def find_leaders(self, squad: str) -> list[str]:
        """Find the agents that believe to lead a squad."""
        return [host for host, each in self.coordinators[squad].items() if each.leads]

    def tick(self) -> None:
        """Let all agents sense and report bottom-up, decide and act top-down; then the robots move for one tick."""
        percept = self.snapshot.renew(self._keys)
        for robot in self.robots.values():
            robot.sense()
            robot.report()
        for coordinator in self._running:
            coordinator.sense()
            coordinator.report()
        for coordinator in reversed(self._running):
            coordinator.obey()
            coordinator.act()
        for robot in self.robots.values():
            robot.obey()
        self.commands = self._decide(percept)
        self.ground.act(self.commands)
        self.network.step()
        self._now = self.network.step_number * min(self.ground.tick_s, LONGEST_TICK_S)

    def _decide(self, percept: Percept) -> dict[str, NDArray[np.float64]]:
        """Decide for all robots together, and return their commands; robots without a program rest."""
        decided = dict(self.runner.decide(percept))
        for row, name in enumerate(self.plan.robots):
            robot = self.robots.get(name)
            if robot is None:
                commands: Commands | None = {}
            elif robot.run is self.runner:
                commands = robot.find_driven_commands()
            else:
                robot.act()
                commands = self.rows[name].commands
            if commands is not None:
                for channel, rest in self._resting.items():
                    decided[channel][row] = commands[channel][0] if channel in commands else rest
        return decided

    def run(self, ticks: int) -> None:
        """Run a number of ticks."""
        for _ in range(ticks):
            self.tick()

    @property
    def paths(self) -> list[tuple[str, ...]]:
        """The states of each robot, outermost first, beginning with the behavior it was ordered; () if it idles."""
        return [self._find_path(self.robots.get(name)) for name in self.plan.robots]

    @staticmethod
    def _find_path(robot: Agent | None) -> tuple[str, ...]:
        if robot is None:
            return ()
        path, follower = robot.path, robot.follower
        if follower is None or follower.duty is None:
            return path
        behavior, binding = follower.duty
        return (_format_duty(behavior, *binding.items()), *path)

    def find_raised(self, name: str, flags: Collection[str]) -> NDArray[np.bool_]:
        """Find the agents of a sort that have raised one of some flags.

        Parameters
        ----------
        name
            The sort of agents: a type of robots, all of which are looked at, or a kind of squads.
        flags
            Names of the flags.

        Returns
        -------
        array
            True for each such agent [N].
        """
        if name in self.plan.tree.types:
            raised = [each.root.flag for each in self.runner.interpreters]
        else:
            leaders = [
                next((each for each in hosts.values() if each.leads), None)
                for squad, hosts in self.coordinators.items()
                if self.plan.find_sort(squad) == name
            ]
            raised = [None if each is None else each.agent.interpreter.root.flag for each in leaders]
        return np.array([flag in flags for flag in raised], np.bool_)

    @property
    def programs(self) -> Mapping[str, Sequence[Program]]:
        """The programs that agents of each sort run or may be ordered to run."""
        return self.plan.programs
