"""A module with worlds of one's own, as a user writes one, for the tests of what opens them: MODULE:NAME."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import pettingzoo

from understudy import Behavior, Channel, Command, Continuous, Feature, Kit, Reading
from understudy.addons.bridges.environments.gymnasium import GymnasiumBody
from understudy.model.features import Percept, ReadingKey
from understudy.runtime.body import Commands
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Scenario

NAME = "tests.own_worlds"


class Slope:
    """One cart on a slope of 10 m, which ends there; it is drawn as a white column on black. It cannot be reset."""

    readings = (Reading("x", Continuous(), "m"),)
    channels = (Channel("drive", unit="m/s"),)
    targets = ()
    tick_s = 0.5
    agents = 1

    def __init__(self, x: float) -> None:
        self.x = np.array([x])
        self.ticks = 0

    @property
    def time_s(self) -> float:
        return self.ticks * self.tick_s

    @property
    def is_over(self) -> np.ndarray[Any, Any]:
        return self.x >= 10.0

    @property
    def kit(self) -> Kit:
        return Kit.from_parts(
            Feature("x", Continuous(), "x", unit="m"),
            Behavior("ahead", Command(drive=1.0)),
            Behavior("back", Command(drive=-1.0)),
        )

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        return {key: self.x.copy() for key in keys}

    def act(self, commands: Commands) -> None:
        self.x = self.x + self.tick_s * commands.get("drive", np.zeros(1))
        self.ticks += 1

    def render(self) -> np.ndarray[Any, Any] | None:
        picture = np.zeros((4, 12, 3), np.uint8)
        picture[:, int(self.x[0].clip(0, 11))] = 255
        return picture


class BrokenSlope(Slope):
    def render(self) -> np.ndarray[Any, Any]:
        return np.zeros((4, 12))


class FailingSlope(Slope):
    def render(self) -> np.ndarray[Any, Any]:
        raise RuntimeError("no paint")


class PlainSlope(Slope):
    render = None  # type: ignore[assignment]


class BareSlope(Slope):
    kit = None  # type: ignore[assignment]


class SlipperySlope(Slope):
    """A cart that begins at 2 m and, if the seed can be divided by 4, slips: it stands still."""

    def __init__(self, seed: int) -> None:
        super().__init__(2.0)
        self.slips = seed % 4 == 0

    def act(self, commands: Commands) -> None:
        super().act({} if self.slips else commands)


class BreakingSlope(Slope):
    def act(self, commands: Commands) -> None:
        raise RuntimeError("a wheel is off")


class HalfSlope:
    agents = 1
    readings = Slope.readings


class TextEnvironment(gymnasium.Env[Any, Any]):
    observation_space = gymnasium.spaces.Text(5)
    action_space = gymnasium.spaces.Discrete(2)


def make_slope(seed: int) -> Slope:
    """The seed is the place where it begins, in m."""
    return Slope(float(seed))


def make_broken(seed: int) -> Slope:
    return BrokenSlope(seed)


def make_failing(seed: int) -> Slope:
    return FailingSlope(seed)


def make_slippery(seed: int) -> Slope:
    return SlipperySlope(seed)


def make_breaking(seed: int) -> Slope:
    return BreakingSlope(2.0)


def make_plain(seed: int) -> Slope:
    return PlainSlope(seed)


def make_bare(seed: int) -> Slope:
    return BareSlope(seed)


def make_half(seed: int) -> HalfSlope:
    return HalfSlope()


def make_cart() -> gymnasium.Env[Any, Any]:
    return gymnasium.make("CartPole-v1")


def make_pursuit() -> Any:
    return pettingzoo.make("parallel", "sisl/pursuit-v5", n_pursuers=3, n_evaders=4, render_mode="rgb_array")


def make_carts() -> GymnasiumBody:
    return GymnasiumBody("CartPole-v1", [1, 2])


def make_text() -> TextEnvironment:
    return TextEnvironment()


def make_scenario() -> Scenario:
    return load_scenario("forage")


def make_number(seed: int) -> int:
    return seed


def make_of_two(seed: int, size: int) -> int:
    return seed + size


def fail() -> None:
    raise RuntimeError("no slope today")
