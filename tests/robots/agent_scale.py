"""Measure teams of three levels over Zenoh: many agents in a few processes, on this machine.

    unshare --net python -m tests.robots.agent_scale --agents 50 100 200 --processes 20

prints for each size how long orders take from publication to receipt in another process, and how many bytes cross the
loopback interface for each agent; `unshare --net` gives it one of its own, on which there is nothing else. All agents
tick at 10 Hz, those of one process one after the other. Bodies are functions of time: what is measured is messages and
decisions.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from argparse import ArgumentParser
from collections import Counter
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from hashlib import blake2b
from multiprocessing import get_context
from os import getloadavg
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from tests.bodies import TICK_S
from tests.robots.routers import free_port
from tests.robots.scale_team import TOP, Wanderer, list_processes, make_plan

from understudy.addons.robots.team_network.agent_process import WallClock
from understudy.addons.robots.team_network.zenoh_network import ZenohNetwork, ZenohOptions
from understudy.runtime.agents.agent import Agent
from understudy.runtime.agents.coordinator import SquadCoordinator
from understudy.runtime.agents.network import Inbox, Observe
from understudy.runtime.agents.team_plan import TeamPlan

COUNTED = Path("/proc/net/dev")
JOINING_S = 300.0


@dataclass
class Measured:
    """What one process saw.

    Orders have the time (ns) at which they were published, and all at which they were received; `messages` and `bytes`
    are those published while it was counted, by the key's level.
    """

    published: dict[bytes, int] = field(default_factory=dict)
    received: list[tuple[bytes, int]] = field(default_factory=list)
    messages: Counter[str] = field(default_factory=Counter)
    bytes: Counter[str] = field(default_factory=Counter)
    ticks: int = 0
    late: int = 0
    cpu_s: float = 0.0
    ordered: int = 0
    """The number of robots and squads that had an order in the end."""


class MeasuredNetwork(ZenohNetwork):
    """An access to the team that notes when orders leave and arrive."""

    def __init__(self, options: ZenohOptions) -> None:
        super().__init__("scale", options)
        self.measured = Measured()

    def publish(self, key: str, message: bytes) -> None:
        if key.startswith("order/"):
            self.measured.published[_digest(message)] = time.monotonic_ns()
        sort = key if key.endswith(TOP) else key.rpartition("_")[0]
        self.measured.messages[sort] += 1
        self.measured.bytes[sort] += len(message)
        super().publish(key, message)

    def listen(self, key: str, observe: Observe | None = None) -> Inbox:
        if key.startswith("order/"):
            self._declared.append(self._session.declare_subscriber(f"{self._team}/{key}", self._note))
        return super().listen(key, observe)

    def _note(self, sample: Any) -> None:
        now = time.monotonic_ns()
        self.measured.received.append((_digest(bytes(sample.payload)), now))


def _digest(message: bytes) -> bytes:
    return blake2b(message, digest_size=12).digest()


class Host:
    """The agents of one process."""

    def __init__(self, names: list[str], plan: TeamPlan, network: MeasuredNetwork) -> None:
        self.network = network
        self.robots: dict[str, tuple[Wanderer, Agent]] = {}
        self.coordinators: dict[str, tuple[Wanderer | WallClock, list[SquadCoordinator]]] = {}
        for name in names:
            clock: Wanderer | WallClock = WallClock(TICK_S, plan.targets)
            if name in plan.robots:
                clock = body = Wanderer(plan.robots.index(name))
                self.robots[name] = body, Agent(plan.make_agent_spec(name), body, network)
            led = [
                SquadCoordinator(
                    plan.make_agent_spec(squad),
                    plan.make_squad_spec(squad),
                    host=name,
                    candidates=plan.list_candidates(squad),
                    clock=clock,
                    network=network,
                )
                for squad in plan.list_led_squads(name)
            ]
            self.coordinators[name] = clock, led
            network.announce(name)

    def tick(self) -> None:
        """Let each agent hear, sense, report, decide and act, as `AgentProcess` does."""
        for name, (clock, led) in self.coordinators.items():
            clock.advance()
            robot = self.robots.get(name)
            if robot is not None:
                robot[1].sense()
                robot[1].report()
            for each in led:
                each.sense()
                each.report()
            for each in reversed(led):
                each.obey()
                each.act()
            if robot is not None:
                robot[1].obey()
                robot[1].act()

    def count_ordered(self) -> int:
        """Count the agents that execute an order."""
        agents = [agent for _, agent in self.robots.values()]
        agents += [each.agent for _, led in self.coordinators.values() for each in led if each.leads]
        return sum(agent.follower is not None and agent.follower.order is not None for agent in agents)


def run_host(
    number: int, names: list[str], agents: int, options: ZenohOptions, begin: Any, counts: Any, found: Any
) -> None:
    """Run agents in this process, and hand out what it saw while `counts` was set."""
    network = MeasuredNetwork(options)
    host = Host(names, make_plan(agents), network)
    found.put((number, None))
    begin.wait(JOINING_S)
    due = time.monotonic() + Random(number).random() * TICK_S
    measured, began, is_counting = network.measured, 0.0, False
    while begin.is_set() and (counts.is_set() or not is_counting):
        left = due - time.monotonic()
        if left > 0:
            time.sleep(left)
        if counts.is_set() and not is_counting:
            is_counting, began = True, _cpu_s()
            network.measured = measured = Measured()
        host.tick()
        measured.ticks += len(names)
        measured.late += len(names) * (left < -TICK_S)
        due = max(due + TICK_S, time.monotonic() - TICK_S)
    measured.cpu_s = _cpu_s() - began
    measured.ordered = host.count_ordered()
    found.put((number, measured))
    time.sleep(2.0)  # the others still count
    with suppress(Exception):
        network.close()


def _cpu_s() -> float:
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def count_bytes() -> int:
    """Return the bytes that the loopback interface of this network namespace has sent."""
    for line in COUNTED.read_text().splitlines():
        name, _, numbers = line.partition(":")
        if name.strip() == "lo":
            return int(numbers.split()[8])
    raise OSError(f"{COUNTED} has no interface lo")


def measure(agents: int, processes: int, seconds: float, *, settle_s: float, config: dict[str, Any]) -> None:
    """Run a team of so many agents, and print what was measured."""
    context = get_context("spawn")
    begin, counts, found = context.Event(), context.Event(), context.Queue()
    ports = [f"tcp/127.0.0.1:{free_port()}" for _ in range(processes)]
    dealt = list_processes(make_plan(agents), processes)
    running = [
        context.Process(
            target=run_host,
            args=(number, names, agents, ZenohOptions(ports, [ports[number]], multicast=False, config=config),
                  begin, counts, found),
        )
        for number, names in enumerate(dealt)
        if names
    ]  # fmt: skip
    with ExitStack() as ends:
        for process in running:
            process.start()
            ends.callback(process.join, 20.0)
            ends.callback(begin.clear)
        for _ in running:
            found.get(timeout=JOINING_S)  # each says when it has joined
        begin.set()
        time.sleep(settle_s)
        before, since = count_bytes(), time.monotonic()
        counts.set()
        time.sleep(seconds)
        sent, lasted = count_bytes() - before, time.monotonic() - since
        counts.clear()
        seen = dict(found.get(timeout=20.0) for _ in running)
    report(agents, seen, sent, lasted)


def report(agents: int, seen: dict[int, Measured], sent: int, lasted: float) -> None:
    """Print what was measured."""
    origin = {key: (number, at) for number, each in seen.items() for key, at in each.published.items()}
    took = np.array([
        (at - origin[key][1]) / 1e6
        for number, each in seen.items()
        for key, at in each.received
        if key in origin and origin[key][0] != number
    ])  # fmt: skip
    messages, size = sum((each.messages for each in seen.values()), Counter()), Counter[str]()
    for each in seen.values():
        size.update(each.bytes)
    median, most, worst = np.percentile(took, [50, 99, 100])
    ticks, late = sum(each.ticks for each in seen.values()), sum(each.late for each in seen.values())
    _say(
        f"{agents} agents: orders {median:.1f} ms in the middle, {most:.1f} ms at the 99th percentile, {worst:.0f} ms"
        f" at worst ({len(took)} receipts); {sent / lasted / agents / 1000:.1f} kB/s for each agent;"
        f" {sum(each.ordered for each in seen.values())} have orders; {ticks / lasted / agents:.2f} ticks/s,"
        f" {late} late; {sum(each.cpu_s for each in seen.values()) / lasted:.2f} cores, load {getloadavg()[0]:.1f}"
    )
    for sort, count in sorted(messages.items()):
        _say(f"  {sort}: {count / lasted:.0f} messages/s of {size[sort] / count:.0f} bytes")


def _say(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def main() -> None:
    """Measure each size that is asked for."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--agents", type=int, nargs="+", default=[50, 100, 200])
    parser.add_argument("--processes", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument(
        "--config", type=json.loads, default={}, help="keys of Zenoh's configuration, as JSON"
    )
    parser.add_argument("--settle", type=float, default=8.0)
    asked = parser.parse_args()
    with suppress(OSError):  # in a network namespace of its own it is down
        subprocess.run(["ip", "link", "set", "lo", "up"], check=False)
    for agents in asked.agents:
        measure(agents, asked.processes, asked.seconds, settle_s=asked.settle, config=asked.config)


if __name__ == "__main__":
    main()
