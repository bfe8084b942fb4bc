"""What the worlds of the repertoire have in common: the rover, and turning by hand."""

from __future__ import annotations

from math import pi, radians, tau

import numpy as np

from understudy.model.kinds import YES, Column
from understudy.sim.scenario.schema import Camera, Locator, RobotType, Sonar
from understudy.training.session_view import Screen
from understudy_lab.behavior_suite.tracks import Yes
from understudy_lab.teachers.person import Wish

TICK_S, SPEED, TURNING_DEG, RADIUS = 0.1, 0.5, 70.0, 0.2
MOVES = {
    "forward": {"drive": 1.0},
    "backward": {"drive": -1.0},
    "rotate_left": {"turn": 1.0},
    "rotate_right": {"turn": -1.0},
    "veer_left": {"drive": 0.8, "turn": 0.6},
    "veer_right": {"drive": 0.8, "turn": -0.6},
    "wait": {"drive": 0.0},
}
SONAR = Sonar(
    sectors={"sonar_left": (30.0, 120.0), "sonar_ahead": (-30.0, 30.0), "sonar_right": (-120.0, -30.0)},
    range=2.0,
    noise=0.01,
)
LOCATOR = Locator()
CAMERA = Camera(range=3.0, noise_x=1.0)


def rover(*moves: str, sensor: Sonar | Locator | Camera = LOCATOR, team: str | None = None) -> RobotType:
    """A rover with one sensor, and some of the moves."""
    return RobotType(
        radius=RADIUS,
        speed=SPEED,
        turning_deg=TURNING_DEG,
        noise_drive=0.02,
        noise_turn=0.02,
        team=team,
        sensors=(sensor,),
        behaviors={name: MOVES[name] for name in moves},
    )


def bearing(screen: Screen, of: str = "A") -> float:
    """Signed bearing of a target on the screen, left positive, rad."""
    return (screen.features[f"angle_to({of})"] + pi) % tau - pi


def by_turns(first: str, second: str) -> Wish:
    """One, and when that is done the other, over and over."""

    def wish(screen: Screen) -> str | None:
        if screen.state == "start":
            return first
        if screen.features["done"] != YES:
            return None
        return second if screen.state == first else first

    return wish


class Turning:
    """Turns until it faces something to half a tick's turn, then not before it is off by more than `astray` (rad)."""

    facing = 0.55 * radians(TURNING_DEG) * TICK_S

    def __init__(self, agents: int, *, astray: float = 0.2) -> None:
        self._astray = astray
        self._turn = np.zeros(agents)

    def toward(self, off: Column, go: Yes) -> Column:
        """Which way to turn now [N], where it is to `go`: 1 left, -1 right, 0 not."""
        off = np.where(go, off, 0.0)
        keep_on = (self._turn != 0.0) & (np.abs(off) > self.facing)
        begin = (self._turn == 0.0) & (np.abs(off) > self._astray)
        self._turn = np.where(begin, np.sign(off), np.where(keep_on, self._turn, 0.0))
        return self._turn
