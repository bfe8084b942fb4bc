"""The paper's humanoid and its ball on a pillar (section 4.2): three start positions, and pushes on the way.

It is the built-in scenario `soccer` with a walking robot and with the ball in the middle of the field.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import cos, radians, sin, tau
from types import MappingProxyType

import msgspec
import numpy as np

from understudy.model.features import Percept, ReadingKey
from understudy.model.value_kinds import Column
from understudy.runtime.body import Commands
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import Program
from understudy.sim.kernels.rng import draw_uniform_column
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.walker import WALKING, Gait, Walker

NAME = "soccer"
METERS, AROUND, BEARING = 2**20 + 8, 2**20 + 9, 2**20 + 10
"""The random streams for start distance, direction around the ball, and bearing."""
X, SIZE = ("blob_x", "ball"), ("blob_size", "ball")
MIDDLE_PX = 80.0
"""The x of the middle of the frame, straight ahead of the robot."""


def scenario() -> Scenario:
    """Return the scenario with the ball in the middle of the field, so that a robot can start anywhere around it."""
    field = load_scenario(NAME)
    (ball,) = field.objects
    width, height = field.size
    ball = msgspec.structs.replace(ball, at=((width / 2, height / 2),), apart=0.0)
    return msgspec.structs.replace(field, objects=(ball,))


kit = make_scenario_kit(scenario())


@dataclass(frozen=True, slots=True)
class StartPose:
    """A start pose: distance from the ball (m, center to center) and bearing of the ball (degrees, left positive).

    Both are drawn from (least, most) for each world, and so is the direction from the ball to the robot.
    """

    meters: tuple[float, float]
    bearing_deg: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Disturbance:
    """A push: from `after_s` on, the robot is turned and moved aside at a constant rate for `lasts_s`.

    `turned_deg` is positive for a turn to the left, and `aside_m` is positive for a move to the left.
    """

    after_s: float
    lasts_s: float
    turned_deg: float
    aside_m: float


POSITIONS: Mapping[str, StartPose] = MappingProxyType(
    {
        "ball left": StartPose((2.0, 2.0), (22.0, 22.0)),
        "ball not visible": StartPose((2.0, 2.0), (180.0, 180.0)),
        "ball right": StartPose((2.0, 2.0), (-22.0, -22.0)),
    }
)
"""The paper's three start poses: ball in the left of the frame, not visible, in the right of the frame (Figure 3)."""

AHEAD = StartPose((2.2, 2.2), (0.0, 0.0))
"""The start pose of trials with a push."""
PUSHED_LEFT, PUSHED_RIGHT = Disturbance(2.0, 0.8, 70.0, 0.2), Disturbance(2.0, 0.8, -70.0, -0.2)
ANYWHERE = StartPose((1.2, 2.6), (-180.0, 180.0))
NO_PUSHES: Mapping[int, Disturbance] = MappingProxyType({})
LIMIT_S = 120.0
"""The time limit for reaching the ball, s, as in the scenario."""


class Soccer(Walker):
    """Walking robots, each alone in a world with the ball; `starts` is the start pose of each world, or one for all."""

    def __init__(
        self,
        seeds: Sequence[int] = (0,),
        starts: StartPose | Sequence[StartPose] = ANYWHERE,
        gait: Gait = WALKING,
    ) -> None:
        self.starts = [starts] * len(seeds) if isinstance(starts, StartPose) else list(starts)
        super().__init__(scenario(), seeds, gait)
        self._begin()

    def reset(self, seeds: Sequence[int]) -> None:
        """Restart all worlds, one per seed."""
        super().reset(seeds)
        self._begin()

    def with_seeds(self, seeds: Sequence[int]) -> Soccer:
        """Make a body in worlds with other seeds, all of which start like the first one of this body."""
        return Soccer(seeds, self.starts[0], self.gait)

    def _begin(self) -> None:
        """Place each robot at its start pose."""
        seeds = np.asarray(self.seeds, np.int64)
        streams = (METERS, AROUND, BEARING)
        drawn = np.stack(
            [draw_uniform_column(seeds, item=0, tick=0, stream=stream) for stream in streams], axis=1
        )
        for world, (start, (far, around, seen)) in enumerate(zip(self.starts, drawn.tolist(), strict=True)):
            ball = self.view(world).objects
            meters, bearing = _between(start.meters, far), radians(_between(start.bearing_deg, seen))
            x, y = (
                float(ball.x[0]) - meters * cos(tau * around),
                float(ball.y[0]) - meters * sin(tau * around),
            )
            self.place(world, x, y, tau * around - bearing)


def _between(bounds: tuple[float, float], share: float) -> float:
    return bounds[0] + (bounds[1] - bounds[0]) * share


class ExpertServo:
    """A hand-written visual servo for N robots that stores on which side the ball was last seen and turns to that side.

    It turns until the ball is at most `facing_px` from the middle of the frame, and walks until it is more than
    `astray_px` from it.
    """

    keys: Sequence[ReadingKey] = (X, SIZE)

    def __init__(self, agents: int, *, facing_px: float = 40.0, astray_px: float = 55.0) -> None:
        self._facing, self._astray = facing_px, astray_px
        self._side = np.ones(agents)  # 1 left, -1 right
        self._walking = np.zeros(agents, np.bool_)

    def decide(self, percept: Percept) -> Commands:
        """Return the commands of all robots for this tick."""
        off = MIDDLE_PX - percept[X]
        seen = ~np.isnan(off)
        self._side = np.where(seen & (off != 0.0), np.sign(off), self._side)
        self._walking = seen & (np.abs(off) <= np.where(self._walking, self._astray, self._facing))
        return {"drive": self._walking.astype(np.float64), "turn": np.where(self._walking, 0.0, self._side)}


def approach(
    body: Soccer,
    tick: Callable[[], None],
    *,
    pushes: Mapping[int, Disturbance] = NO_PUSHES,
    limit_s: float = LIMIT_S,
) -> Column:
    """Call `tick` until all robots are within 15 cm of the ball or the time limit is over, and return their times.

    The times are in s [B], NaN where the limit came first. `pushes` maps the index of a world to the push of its robot.
    """
    while np.isnan(body.finished_s).any() and body.time_s < limit_s - body.tick_s / 2:
        for world, push in pushes.items():
            ticks = round(push.lasts_s / body.tick_s)
            if 0 <= round((body.time_s - push.after_s) / body.tick_s) < ticks:
                body.push(world, turned=radians(push.turned_deg) / ticks, aside=push.aside_m / ticks)
        tick()
    return body.finished_s


def approach_by(
    program: Program, body: Soccer, *, pushes: Mapping[int, Disturbance] = NO_PUSHES, limit_s: float = LIMIT_S
) -> Column:
    """Run `approach` with robots that all execute one program."""
    return approach(body, Engine.from_program(body, program).tick, pushes=pushes, limit_s=limit_s)


def approach_by_hand(
    body: Soccer, *, pushes: Mapping[int, Disturbance] = NO_PUSHES, limit_s: float = LIMIT_S
) -> Column:
    """Run `approach` with the hand-written controller."""
    hand = ExpertServo(body.agents)
    return approach(
        body, lambda: body.act(hand.decide(body.sense(hand.keys))), pushes=pushes, limit_s=limit_s
    )
