"""Robots that fail at a time: when and which, by hand; the same in one world or many, tick by tick or at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from understudy.errors import SettingError
from understudy.sim.layout.breakdowns import NEVER, draw_failure_ticks
from understudy.sim.scenario.files import format_scenario, parse_scenario
from understudy.sim.scenario.schema import Breakdown, RobotGroup, RobotType, Scenario
from understudy.sim.scenario_snapshot import make_scenario_snapshot
from understudy.sim.world import World

DRIVER = RobotType(radius=0.1, speed=1.0, collides=False)


def make(*fails: Breakdown, robots: int = 4) -> Scenario:
    """Robots beside each other, which look to the right, in an arena of 30 m by 10 m with ticks of 0.1 s."""
    at = tuple((1.0, 1.0 + number, 0.0) for number in range(robots))
    return Scenario(
        name="line", size=(30.0, 10.0), tick_s=0.1, types={"driver": DRIVER},
        robots=(RobotGroup(type="driver", at=at, fails=fails),),
    )  # fmt: skip


def drive(world: World, ticks: int) -> None:
    for _ in range(ticks):
        world.act({"drive": np.ones(world.agents)})


def test_a_robot_stops_at_its_time() -> None:
    """Each tick takes a robot 0.1 m. The second one fails after 1 s, in which it has come 1 m far."""
    world = World(make(Breakdown(at_s=1.0, robots=(1,))), [7])
    drive(world, 9)
    assert not world.failed.any()
    drive(world, 1)
    assert world.failed.tolist() == [False, True, False, False], "from 1.0 s on"
    drive(world, 10)
    assert world.view().robots.x == pytest.approx([3.0, 2.0, 3.0, 3.0])


def test_it_fails_from_the_start() -> None:
    world = World(make(Breakdown(at_s=0.0, robots=(0, 2))), [7])
    assert world.failed.tolist() == [True, False, True, False]
    drive(world, 10)
    assert world.view().robots.x == pytest.approx([1.0, 2.0, 1.0, 2.0])
    world.reset([8])
    assert world.failed.tolist() == [True, False, True, False]


def test_the_first_of_several_counts() -> None:
    fails = (Breakdown(at_s=3.0, robots=(0, 1)), Breakdown(at_s=2.0, robots=(1, 2)))
    assert draw_failure_ticks(make(*fails), np.array([5])).tolist() == [[30, 20, 20, NEVER]]


def test_numbers_and_times_are_drawn() -> None:
    """Of four robots none to two fail, between 2 and 6 s; all numbers and all robots come up about equally often."""
    seeds = np.arange(6_000)
    ticks = draw_failure_ticks(make(Breakdown(at_s=(2.0, 6.0), count=(0, 2))), seeds)
    counts = (ticks != NEVER).sum(axis=1)
    assert [int((counts == number).sum()) for number in range(4)] == pytest.approx(
        [2000, 2000, 2000, 0], abs=180
    )
    assert (ticks != NEVER).mean(axis=0) == pytest.approx([0.25] * 4, abs=0.03)
    drawn = ticks[ticks != NEVER]
    assert (drawn.min(), drawn.max()) == (20, 60)
    assert drawn.mean() == pytest.approx(40, abs=1)


def test_breakdowns_are_drawn_apart() -> None:
    """Two breakdowns of one robot each take the same robot in one of four worlds."""
    one = Breakdown(at_s=1.0)
    ticks = draw_failure_ticks(make(one, one), np.arange(4_000))
    assert float(((ticks != NEVER).sum(axis=1) == 1).mean()) == pytest.approx(0.25, abs=0.03)


def test_a_world_is_the_same_among_others_and_after_a_restart() -> None:
    scenario = make(Breakdown(at_s=(0.0, 4.0), count=(0, 4)))
    many, alone = World(scenario, range(5)), World(scenario, [3])
    assert many.failure_ticks.reshape(5, 4)[3].tolist() == alone.failure_ticks.tolist()
    drive(many, 50)
    drive(alone, 20)
    kept = alone.snapshot()
    drive(alone, 30)
    ended = alone.view()
    assert many.view(3).robots.x.tolist() == ended.robots.x.tolist()
    alone.restore(kept)
    drive(alone, 30)
    assert alone.view().robots.x.tolist() == ended.robots.x.tolist()


def test_a_snapshot_keeps_what_failed_and_what_will() -> None:
    """At 1.5 s the first robot has failed, the second will in 0.5 s, and the others never."""
    scenario = make(Breakdown(at_s=1.0, robots=(0,)), Breakdown(at_s=2.0, robots=(1,)))
    world = World(scenario, [7])
    drive(world, 15)
    made = make_scenario_snapshot(scenario, world.view(), name="later")
    assert made.robots[0].fails == (Breakdown(at_s=0.0, robots=(0,)), Breakdown(at_s=0.5, robots=(1,)))
    again = World(made, [1])
    drive(again, 10)
    drive(world, 10)
    assert again.view().robots.x == pytest.approx(world.view().robots.x)


def test_it_is_written_to_files() -> None:
    made = make(Breakdown(at_s=(2.0, 6.0), count=(0, 2)), Breakdown(at_s=1.0, robots=(0,)))
    assert parse_scenario(format_scenario(made), "line.toml") == made


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"at_s": -1.0}, "robots[0].fails[0].at_s is -1.0; give 0 or more"),
    ({"at_s": (3.0, 2.0)}, "robots[0].fails[0].at_s is [3.0, 2.0]; give the least first"),
    ({"at_s": 1.0, "count": 5}, "robots[0].fails[0].count is 5, and the group has 4; give at most 4"),
    ({"at_s": 1.0, "count": (0, 5)}, "robots[0].fails[0].count is 5, and the group has 4"),
    (
        {"at_s": 1.0, "robots": (4,)},
        "robots[0].fails[0].robots has number 4, and the group has 4; count from 0 to 3",
    ),
    ({"at_s": 1.0, "robots": (1,), "count": 2}, "count is given beside robots; leave out one of the two"),
    ({"at_s": float("nan")}, "robots[0].fails[0].at_s is nan"),
]


@pytest.mark.parametrize(("fields", "said"), REFUSED)
def test_refused(fields: dict[str, Any], said: str) -> None:
    with pytest.raises(SettingError) as refused:
        World(make(Breakdown(**fields)))
    assert said in str(refused.value)


def test_without_it_nothing_changes() -> None:
    plain, failing = make(), make(Breakdown(at_s=9.0, count=0))
    assert "fails" not in format_scenario(plain)
    one, two = World(plain, [7]), World(failing, [7])
    assert (two.failure_ticks == NEVER).all()
    assert replace(failing, robots=plain.robots) == plain
    drive(one, 10)
    drive(two, 10)
    assert one.view().robots.x.tolist() == two.view().robots.x.tolist()
