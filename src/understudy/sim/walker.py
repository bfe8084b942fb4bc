"""Robots that walk instead of rolling: commands wait for the next step, steps slip and veer, the picture sways.

A world of any scenario becomes one of walking robots: `Walker(scenario, seeds)` is the same body, but for how its
robots move and from where their sensors look.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import cos, isfinite, pi, radians, tau

import numpy as np
from numpy.typing import NDArray

from understudy.errors import FileError, SettingError
from understudy.model.features import Percept, ReadingKey
from understudy.model.kinds import Column
from understudy.runtime.body import Commands
from understudy.sim import state
from understudy.sim.layout.rng import draw_uniform_column
from understudy.sim.scenario.schema import Scenario
from understudy.sim.view import WorldView
from understudy.sim.world import World

SLIP, VEER = 2**20, 2**20 + 1
"""Streams of random draws, far from those of worlds; veering takes two."""
HEAD = 8
"""Bytes that say how long a walker's own part of a snapshot is."""


@dataclass(frozen=True, slots=True)
class Gait:
    """How a small humanoid walks, at the size and speed of the paper's (section 4.2).

    A step takes `step_s`. For a share `both_feet` of it both feet are on the ground and nothing moves: a fifth to a
    quarter in people (Perry 1992) and much the same in robots of this class, which walk at 0.1 to 0.25 m/s with steps
    of 0.25 to 0.5 s (NAO: Gouaillier et al. 2009; DARwIn-OP: Ha et al. 2011). Small feet slip on turf: up to a share
    `slip` of a step's way and turn is lost, and a step that leads ahead veers by `veer_deg` (standard deviation). With
    each step the trunk, and the camera on it, swings by `sway_deg` to the side of the foot ahead. Slip, veer and sway
    are chosen, at what is seen at RoboCup, not measured on one robot.
    """

    step_s: float = 0.5
    both_feet: float = 0.2
    slip: float = 0.3
    veer_deg: float = 3.0
    sway_deg: float = 4.0

    def __post_init__(self) -> None:
        for name, most in (
            ("step_s", 10.0),
            ("both_feet", 0.9),
            ("slip", 1.0),
            ("veer_deg", 90.0),
            ("sway_deg", 90.0),
        ):
            value = getattr(self, name)
            if not (isfinite(value) and 0 <= value <= most) or (name == "step_s" and value == 0):
                remedy = f"give a number from 0 to {most}"
                raise SettingError(where="gait", setting=name, problem=f"is {value}", remedy=remedy)


WALKING = Gait()
"""As above."""


