"""The laws catch what breaks them: a liar per law, and the law it is caught by."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from understudy.errors import UnderstudyError
from understudy.model.behaviors import Behavior, Command, behavior
from understudy.model.features import Feature, FlagFeature, Percept, ReadingKey, feature
from understudy.model.value_kinds import BOOLEAN, Column, Continuous, Toroidal
from understudy.runtime.body import Channel, Commands, Reading
from understudy.sim.forage import Forage
from understudy.testing import LawBroken, check_behavior, check_body, check_feature, check_world

CALLS: list[int] = []


@feature(Continuous(), unit="m")
def half_way(_: Any, target: Any) -> Column:
    """Half the way to the target."""
    return np.asarray(target.range / 2)


@feature(Toroidal())
def leave_unwrapped(_: Any, target: Any) -> Column:
    return np.asarray(target.bearing + 7.0)


@feature(BOOLEAN)
def two(robot: Any) -> Column:
    return np.asarray(robot.food_stored + 2.0)


@feature(Continuous())
def infinite(robot: Any) -> Column:
    return np.asarray(robot.food_left / 0.0)


@feature(Continuous())
def whole_numbers(robot: Any) -> Column:
    return np.asarray(robot.food_stored.astype(np.int64))


@feature(Continuous())
def too_short(robot: Any) -> Column:
    return np.asarray(robot.food_stored[1:])


@feature(Continuous())
def writes(robot: Any) -> Column:
    robot.food_stored[:] = 3.0
    return np.asarray(robot.food_stored)


@feature(Continuous())
def counts_calls(robot: Any) -> Column:
    CALLS.append(1)
    return np.asarray(robot.food_stored + len(CALLS))


@feature(Continuous())
def looks_at_others(_: Any, target: Any) -> Column:
    return np.asarray(target.range - target.range.mean())


@feature(Continuous())
def reads_nothing_there(robot: Any) -> Column:
    return np.asarray(robot.sonar)


@feature(Continuous())
def fails_on_few(robot: Any) -> Column:
    return np.asarray(robot.food_stored + float(robot.food_stored[1]))


BAD_FEATURES = [
    (reads_nothing_there, "it failed: AttributeError: the body has no reading 'sonar'"),
    (fails_on_few, "it failed: IndexError: index 1 is out of bounds"),
    (Feature("gives_nothing", Continuous(), function=lambda robot: None), "one column of floats"),  # type: ignore[arg-type, return-value]
    (leave_unwrapped, "its values are toroidal"),
    (two, "its values are categorical"),
    (infinite, "its values are continuous"),
    (whole_numbers, "one column of floats"),
    (too_short, "one column of floats"),
    (writes, "untouched"),
    (counts_calls, "the same readings give the same values"),
    (looks_at_others, "each agent's value is its own"),
    (Feature("no_sonar", Continuous(), "sonar"), "reads what the body offers"),
]


def test_good_features_pass() -> None:
    check_feature(half_way, Forage([1, 2]))
    check_feature(FlagFeature("done"), Forage([1, 2]))


@pytest.mark.filterwarnings("ignore:divide by zero")
@pytest.mark.parametrize(("bad", "law"), BAD_FEATURES)
def test_bad_feature(bad: Feature, law: str) -> None:
    with pytest.raises(LawBroken, match=law) as raised:
        check_feature(bad, Forage([1, 2, 3]))
    assert bad.name in raised.value.part


@behavior
def approach(_: Any, target: Any) -> dict[str, Column]:
    """Turn toward the target while driving."""
    return {"turn": np.nan_to_num(np.sin(target.bearing)), "drive": np.ones_like(target.bearing)}


@behavior
def flies(robot: Any) -> dict[str, Column]:
    return {"fly": robot.food_stored}


@behavior
def drives_nan(_: Any) -> dict[str, Column]:
    return {"drive": np.full(len(_.food_stored), np.nan)}


@behavior
def drives_toward_nothing(robot: Any) -> dict[str, Column]:
    return {"drive": robot.sonar}


@behavior
def gives_nothing(_: Any) -> dict[str, Column]:
    return None  # type: ignore[return-value]


BAD_BEHAVIORS = [
    (drives_toward_nothing, "it failed: AttributeError: the body has no reading 'sonar'"),
    (gives_nothing, "it returns a column for each channel; it returned None"),
    (flies, "commands channels of the body"),
    (Behavior("fly", Command(fly=1.0)), "commands channels of the body"),
    (drives_nan, "commands are finite"),
]


def test_good_behavior_passes() -> None:
    check_behavior(approach, Forage([1, 2]))


@pytest.mark.parametrize(("bad", "law"), BAD_BEHAVIORS)
def test_bad_behavior(bad: Behavior, law: str) -> None:
    with pytest.raises(LawBroken, match=law):
        check_behavior(bad, Forage([1, 2]))


def test_checks_put_the_body_back() -> None:
    world = Forage([1, 2])
    before = world.snapshot()
    check_feature(half_way, world)
    check_behavior(approach, world)
    check_body(world)
    assert world.snapshot() == before


class Shared(Forage):
    """Hands out its own column."""

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        percept = dict(super().sense(keys))
        if ("range", "nearest_food") in percept:
            percept["range", "nearest_food"] = self.state.robots["x"]
        return percept


class Noisy(Forage):
    """Draws anew each time it senses."""

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        CALLS.append(1)
        return {
            key: column + (len(CALLS) if key[0] == "range" else 0)
            for key, column in super().sense(keys).items()
        }


class Careless(Forage):
    """Takes any command."""

    def act(self, commands: Commands) -> None:
        super().act({name: column for name, column in commands.items() if name != "no_such_thing"})


class Writing(Forage):
    """Cuts commands off in place."""

    def act(self, commands: Commands) -> None:
        super().act(commands)
        for column in commands.values():
            np.clip(column, -0.1, 0.1, out=column)


class Forgetful(Forage):
    """Leaves the clock out of its snapshots."""

    def restore(self, snapshot: bytes) -> None:
        tick = self.state.tick
        super().restore(snapshot)
        self.state.tick[:] = tick


class Coupled(Forage):
    """Moves all its worlds the first one's way."""

    def act(self, commands: Commands) -> None:
        super().act(commands)
        self.state.robots["heading"] = self.state.robots["heading"][0]


