"""Trials of agents in network namespaces: each in turn, and whichever leads, is killed, frozen, or cut off.

    python -m tests.robots.agent_trials --times 10

prints for each kind of trial what the recordings of all agents say: how old the orders were on which robots moved, how
long the squad was without a leader, whether two coordinators were obeyed at once, and how long after the end of the
trouble one agent led. It needs root; four simulated robots speak ROS 2, and the agents speak Zenoh.
"""

from __future__ import annotations

import signal
import sys
import time
from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.robots.trial_findings import Recordings, Trial, format_findings

from understudy.errors import UnderstudyError
from understudy_lab.lossy_networks.distributed_patrol import (
    MEMBERS,
    AgentsApart,
    save_library,
    simulate,
    take_precedence,
)
from understudy_lab.lossy_networks.links import LossyLinks, find_obstacle
from understudy_lab.patrol.practice import teach

BEGINS_S = 8.0
"""The time until all robots are armed and one agent leads, s."""
LASTS_S, SETTLES_S = 1.8, 2.2
"""How long the trouble lasts, and how long the team is watched afterwards, s."""
PATIENCE_S = 20.0


def kill(agents: AgentsApart, name: str) -> Iterator[None]:
    """Kill an agent; start it again after the trouble."""
    agents.signal(name, signal.SIGKILL)
    agents.running[name].wait()
    yield
    length = agents.log(name).stat().st_size
    agents.start(name)
    until = time.monotonic() + PATIENCE_S
    while agents.log(name).stat().st_size == length:
        if time.monotonic() > until:
            raise TimeoutError(f"{name} never came back")
        time.sleep(0.05)


def freeze(agents: AgentsApart, name: str) -> Iterator[None]:
    """Freeze an agent; let it go on after the trouble."""
    agents.signal(name, signal.SIGSTOP)
    yield
    agents.signal(name, signal.SIGCONT)


def break_link(agents: AgentsApart, name: str) -> Iterator[None]:
    """Cut an agent's link; heal it after the trouble."""
    agents.links.cut(name)
    yield
    agents.links.heal(name)


KINDS: Mapping[str, Callable[[AgentsApart, str], Iterator[None]]] = {
    "killed": kill,
    "frozen": freeze,
    "cut off": break_link,
}


@contextmanager
def run_patrol(folder: Path, seed: int) -> Iterator[AgentsApart]:
    """Teach a patrol, simulate its robots, and run an agent for each robot and the coordinator."""
    save_library(teach(seed).libraries, folder / "library")
    with simulate(folder, seed), LossyLinks(MEMBERS) as links, take_precedence():
        agents = AgentsApart(folder, folder / "library", links)
        try:
            time.sleep(BEGINS_S)
            yield agents
        finally:
            agents.close()


def try_once(agents: AgentsApart, kind: str, name: str) -> Trial:
    """Make trouble for one agent."""
    began_s = time.monotonic()
    trouble = KINDS[kind](agents, name)
    next(trouble)
    time.sleep(LASTS_S)
    for _ in trouble:
        raise AssertionError(f"{kind} has one step too many")
    ended_s = time.monotonic()
    time.sleep(SETTLES_S)
    return Trial(kind, name, began_s, ended_s, time.monotonic())


def main() -> None:
    """Run trials of each kind with each agent, and print what was found."""
    given = ArgumentParser(description=__doc__)
    given.add_argument("--times", type=int, default=10)
    given.add_argument("--seed", type=int, default=1000, help="of the teaching and of the world")
    asked = given.parse_args()
    if obstacle := find_obstacle():
        sys.exit(f"These trials cannot run here: {obstacle}.")
    trials: list[Trial] = []
    with TemporaryDirectory() as name:
        folder = Path(name)
        try:
            with run_patrol(folder, asked.seed) as agents:
                for _ in range(asked.times):
                    for kind in KINDS:
                        trials += [try_once(agents, kind, member) for member in MEMBERS]
                        trials += [
                            try_once(agents, kind, leader)
                            for leader in Recordings(folder).find_leaders(time.monotonic())
                        ]
                    sys.stdout.write(format_findings(Recordings(folder), trials) + "\n")
                    sys.stdout.flush()
        except UnderstudyError as error:
            sys.exit(str(error))


if __name__ == "__main__":
    main()