class Walker:
    """A body of the walking robots of B worlds of a scenario, one world per seed; see `World`."""

    def __init__(self, scenario: Scenario, seeds: Sequence[int] = (0,), gait: Gait = WALKING) -> None:
        self.world, self.gait = World(scenario, seeds), gait
        world = self.world
        self.scenario, self.kit = scenario, world.kit
        self.agents, self.worlds, self.robots = world.agents, world.worlds, world.robots
        self.readings, self.channels, self.targets = world.readings, world.channels, world.targets
        self.tick_s = world.tick_s
        self._ticks = max(1, round(gait.step_s / self.tick_s))
        self._still = min(self._ticks - 1, round(gait.both_feet * self._ticks))
        self._rest()

    @property
    def time_s(self) -> float:
        """Time since the last reset, s."""
        return self.world.time_s

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seed of each world."""
        return self.world.seeds

    @property
    def finished_s(self) -> Column:
        """When each world reached its goal [B], s; absent where it has not."""
        return self.world.finished_s

    def view(self, world: int = 0) -> WorldView:
        """One world as plain data, for drawing."""
        return self.world.view(world)

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin anew, a world per seed."""
        self.world.reset(seeds)
        self._rest()

    def _rest(self) -> None:
        """All stand."""
        self._step = np.zeros((self.agents, len(self.channels)))

    def place(self, agent: int, x: float, y: float, heading: float) -> None:
        """Put a robot somewhere free; it goes on with its step there."""
        self.world.place(agent, x, y, heading)

    def push(self, agent: int, *, turned: float, aside: float) -> None:
        """Push a robot: turn it (rad, left positive) and move it (m to its left); SettingError where it is not free."""
        robot = self.world.state.robots[agent]
        heading = float(robot["heading"])
        x, y = float(robot["x"]) - aside * np.sin(heading), float(robot["y"]) + aside * np.cos(heading)
        self.world.place(agent, x, y, heading + turned)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """The columns [B*N] of these keys, from where the trunk looks in its sway."""
        heading = self.world.state.robots["heading"]
        before = heading.copy()
        heading[:] = (before + self._swayed()) % tau % tau
        try:
            return self.world.sense(keys)
        finally:
            heading[:] = before

    def act(self, commands: Commands) -> None:
        """Go on for one tick; commands are heard where a step begins, and last for that step."""
        asked = self.world.check_commands(commands)[:, self.world.columns]
        if self._in_step == 0:
            self._step = self._taken(asked)
        moves = self._step.copy()
        if self._in_step < self._still:
            moves[:, :2] = 0.0  # both feet on the ground
        self.world.act({each.name: moves[:, k] for k, each in enumerate(self.channels)})

    def _taken(self, asked: NDArray[np.float64]) -> NDArray[np.float64]:
        """What comes of a step with these commands: less than was asked, and not quite straight."""
        step = asked.copy()
        made = 1.0 - self.gait.slip * self._drawn(SLIP)
        radius = np.sqrt(-2.0 * np.log(1.0 - self._drawn(VEER)))
        veer = radians(self.gait.veer_deg) * radius * np.cos(tau * self._drawn(VEER + 1))
        step[:, :2] *= made[:, None]
        robots = self.world.state.robots["type"]
        turning = self.world.rules.types["turning"][robots] * (self._ticks - self._still)
        ahead = np.minimum(1.0, np.abs(asked[:, 0]))
        step[:, 1] += np.divide(ahead * veer, turning, out=np.zeros(self.agents), where=turning > 0)
        return step

    def _drawn(self, stream: int) -> Column:
        """A number in [0, 1) for the step of each robot [B*N]."""
        seeds, tick = self.world.state.seeds, int(self.world.state.tick[0])
        drawn = [
            draw_uniform_column(seeds, item=robot, tick=tick, stream=stream) for robot in range(self.robots)
        ]
        return np.stack(drawn, axis=1).ravel()

    @property
    def _in_step(self) -> int:
        """How many ticks of the step are over."""
        return int(self.world.state.tick[0]) % self._ticks

    def _swayed(self) -> Column:
        """How far the trunk is turned by the sway [B*N], rad; farthest where both feet are on the ground."""
        phase = cos(pi * int(self.world.state.tick[0]) / self._ticks)
        walks = np.any(self._step[:, :2] != 0.0, axis=1)
        swayed: Column = np.where(walks, radians(self.gait.sway_deg) * phase, 0.0)
        return swayed

    def snapshot(self) -> bytes:
        """The whole state, for `restore`."""
        own = state.encode_snapshot("walker", asdict(self.gait), {"step": self._step})
        return len(own).to_bytes(HEAD, "little") + own + self.world.snapshot()

    def restore(self, snapshot: bytes) -> None:
        """Go back to a snapshot, bit for bit; FileError where it is not one of such walkers."""
        if len(snapshot) < HEAD:
            raise FileError(
                path="snapshot", place="", problem="is not one of walkers", remedy="take it again"
            )
        end = HEAD + int.from_bytes(snapshot[:HEAD], "little")
        own = state.decode_snapshot(snapshot[HEAD:end], "walker", asdict(self.gait), {"step": self._step})
        self.world.restore(snapshot[end:])
        self._step = own["step"]
