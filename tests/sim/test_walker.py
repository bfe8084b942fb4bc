"""Walking robots: the laws of worlds, and what a gait does, in numbers that can be checked by hand."""

from __future__ import annotations

from collections.abc import Callable
from math import degrees, dist, radians, tau

import numpy as np
import pytest

from understudy.errors import FileError, SettingError
from understudy.sim.walker import Gait
from understudy.testing import check_world
from understudy_lab.tasks.soccer import (
    AHEAD,
    POSITIONS,
    PUSHED_LEFT,
    PUSHED_RIGHT,
    Disturbance,
    Soccer,
    StartPose,
    X,
    approach_by_hand,
)

EVEN = Gait(slip=0.0, veer_deg=0.0, sway_deg=0.0)
FAR = StartPose((2.5, 2.5), (90.0, 90.0))
WALK = {"drive": np.array([1.0])}


def test_the_laws_of_worlds() -> None:
    check_world(Soccer, seeds=(0, 7), ticks=12)


def test_a_command_waits_for_the_next_step() -> None:
    body = Soccer([3], FAR, EVEN)
    body.act({})
    begun = _place(body)
    for _ in range(4):
        body.act(WALK)  # the robot stands, since its step began with standing
    assert _place(body) == begun
    for _ in range(5):
        body.act({})
    assert _place(body) == begun
    body.act(WALK)
    for _ in range(4):
        body.act({})  # and this step leads ahead: 4 of 5 ticks at 0.25 m/s, with 5 % of noise in each
    assert dist(_place(body), begun) == pytest.approx(0.1, rel=0.1)


def test_steps_slip() -> None:
    ways = []
    for slip in (0.0, 0.9):
        body = Soccer(range(20), FAR, Gait(slip=slip, veer_deg=0.0, sway_deg=0.0))
        begun = [_place(body, world) for world in range(20)]
        for _ in range(20):
            body.act({"drive": np.ones(20)})
        ways.append(np.mean([dist(_place(body, world), begun[world]) for world in range(20)]))
    assert ways[1] / ways[0] == pytest.approx(0.55, abs=0.1)


def test_the_picture_sways_while_walking_only() -> None:
    body = Soccer([5], AHEAD, Gait(slip=0.0, veer_deg=0.0, sway_deg=10.0))
    standing = float(body.sense([X])[X][0])
    assert standing == pytest.approx(80.0, abs=5.0)  # the middle, with noise of a pixel
    body.act(WALK)
    aside = []
    for _ in range(10):
        aside.append(float(body.sense([X])[X][0]))
        body.act(WALK)
    assert max(aside) - min(aside) > 30.0  # 138 px to a radian, 10 degrees to each side


@pytest.mark.parametrize(("name", "side"), [("ball left", 1), ("ball not visible", 0), ("ball right", -1)])
def test_positions(name: str, side: int) -> None:
    seen = Soccer(range(6), POSITIONS[name]).sense([X])[X]
    assert np.isnan(seen).all() if side == 0 else (side * (80.0 - seen) > 40.0).all()


@pytest.mark.parametrize("push", [PUSHED_LEFT, PUSHED_RIGHT])
def test_a_push_turns_the_ball_out_of_sight(push: Disturbance) -> None:
    body = Soccer([11], AHEAD)
    before = body.view().robots.heading[0]
    for _ in range(8):
        body.push(0, turned=radians(push.turned_deg) / 8, aside=0.0)
    assert degrees((body.view().robots.heading[0] - before) % tau) == pytest.approx(push.turned_deg % 360.0)
    assert np.isnan(body.sense([X])[X][0])


def test_servoing_by_hand_gets_there_from_anywhere() -> None:
    starts = [*POSITIONS.values(), AHEAD, AHEAD]
    seconds = approach_by_hand(Soccer(range(5), starts), pushes={3: PUSHED_LEFT, 4: PUSHED_RIGHT})
    assert (seconds < 25.0).all()


def test_a_gait_that_is_none_is_refused() -> None:
    with pytest.raises(SettingError, match="slip"):
        Gait(slip=1.5)


DAMAGED: dict[str, Callable[[Soccer], bytes]] = {
    "nothing": lambda body: b"",
    "too short": lambda body: body.snapshot()[:5],
    "without the worlds": lambda body: body.snapshot()[:40],
    "of worlds without walkers": lambda body: body.world.snapshot(),
    "cut off": lambda body: body.snapshot()[:-1],
    "of another gait": lambda body: Soccer([2], gait=Gait(step_s=1.0)).snapshot(),
}


@pytest.mark.parametrize("damage", DAMAGED)
def test_a_snapshot_that_does_not_fit_is_refused_and_changes_nothing(damage: str) -> None:
    body = Soccer([1])
    body.act({"drive": np.ones(1)})
    before = body.snapshot()
    with pytest.raises(FileError, match="snapshot"):
        body.restore(DAMAGED[damage](body))
    assert body.snapshot() == before


def _place(body: Soccer, world: int = 0) -> tuple[float, float]:
    robots = body.view(world).robots
    return float(robots.x[0]), float(robots.y[0])
