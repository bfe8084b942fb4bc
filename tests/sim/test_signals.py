"""Signals and claims, by hand: what is raised in a tick is seen in the next, by whom, and from where."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from understudy.sim.layout import neighbor_grid
from understudy.sim.scenario.schema import (
    ClaimSensor,
    ObjectClass,
    RobotGroup,
    RobotType,
    Scenario,
    TargetLocator,
    TargetSpec,
)
from understudy.sim.target_lookup import find_target_place
from understudy.sim.world import World

TARGETS = {
    "caller": TargetSpec(signal="help"),
    "claimer": TargetSpec(signal="claim"),
    "red caller": TargetSpec(signal="help", team="red"),
    "calling mate": TargetSpec(signal="help", robot="teammate"),
    "calling opponent": TargetSpec(signal="help", robot="opponent"),
    "box": TargetSpec(nearest="box"),
    "second box": TargetSpec(object="box", index=1),
    "free box": TargetSpec(nearest="box", unclaimed="claim", within=1.0),
    "free box far": TargetSpec(nearest="box", unclaimed="claim", within=100.0),
}
SENSORS = (TargetLocator(), ClaimSensor(signal="claim", range=1.0))
BEHAVIORS: dict[str, dict[str, float | str]] = {
    "call": {"signal": "help"},
    "claim": {"drive": 1.0, "signal": "claim"},
}
HELP, CLAIM = 1.0, 2.0
"""Numbered as behaviors name them first."""
RED = RobotType(team="red", sensors=SENSORS, behaviors=BEHAVIORS)
BLUE = RobotType(team="blue", sensors=SENSORS)
BOXES = ObjectClass(name="box", at=((2.0, 5.0), (8.0, 5.0)))


def line(types: str = "rrb") -> World:
    """Robots in a line, 1 m apart from x = 1 on; red ones (r) and blue ones (b)."""
    kinds = {"r": "red", "b": "blue"}
    robots = tuple(RobotGroup(type=kinds[each], at=((1.0 + x, 2.0),)) for x, each in enumerate(types))
    types_ = {"red": RED, "blue": BLUE}
    scenario = Scenario(size=(10.0, 8.0), types=types_, robots=robots, targets=TARGETS, objects=(BOXES,))
    return World(scenario, (0,))


def signal(world: World, *raised: float, ticks: int = 1) -> None:
    for _ in range(ticks):
        world.act({"signal": np.array(raised)})


def read(world: World, name: str, target: str) -> list[Any]:
    column = world.sense([(name, target)])[name, target]
    return [None if value != value else pytest.approx(value) for value in column]


def test_the_kit_says_what_is_raised() -> None:
    world = line()
    kit = world.kit
    assert dict(kit.behaviors["call"].command) == {"signal": HELP}
    assert dict(kit.behaviors["claim"].command) == {"drive": 1.0, "signal": CLAIM}
    assert kit.behaviors["claim"].doc == "Drive ahead, raise claim."
    assert kit.targets["red caller"].doc == "The nearest robot of the team red that raises help."
    assert kit.targets["free box"].doc == "The nearest box that nobody else claims."
    assert [channel.name for channel in world.channels] == ["drive", "turn", "signal"]


def test_a_signal_is_seen_in_the_next_tick_and_as_long_as_it_is_raised() -> None:
    world = line()
    assert read(world, "range", "caller") == [None, None, None]
    signal(world, HELP, 0, 0)
    assert read(world, "range", "caller") == [None, 1.0, 2.0]
    assert world.view().robots.signal.tolist() == [0, -1, -1]
    assert world.names.signals == ("help", "claim")
    signal(world, 0, 0, 0)
    assert read(world, "range", "caller") == [None, None, None]


# what the three raise, the target, how far it is for each of them: red, red, blue
CALLS = [
    ((HELP, HELP, 0), "caller", [1.0, 1.0, 1.0]),
    ((HELP, 0, HELP), "caller", [2.0, 1.0, 2.0]),
    ((HELP, CLAIM, 0), "caller", [None, 1.0, 2.0]),
    ((HELP, CLAIM, 0), "claimer", [1.0, None, 1.0]),
    ((0, 0, HELP), "red caller", [None, None, None]),
    ((HELP, 0, HELP), "red caller", [None, 1.0, 2.0]),
    ((HELP, 0, HELP), "calling mate", [None, 1.0, None]),
    ((HELP, 0, HELP), "calling opponent", [2.0, 1.0, 2.0]),
    (
        (9.0, -3.0, 0.4),
        "caller",
        [None, None, None],
    ),  # there are two signals: what is no number of one is the next
]


@pytest.mark.parametrize(("raised", "target", "far"), CALLS)
def test_the_nearest_other_that_calls(
    raised: tuple[float, ...], target: str, far: list[float | None]
) -> None:
    world = line()
    signal(world, *raised)
    assert read(world, "range", target) == far
    for agent, meters in enumerate(far):
        place = find_target_place(world, target, agent)
        assert (place is None) == (meters is None)
        assert meters is None or abs(place[0] - 1.0 - agent) == pytest.approx(meters)  # type: ignore[index]


def test_who_fails_is_silent() -> None:
    world = line()
    signal(world, HELP, 0, 0)
    world.freeze(0)
    signal(world, HELP, 0, 0)
    assert read(world, "range", "caller") == [None, None, None]


# where the robots are, what they raise, the target, whether it is claimed for each
CLAIMS = [
    ([(2.0, 4.1), (2.0, 2.0)], (CLAIM, 0), "box", [0.0, 1.0]),  # not by oneself
    ([(2.0, 4.1), (2.0, 2.0)], (HELP, 0), "box", [0.0, 0.0]),  # nor by who raises something else
    ([(2.0, 3.9), (2.0, 2.0)], (CLAIM, 0), "box", [0.0, 0.0]),  # nor from 1.1 m away
    ([(2.0, 4.0), (2.0, 6.0)], (CLAIM, CLAIM), "box", [1.0, 1.0]),  # from just 1 m away
    ([(8.0, 4.1), (2.0, 2.0)], (CLAIM, 0), "box", [0.0, 0.0]),  # it is another box that is claimed
    ([(8.0, 4.1), (2.0, 2.0)], (CLAIM, 0), "second box", [0.0, 1.0]),
]


@pytest.mark.parametrize(("places", "raised", "target", "claimed"), CLAIMS)
def test_claims(
    places: list[tuple[float, float]], raised: tuple[float, ...], target: str, claimed: list[float]
) -> None:
    world = line("rr")
    for agent, (x, y) in enumerate(places):
        world.place(agent, x, y, 0.0)
    signal(world, *raised)
    assert read(world, "claimed", target) == claimed


def test_what_is_not_there_is_not_claimed_either() -> None:
    world = line("rr")
    world.remove_object(0)
    world.remove_object(1)
    assert read(world, "claimed", "box") == [None, None]


def test_claimed_things_are_passed_over() -> None:
    """Two robots near the left box, 3 m from it and 0.5 m; the one that claims it still goes there."""
    world = line("rr")
    world.place(1, 2.0, 4.5, 0.0)
    world.place(0, 2.0, 2.0, 0.0)
    signal(world, 0, CLAIM)
    assert read(world, "range", "box") == [3.0, 0.5]
    assert read(world, "range", "free box") == [np.hypot(6.0, 3.0), 0.5]
    assert read(world, "range", "free box far") == [None, 0.5]
    assert [find_target_place(world, "free box", agent) for agent in (0, 1)] == [(8.0, 5.0), (2.0, 5.0)]
    assert find_target_place(world, "free box far") is None
    signal(world, 0, 0)
    assert read(world, "range", "free box") == [3.0, 0.5]


@pytest.mark.parametrize("spare", [0, 16, 100])
def test_of_things_equally_near_the_first_counts(spare: int) -> None:
    """Four boxes around a robot, in any order of their places: few are compared, and many are sorted."""
    around = ((6.0, 4.0), (5.0, 5.0), (5.0, 3.0), (4.0, 4.0))
    for first in range(4):
        boxes = ObjectClass(name="box", at=(*around[first:], *around[:first]))
        robots = (RobotGroup(type="red", at=((5.0, 4.0, 0.0),)),)
        scenario = Scenario(
            size=(10.0, 8.0), types={"red": RED}, robots=robots, objects=(boxes,), spare_objects=spare,
            targets={"box": TargetSpec(nearest="box"), "free": TARGETS["free box"]},
        )  # fmt: skip
        world = World(scenario, (0,))
        ahead = np.arctan2(around[first][1] - 4.0, around[first][0] - 5.0) % (2 * np.pi)
        assert read(world, "bearing", "box") == read(world, "bearing", "free") == [ahead]


@pytest.mark.parametrize("boxes", [30, 150])
@pytest.mark.parametrize(("callers", "few"), [(1, 1), (9, 1), (150, 1), (150, 10_000), (9, 10_000)])
def test_many_robots_find_what_comparing_all_finds(
    callers: int, few: int, boxes: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Few callers are listed and many looked for in the grid, many boxes are sorted: all as plain NumPy has it."""
    monkeypatch.setattr(neighbor_grid, "FEW", few)
    robots = (RobotGroup(type="red", count=100), RobotGroup(type="blue", count=100))
    objects = (ObjectClass(name="box", count=boxes),)
    world = World(
        Scenario(
            size=(30.0, 20.0),
            types={"red": RED, "blue": BLUE},
            robots=robots,
            targets=TARGETS,
            objects=objects,
        ),
        (7,),
    )
    raised = np.zeros(200)
    draw = np.random.default_rng(callers)
    raised[draw.choice(200, callers, replace=False)] = draw.choice((HELP, CLAIM), callers)
    signal(world, *raised)
    rows, things = world.state.robots, world.state.objects[0]
    things = things[things["present"] != 0]
    apart = np.hypot(rows["x"][:, None] - rows["x"], rows["y"][:, None] - rows["y"])
    np.fill_diagonal(apart, np.inf)
    team = rows["type"]
    for target, calls in {
        "caller": (raised == HELP)[None, :],
        "calling mate": (raised == HELP) & (team[:, None] == team),
        "claimer": (raised == CLAIM)[None, :],
    }.items():
        expected = np.where(calls, apart, np.inf).min(axis=1)
        found = world.sense([("range", target)])["range", target]
        assert np.where(np.isnan(found), np.inf, found) == pytest.approx(expected)
    off = np.hypot(rows["x"][:, None] - things["x"], rows["y"][:, None] - things["y"])
    near = (off <= 1.0) & (raised == CLAIM)[:, None]
    others = near.sum(axis=0) - near > 0
    expected = np.where(others, np.inf, off).min(axis=1)
    found = world.sense([("range", "free box")])["range", "free box"]
    assert np.where(np.isnan(found), np.inf, found) == pytest.approx(expected)
    nearest = off.argmin(axis=1)
    assert world.sense([("range", "box")])["range", "box"] == pytest.approx(off.min(axis=1))
    claimed = world.sense([("claimed", "box")])["claimed", "box"]
    assert (claimed == others[np.arange(200), nearest]).all()
    if callers == 150:
        assert claimed.any()
