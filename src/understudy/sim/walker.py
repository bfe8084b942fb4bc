"""Walking robots: commands wait for the next step, steps slip and veer, and the sensors sway.

`Walker(scenario, seeds)` is a body like `World(scenario, seeds)`, except for how its robots move and where their
sensors look.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import isfinite, pi, radians, tau

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.model.features import Percept, ReadingKey
from understudy.model.value_kinds import Column
from understudy.runtime.body import Commands
from understudy.sim.kernels.angles import compute_cosine_and_sine
from understudy.sim.kernels.rng import draw_uniform_column, make_normal
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World
from understudy.sim.world_wrapper import WorldWrapper

SLIP, VEER = 2**20, 2**20 + 1
"""Stream numbers of random draws, different from those of worlds; VEER uses two."""


@dataclass(frozen=True, slots=True)
class Gait:
    """The gait of a small humanoid of the size and speed in the paper (section 4.2).

    A step takes `step_s`. For a share `both_feet` of it both feet are on the ground and nothing moves: a fifth to a
    quarter in people (Perry 1992) and about the same in robots of this class, which walk at 0.1 to 0.25 m/s with
    steps of 0.25 to 0.5 s (NAO: Gouaillier et al. 2009; DARwIn-OP: Ha et al. 2011). Small feet slip on turf: a random
    share, up to `slip`, of a step's distance and turn is lost, and a step that leads ahead veers by `veer_deg`
    (standard deviation). With each step the trunk, and the camera on it, swings by `sway_deg` to the side of the
    front foot. Slip, veer and sway are chosen to resemble robots at RoboCup, not measured on one robot.
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
"""The gait with default values."""


class Walker(WorldWrapper):
    """A body of the walking robots of B worlds of a scenario, one world per seed; see `World`."""

    snapshot_name = "walker"

    def __init__(self, scenario: Scenario, seeds: Sequence[int] = (0,), gait: Gait = WALKING) -> None:
        super().__init__(World(scenario, seeds))
        self.gait = gait
        self._ticks = max(1, round(gait.step_s / self.tick_s))
        self._still = min(self._ticks - 1, round(gait.both_feet * self._ticks))
        self._rest()

    def reset(self, seeds: Sequence[int]) -> None:
        """Restart all worlds at time 0, laid out by new seeds, one per world."""
        self.world.reset(seeds)
        self._rest()

    def with_seeds(self, seeds: Sequence[int]) -> Walker:
        """Make a body in worlds of the same scenario with other seeds, at time 0."""
        return Walker(self.scenario, seeds, self.gait)

    def _rest(self) -> None:
        """Make all robots stand."""
        self._step = np.zeros((self.agents, len(self.channels)))

    def place(self, agent: int, x: float, y: float, heading: float) -> None:
        """Move a robot to a free place (x, y in m, heading in rad); it continues its step there."""
        self.world.place(agent, x, y, heading)

    def push(self, agent: int, *, turned: float, aside: float) -> None:
        """Turn a robot by `turned` (rad, left positive) and move it to its left by `aside` (m).

        SettingError if the new place is not free.
        """
        robot = self.world.state.robots[agent]
        heading = float(robot["heading"])
        cosine, sine = compute_cosine_and_sine(heading)
        x, y = float(robot["x"]) - aside * sine, float(robot["y"]) + aside * cosine
        self.world.place(agent, x, y, heading + turned)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return a column [B*N] for each key, measured with the trunk turned by its sway; NaN where absent."""
        heading = self.world.state.robots["heading"]
        before = heading.copy()
        heading[:] = (before + self._swayed()) % tau % tau
        try:
            return self.world.sense(keys)
        finally:
            heading[:] = before

    def act(self, commands: Commands) -> None:
        """Advance by one tick; commands take effect only where a step begins, and then for that whole step."""
        table = self.world.check_commands(commands)[:, self.world.columns]
        if self._in_step == 0:
            self._step = self._taken(table)
        moves = self._step.copy()
        if self._in_step < self._still:
            moves[:, :2] = 0.0  # both feet on the ground
        self.world.act({each.name: moves[:, k] for k, each in enumerate(self.channels)})

    def _taken(self, commands: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the motion that results from a step with these commands, with slip and veer."""
        step = commands.copy()
        share = 1.0 - self.gait.slip * self._drawn(SLIP)
        pairs = zip(self._drawn(VEER).tolist(), self._drawn(VEER + 1).tolist(), strict=True)
        normal = np.array([make_normal(*pair, self.world.rules.generator) for pair in pairs])
        veer = radians(self.gait.veer_deg) * normal
        step[:, :2] *= share[:, None]
        robots = self.world.state.robots["type"]
        turning = self.world.rules.types["turning"][robots] * (self._ticks - self._still)
        ahead = np.minimum(1.0, np.abs(commands[:, 0]))
        step[:, 1] += np.divide(ahead * veer, turning, out=np.zeros(self.agents), where=turning > 0)
        return step

    def _drawn(self, stream: int) -> Column:
        """Return a random number in [0, 1) for each robot's step [B*N]."""
        seeds, tick = self.world.state.seeds, int(self.world.state.tick[0])
        drawn = [
            draw_uniform_column(seeds, item=robot, tick=tick, stream=stream) for robot in range(self.robots)
        ]
        return np.stack(drawn, axis=1).ravel()

    @property
    def _in_step(self) -> int:
        """The number of ticks of the present step that have passed."""
        return int(self.world.state.tick[0]) % self._ticks

    def _swayed(self) -> Column:
        """Return the turn of each trunk by the sway [B*N], rad; it is largest while both feet are on the ground."""
        phase, _ = compute_cosine_and_sine(pi * int(self.world.state.tick[0]) / self._ticks)
        walks = np.any(self._step[:, :2] != 0.0, axis=1)
        swayed: Column = np.where(walks, radians(self.gait.sway_deg) * phase, 0.0)
        return swayed

    def _settings(self) -> dict[str, float]:
        return asdict(self.gait)

    def _arrays(self) -> dict[str, NDArray[np.float64]]:
        return {"step": self._step}

    def restore(self, snapshot: bytes) -> None:
        """Set the state to that of a snapshot, bit for bit; FileError if it was taken of other walkers."""
        self._step = self._restore_worlds(snapshot)["step"]
