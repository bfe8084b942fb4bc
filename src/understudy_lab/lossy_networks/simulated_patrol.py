"""The agents of the patrol in one program, in simulated worlds: repeatable, and with more cycles than in real time.

    python -m understudy_lab.lossy_networks.simulated_patrol

The network loses 20 % of all messages, and delivers the others in the next tick or the one after it, each half of them.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from random import Random
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.model.features import Percept
from understudy.runtime.agents.agent import Agent
from understudy.runtime.agents.local_team import LocalTeam
from understudy.runtime.agents.network import Fate, LocalNetwork, deliver_at_once
from understudy.runtime.agents.team_plan import TeamPlan
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import Libraries
from understudy.sim.world import World
from understudy_lab.lossy_networks.distributed_patrol import ALONE, BEHAVIOR
from understudy_lab.patrol import metrics, practice
from understudy_lab.patrol.evaluate import TICKS, worlds_of
from understudy_lab.patrol.practice import teach
from understudy_lab.patrol.tracks import PatrolTracks, find_activity, record_tracks

SEEDS = range(67_000, 67_004)
"""The teachings, which are those of the experiment."""
WORLDS = 20
"""The number of unseen worlds for each teaching, in each of which the team patrols for ten minutes."""
LOSS, TICKS_LATE = 0.2, (1, 2)


class CycleCount(NamedTuple):
    """The counts of all cycles, of those that were complete and of those that never ended, and of captures."""

    cycles: int
    complete: int
    never_ended: int
    captures: int


def add_counts(counts: Sequence[CycleCount]) -> CycleCount:
    """Add counts of cycles."""
    return CycleCount(*(sum(column) for column in zip(*counts, strict=True)))


def make_lossy_fate(seed: int) -> Fate:
    """Make the fate of the messages of a network that loses and delays them at random."""
    draws = Random(seed)
    return lambda sender, receiver, step: [] if draws.random() < LOSS else [draws.choice(TICKS_LATE)]


def make_agents(libraries: Libraries, world: World, fate: Fate = deliver_at_once) -> LocalTeam:
    """Make the agents of a taught patrol in a world; any of them may lead."""
    tree = assign_team_members(world.scenario)
    plan = TeamPlan(
        tree,
        libraries,
        {practice.SQUAD: (BEHAVIOR, {}), practice.ROBOT: (ALONE, {})},
        readings=dict.fromkeys(tree.types, world.readings),
        targets=world.targets,
        deputies=lambda members: members,
    )
    return LocalTeam(world, plan, LocalNetwork(fate))


def watch_agents(team: LocalTeam, world: World, ticks: int) -> PatrolTracks:
    """Run agents in one world for a number of ticks, and record it, except for what they see."""

    def tick() -> tuple[NDArray[np.int8], Percept]:
        team.tick()
        return np.array([[_find_ordered(robot) for robot in team.robots.values()]], np.int8), {}

    return record_tracks(world, ticks, tick, squad=np.zeros(world.robots, np.intp))


def _find_ordered(robot: Agent) -> int:
    follower = robot.follower
    return find_activity(None if follower is None or follower.order is None else follower.duty)


def count_cycles(seed: int, loses: bool, worlds: int = WORLDS, ticks: int = TICKS) -> CycleCount:
    """Teach a patrol, let its agents patrol in unseen worlds, and count their cycles."""
    libraries, counts = teach(seed).libraries, []
    for number in worlds_of(seed)[:worlds]:
        world = World(practice.scenario(), [number])
        team = make_agents(libraries, world, make_lossy_fate(number) if loses else deliver_at_once)
        cycles = metrics.count_cycles(watch_agents(team, world, ticks))
        never_ended = cycles["cycle_s"].count(None)
        counts.append(CycleCount(cycles["cycles"], cycles["complete"], never_ended, cycles["captures"]))
    return add_counts(counts)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print how many cycles agents complete, for each teaching and network."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--worlds",
        type=int,
        default=WORLDS,
        choices=range(1, WORLDS + 1),
        metavar="N",
        help="for each teaching",
    )
    worlds = parser.parse_args(arguments).worlds
    networks = {"no loss": False, f"{LOSS:.0%} loss": True}
    with ProcessPoolExecutor() as pool:
        runs = {
            name: [pool.submit(count_cycles, seed, loses, worlds) for seed in SEEDS]
            for name, loses in networks.items()
        }
        for name, each in runs.items():
            counts = [run.result() for run in each]
            of_each = ", ".join(f"{one.complete} of {one.cycles}" for one in counts)
            sys.stdout.write(f"{name}: {of_each}\n    {add_counts(counts)}\n")


if __name__ == "__main__":
    main()
