"""The speed of scenarios as environments of Gymnasium and PettingZoo, beside environments of others.

All are driven by the same loop: random actions drawn beforehand, one call of `step` per tick, and a reset when an
episode has ended. Agents of other programs sense and do other things, so their speeds only show the order of magnitude.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from understudy_lab.bench import standard_task
from understudy_lab.bench.harness import BenchCase, BenchGoal, PeerMissing, Row, measure, result, speed
from understudy_lab.bench.vmas_case import VmasBase

ROBOTS, ACTIONS, ROUNDS = 100, 64, 7
SINGLE, PARALLEL = "Gymnasium: one robot", "PettingZoo: 100 robots"
PURSUIT, VMAS = "PettingZoo: its pursuit", "VMAS: one world"


class SingleEnvironment:
    """The foraging robot as a Gymnasium environment."""

    robots = 1

    def __init__(self) -> None:
        adapter = _import("understudy.addons.bridges.environments.gymnasium", "Gymnasium")
        self.environment = adapter.ScenarioEnv("forage")
        count = int(self.environment.action_space.n)
        self.actions = np.random.default_rng(0).integers(count, size=ACTIONS).tolist()

    def reset(self) -> None:
        """Restore the start."""
        self.environment.reset(seed=0)

    def run(self, ticks: int) -> None:
        """Run the given number of ticks."""
        step, actions = self.environment.step, self.actions
        for tick in range(ticks):
            _, _, terminated, truncated, _ = step(actions[tick % ACTIONS])
            if terminated or truncated:
                self.environment.reset()


class ParallelEnvironment:
    """A parallel environment of PettingZoo with 100 agents, all with the same actions."""

    robots = ROBOTS

    def __init__(self, make: Callable[[], Any]) -> None:
        self.environment = make()
        self.reset()
        agents = list(self.environment.agents)
        count = int(self.environment.action_space(agents[0]).n)
        drawn = np.random.default_rng(0).integers(count, size=(ACTIONS, len(agents))).tolist()
        self.actions = [dict(zip(agents, row, strict=True)) for row in drawn]

    def reset(self) -> None:
        """Restore the start."""
        self.environment.reset(seed=0)

    def run(self, ticks: int) -> None:
        """Run the given number of ticks."""
        environment = self.environment
        for tick in range(ticks):
            if not environment.agents:
                environment.reset()
            environment.step(self.actions[tick % ACTIONS])


def _import(module: str, peer: str) -> Any:
    try:
        return import_module(module)
    except ImportError as error:
        raise PeerMissing(peer=peer, extra="pettingzoo") from error


def _make_parallel() -> Any:
    adapter = _import("understudy.addons.bridges.environments.pettingzoo", "PettingZoo")
    return adapter.ScenarioParallelEnv(standard_task.make_base_scenario(ROBOTS))


def _make_pursuit() -> Any:
    pursuit = _import("pettingzoo.sisl.pursuit_v5", "PettingZoo's pursuit")
    return pursuit.parallel_env(n_pursuers=ROBOTS, n_evaders=30, x_size=20, y_size=20, max_cycles=500)


def cases() -> list[BenchCase]:
    """Return the cases, each on one thread."""
    return [
        BenchCase(SINGLE, SingleEnvironment, 1, 10_000),
        BenchCase(PARALLEL, partial(ParallelEnvironment, _make_parallel), 1, 2_000),
        BenchCase(PURSUIT, partial(ParallelEnvironment, _make_pursuit), 1, 5),
        BenchCase(VMAS, partial(VmasBase, ROBOTS, worlds=1, threads=1), 1, 20),
    ]


GOALS = (
    BenchGoal("one robot: steps/s", lambda rows: speed(rows, SINGLE, 1), least=20_000),
    BenchGoal("100 robots: agent steps/s", lambda rows: speed(rows, PARALLEL, ROBOTS), least=500_000),
)


def run(*, rounds: int = ROUNDS) -> Row:
    """Measure all cases, and compare them with the goals."""
    return result(measure(cases(), rounds=rounds), GOALS)
