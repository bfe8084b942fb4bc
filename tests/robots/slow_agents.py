"""Agents elsewhere that answer late or never, as the network of a laptop shows them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from threading import Event
from types import SimpleNamespace
from typing import Any

import msgspec
from tests.robots.twins import ARENA
from tests.waiting import BOUND_S, wait_until

from understudy.addons.robots.fleet import Fleet
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.team_network.agent_questions import AgentAnswer, AgentQuestion
from understudy.addons.robots.team_network.remote_robot import RemoteRobot
from understudy.addons.robots.team_network.team_watch import TeamWatch
from understudy.runtime.agents.network import Inbox

LONGEST_S = 60.0
"""How long an answer is held back if it is never let go, s."""


class SlowAgents:
    """The network of a laptop, with agents whose answers are held back or lost.

    An agent stops its robot as soon as it is asked to, and arms it when its answer is let go: as late as can be.
    """

    def __init__(self) -> None:
        self.present = frozenset[str]()
        self.asked: list[tuple[str, str]] = []
        self.published: list[str] = []
        self.armed: dict[str, bool] = defaultdict(bool)
        self.lost: set[tuple[str, str]] = set()
        self.refusing: set[str] = set()
        self.held: dict[tuple[str, str], Event] = {}

    def hold(self, name: str, do: str) -> Event:
        """Hold back an agent's answer to a question until the event is set."""
        self.held[name, do] = event = Event()
        return event

    def ask(self, key: str, question: bytes, *, timeout_s: float) -> dict[str, bytes]:
        name, do = key.removeprefix("agent/"), msgspec.msgpack.decode(question, type=AgentQuestion).do
        self.asked.append((name, do))
        if do == "stop":
            self.armed[name] = False
        if (name, do) in self.held:
            self.held[name, do].wait(LONGEST_S)
        if do == "arm" and name in self.refusing:
            return {key: msgspec.msgpack.encode(AgentAnswer(problem="is outside its geofence"))}
        if do == "arm":
            self.armed[name] = True
        permit = "a permit" if do == "ready" else ""
        return {} if (name, do) in self.lost else {key: msgspec.msgpack.encode(AgentAnswer(permit=permit))}

    def publish(self, key: str, message: bytes) -> None:
        self.published.append(key)

    def listen(self, key: str) -> Inbox:
        return Inbox()

    def announce(self, name: str) -> None:
        pass

    def close(self) -> None:
        pass


def make_fleet(agents: SlowAgents, names: Sequence[str]) -> Fleet:
    """The robots of these agents, as the laptop drives them."""
    team: Any = SimpleNamespace(settings=SimpleNamespace(trainer="laptop"), agents=tuple(names), name="team")
    network: Any = agents
    watch = TeamWatch(team, network)
    files = [parse_robot(ARENA.format(name=name, world="arena")) for name in names]
    return Fleet([RemoteRobot(file, Path(f"{file.name}.toml"), watch) for file in files])


def wait_for(what: Callable[[], bool], within_s: float = BOUND_S) -> bool:
    """Wait until something comes true; return whether it does in time."""
    try:
        wait_until(what, bound_s=within_s)
    except TimeoutError:
        return False
    return True


def finish(fleet: Fleet) -> None:
    """Wait until all that the laptop has asked for is done."""
    for robot in fleet:
        assert isinstance(robot, RemoteRobot)
        robot._watch.close()
