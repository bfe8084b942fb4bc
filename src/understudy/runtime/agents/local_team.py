"""A team of agents in one process: each decides for itself, and they exchange messages over a `LocalNetwork`.

With a network that loses and delays nothing it does what `Team` does, tick by tick. Agents can be taken out and put
back, as if their computers died and came back.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from understudy.model.binding import Binding
from understudy.model.features import Percept, ReadingKey
from understudy.model.squad import Assignment
from understudy.runtime.agents.agent import Agent
from understudy.runtime.agents.coordinator import SquadCoordinator
from understudy.runtime.agents.network import LocalNetwork
from understudy.runtime.agents.team_plan import TeamPlan
from understudy.runtime.body import Body, Channel, Commands, Reading
from understudy.runtime.team.comms import HasFailures


class BodyRow:
    """One agent of a body as a body of its own; its commands are kept until `LocalTeam` executes those of all."""

    agents = 1

    def __init__(self, body: Body, row: int) -> None:
        self._body, self._row = body, row
        self.readings: Sequence[Reading] = body.readings
        self.channels: Sequence[Channel] = body.channels
        self.targets: Sequence[str] = body.targets
        self.commands: Commands = {}

    @property
    def tick_s(self) -> float:
        """The nominal length of a tick, s."""
        return self._body.tick_s

    @property
    def time_s(self) -> float:
        """The body's time, s."""
        return self._body.time_s

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return the readings of this agent, a column [1] for each key."""
        row = slice(self._row, self._row + 1)
        return {key: np.asarray(column)[row] for key, column in self._body.sense(keys).items()}

    def act(self, commands: Commands) -> None:
        """Keep the commands of this tick."""
        self.commands = commands

    def find_unfitness(self) -> str:
        """Return why this agent must not be counted; empty if it is fit."""
        failed = isinstance(self._body, HasFailures) and bool(self._body.failed[self._row])
        return "has failed" if failed else ""


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
        self.rows = {name: BodyRow(ground, row) for row, name in enumerate(plan.robots)}
        self.robots: dict[str, Agent] = {}
        self.coordinators: dict[str, dict[str, SquadCoordinator]] = {name: {} for name in plan.squads}
        """The coordinators of each squad, by the agent that they run on."""
        self.stopped: set[str] = set()
        """Agents whose program does not run now."""
        for name in (*plan.robots, *plan.squads):
            self.start(name, leads=True)

    def start(self, name: str, *, leads: bool = False) -> None:
        """Start an agent anew, without any memory; `leads`: it leads the squads for which it is the first choice."""
        self.stop(name)
        self.stopped.discard(name)
        node = self.network.join(name)
        node.announce(name)
        if name in self.rows:
            row = self.rows[name]
            spec = self.plan.make_agent_spec(name)
            self.robots[name] = Agent(spec, row, node, unfit=row.find_unfitness)
        for squad in self.plan.list_led_squads(name):
            self.coordinators[squad][name] = SquadCoordinator(
                self.plan.make_agent_spec(squad),
                self.plan.make_squad_spec(squad),
                host=name,
                candidates=self.plan.list_candidates(squad),
                clock=self.ground,
                network=node,
                leads=leads and self.plan.list_candidates(squad)[0] == name,
            )

    def stop(self, name: str) -> None:
        """Take an agent out, as if its program had been killed."""
        self.stopped.add(name)
        self.network.leave(name)
        self.robots.pop(name, None)
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
            robot.act()
        self.ground.act(self._collect_commands())
        self.network.step()

    def _collect_commands(self) -> Mapping[str, np.ndarray]:
        resting = {channel.name: channel.rest for channel in self.ground.channels}
        rows = [self.rows[name].commands if name in self.robots else {} for name in self.plan.robots]
        return {
            channel: np.array([float(row[channel][0]) if channel in row else rest for row in rows])
            for channel, rest in resting.items()
        }

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
        path, follower = robot.run.path(0), robot.follower
        if follower is None or follower.duty is None:
            return path
        behavior, binding = follower.duty
        return (str(Assignment(behavior, Binding(binding))), *path)
