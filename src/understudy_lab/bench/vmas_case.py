"""The base task in VMAS: parallel worlds as PyTorch batches, stepped through `Environment.step`.

It is optimized as far as VMAS allows: the observations of all agents are computed in one batch (at the first agent's
observation) and returned as views; beacons are one tensor rather than entities, because VMAS loops over all pairs of
entities each tick; the policy decides for all agents at once; robots do not collide. Drag removes all speed each tick,
so that forces move a robot as in the standard task. VMAS computes in single precision.
"""

from __future__ import annotations

from importlib import import_module
from math import pi
from typing import Any

import numpy as np

from understudy.model.value_kinds import TAU
from understudy_lab.bench import standard_task
from understudy_lab.bench.harness import PeerMissing
from understudy_lab.bench.standard_task import AHEAD, ARRIVED, PERSONAL, Column


class VmasBase:
    """Parallel worlds with the same number of robots, in one VMAS environment."""

    def __init__(self, robots_each: int, *, worlds: int, threads: int) -> None:
        self.robots, self.threads = robots_each * worlds, threads
        self._torch, scenario = _parts(robots_each)
        self._torch.set_num_threads(threads)
        self.scenario = scenario()
        environment = import_module("vmas").make_env
        self.environment = environment(scenario=self.scenario, num_envs=worlds, device="cpu")
        self.reset()

    def reset(self, seed: int = 0) -> None:
        """Restore the start."""
        self.scenario.start_seed = seed
        self.seen = self._torch.stack(self.environment.reset(), dim=1)

    def run(self, ticks: int) -> None:
        """Run the given number of ticks."""
        torch = self._torch
        torch.set_num_threads(self.threads)
        with torch.no_grad():
            for _ in range(ticks):
                actions = list(self._decide(self.seen).unbind(1))
                observations, _, _, _ = self.environment.step(actions)
                self.seen = torch.stack(observations, dim=1)

    def _decide(self, seen: Any) -> Any:
        """Return force along x and y, and torque, relative to their ranges [worlds, robots, 3]."""
        torch = self._torch
        beacon, angle, robot, bearing, heading = seen.unbind(-1)
        blocked = (robot < PERSONAL) & ((bearing < pi / 2) | (bearing >= TAU - pi / 2))
        there = beacon < ARRIVED
        ahead = (angle < AHEAD) | (angle >= TAU - AHEAD)
        drive = (~blocked & ~there & ahead).to(seen.dtype)
        to_left = torch.where(blocked, bearing >= pi, angle < pi)
        turns = blocked | (~there & ~ahead)
        turn = torch.where(turns, to_left.to(seen.dtype) * 2 - 1, 0.0)
        return torch.stack([drive * heading.cos(), drive * heading.sin(), turn], dim=-1)

    @property
    def places(self) -> Column:
        """Return x, y and heading [N, 3]."""
        agents = self.environment.agents
        moved = self._torch.stack([agent.state.pos for agent in agents], dim=1) + self.scenario.half
        heading = self._torch.stack([agent.state.rot for agent in agents], dim=1)
        return np.concatenate([moved.numpy(), heading.numpy() % TAU], axis=-1).reshape(-1, 3).astype(float)

    @property
    def readings(self) -> Column:
        """Return the current range and bearing of the nearest beacon and robot [N, 4]."""
        return self.seen[..., :4].reshape(-1, 4).numpy().astype(float)  # type: ignore[no-any-return]


def _parts(robots_each: int) -> tuple[Any, Any]:
    """Return PyTorch and the scenario's class; both are imported only when needed."""
    try:
        torch = import_module("torch")
        core = import_module("vmas.simulator.core")
        base = import_module("vmas.simulator.scenario").BaseScenario
        motion = import_module("vmas.simulator.dynamics.holonomic_with_rot").HolonomicWithRotation
    except ImportError:
        raise PeerMissing(peer="VMAS with PyTorch", extra="bench-vmas") from None
    side = standard_task.side(robots_each)
    force = standard_task.STEP / standard_task.TICK_S**2
    torque = 0.5 * standard_task.RADIUS**2 * standard_task.TURN / standard_task.TICK_S**2

    class Scenario(base):  # type: ignore[misc, valid-type]
        half = side / 2
        start_seed = 0

        def make_world(self, batch_dim: int, device: Any, **_: Any) -> Any:
            bound = self.half - standard_task.RADIUS
            world = core.World(
                batch_dim, device, dt=standard_task.TICK_S, drag=1.0, x_semidim=bound, y_semidim=bound
            )
            for index in range(robots_each):
                world.add_agent(
                    core.Agent(
                        f"robot_{index}",
                        shape=core.Sphere(standard_task.RADIUS),
                        collide=False,
                        u_range=[1.0, 1.0, 1.0],
                        u_multiplier=[force, force, torque],
                        dynamics=motion(),
                    )
                )
            self.itself = torch.eye(robots_each, dtype=torch.bool)
            self.nothing = torch.zeros(batch_dim)
            return world

        def reset_world_at(self, env_index: int | None = None) -> None:
            """Reset all worlds at once; `env_index` is ignored, because a run resets them together."""
            starts = [
                standard_task.StartLayout.of(robots_each, self.start_seed + world)
                for world in range(self.world.batch_dim)
            ]
            x, y, heading, beacon_x, beacon_y = (
                torch.tensor(np.array([getattr(start, name) for start in starts]), dtype=torch.float32)
                for name in ("x", "y", "heading", "beacon_x", "beacon_y")
            )
            self.beacons = (beacon_x - self.half, beacon_y - self.half)
            for index, agent in enumerate(self.world.agents):
                agent.set_pos(torch.stack([x[:, index], y[:, index]], dim=-1) - self.half, batch_index=None)
                agent.set_rot(heading[:, index : index + 1], batch_index=None)

        def observation(self, agent: Any) -> Any:
            """Return range and bearing of the nearest beacon and of the nearest robot, and the heading."""
            if agent is self.world.agents[0]:
                self.seen = self.readings().unbind(1)
            return self.seen[self.world.agents.index(agent)]

        def readings(self) -> Any:
            x, y = torch.stack([agent.state.pos for agent in self.world.agents], dim=1).unbind(-1)
            heading = torch.cat([agent.state.rot for agent in self.world.agents], dim=1)
            beacon, angle = self.nearest(x, y, heading, *self.beacons)
            robot, bearing = self.nearest(x, y, heading, x, y, without=self.itself)
            robot[robot > standard_task.SIGHT] = torch.nan
            bearing[robot.isnan()] = torch.nan
            # The heading of VMAS is never wrapped.
            return torch.stack([beacon, angle, robot, bearing, heading], dim=-1)

        def nearest(
            self, x: Any, y: Any, heading: Any, to_x: Any, to_y: Any, without: Any = None
        ) -> tuple[Any, Any]:
            """Return range and bearing of the nearest of the given points.

            Coordinates stay apart, because sums over a last dimension of two take several times as long.
            """
            dx, dy = to_x.unsqueeze(1) - x.unsqueeze(2), to_y.unsqueeze(1) - y.unsqueeze(2)
            squared = torch.addcmul(dx * dx, dy, dy)
            if without is not None:
                squared.masked_fill_(without, torch.inf)
            least, which = squared.min(-1, keepdim=True)
            bearing = torch.atan2(dy.gather(2, which), dx.gather(2, which)).squeeze(2)
            return least.sqrt().squeeze(2), (bearing - heading) % TAU

        def reward(self, agent: Any) -> Any:
            return self.nothing

    return torch, Scenario