class Lost(Forage):
    """Raises what nobody can act on."""

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        if ("no_such_thing", None) in keys:
            raise KeyError("no_such_thing")
        return super().sense(keys)


class Lucky(Forage):
    """Begins otherwise each time."""

    def reset(self, seeds: Sequence[int]) -> None:
        CALLS.append(1)
        super().reset([seed + len(CALLS) for seed in seeds])


BAD_WORLDS: list[tuple[Callable[[Sequence[int]], Forage], str]] = [
    (Shared, "does not reach the body"),
    (Noisy, "sensing twice gives the same"),
    (Careless, "it took channel 'no_such_thing'"),
    (Writing, "leaves the commands it is given untouched"),
    (Forgetful, "restoring a snapshot goes back"),
    (Coupled, "runs alone as it does among others"),
    (Lost, "refuses with an UnderstudyError"),
    (Lucky, "the same seeds give the same run"),
]


@pytest.mark.parametrize(("bad", "law"), BAD_WORLDS)
def test_bad_world(bad: Callable[[Sequence[int]], Forage], law: str) -> None:
    with pytest.raises(LawBroken, match=law) as raised:
        check_world(bad)
    assert isinstance(raised.value, UnderstudyError)
    assert raised.value.part.startswith(("world ", "body "))


class Bare:
    """A body of somebody who has not read on."""

    agents, tick_s, time_s = 1, 0.1, 0.0
    channels = (Channel("drive"),)
    readings = (Reading("speed", Continuous()),)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        return {key: np.zeros(1) for key in keys}

    def act(self, commands: Commands) -> None:
        pass


def test_a_body_that_lacks_a_part() -> None:
    body: Any = Bare()
    law = "body Bare breaks a law: .*targets.*; it has no targets"
    checks: list[Callable[[], None]] = [
        lambda: check_body(body),
        lambda: check_feature(half_way, body),
        lambda: check_behavior(approach, body),
        lambda: check_world(lambda seeds: body),
    ]
    for check in checks:
        with pytest.raises(LawBroken, match=law):
            check()
