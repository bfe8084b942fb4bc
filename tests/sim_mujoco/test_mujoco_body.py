"""Physics as a body: it keeps all laws, moves as commanded, and has the referee's clock, goal and food."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from msgspec.structs import replace
from tests.sim_mujoco.drawing import draws

from understudy.addons.bridges.mujoco.body import MujocoBody
from understudy.errors import SettingError
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import AppearanceSchedule, Breakdown, CaptureRule, Scenario
from understudy.testing import check_body, check_world

ALONE = (6.0, 5.0)


def rovers(x: float, y: float, heading: float = 0.0) -> MujocoBody:
    """The arena without obstacles, its robot there."""
    body = MujocoBody(replace(load_scenario("arena"), obstacles=()), [0])
    body.place(0, x, y, heading)
    return body


def driven(body: MujocoBody, seconds: float, **commands: float) -> None:
    for _ in range(round(seconds / body.tick_s)):
        body.act({name: np.full(body.agents, value) for name, value in commands.items()})


@pytest.mark.parametrize("name", ["arena", "forage"])
def test_a_body_without_cameras_keeps_all_laws(name: str) -> None:
    check_body(MujocoBody(load_scenario(name), [5]), ticks=20)


@draws
def test_a_body_with_cameras_keeps_all_laws_and_worlds_are_each_their_own() -> None:
    check_world(lambda seeds: MujocoBody(load_scenario("patrol"), seeds), seeds=(0, 3), ticks=6)


MOVES = [  # seconds, drive, turn; how far it gets ahead and to its left (m), how far it turns (rad)
    (4.0, 1.0, 0.0, 2.0, 0.0, 0.0),
    (4.0, -1.0, 0.0, -2.0, 0.0, 0.0),
    (4.0, 0.5, 0.0, 1.0, 0.0, 0.0),
    (1.0, 0.0, 1.0, 0.0, 0.0, 70 / 180 * pi),
    (1.0, 0.0, -0.5, 0.0, 0.0, -35 / 180 * pi),
    (2.0, 0.0, 0.0, 0.0, 0.0, 0.0),
]


@pytest.mark.parametrize(("seconds", "drive", "turn", "ahead", "left", "turned"), MOVES)
def test_it_gets_where_its_speeds_lead_but_for_inertia(
    seconds: float, drive: float, turn: float, ahead: float, left: float, turned: float
) -> None:
    """It loses about a tenth of a second's way in getting going."""
    body = rovers(*ALONE)
    driven(body, seconds, drive=drive, turn=turn)
    robots = body.view().robots
    assert float(robots.x[0]) - ALONE[0] == pytest.approx(ahead, abs=0.07)
    assert float(robots.y[0]) - ALONE[1] == pytest.approx(left, abs=0.03)
    assert np.angle(np.exp(1j * (float(robots.heading[0]) - turned))) == pytest.approx(0.0, abs=0.15)


def test_it_stands_still_at_once_where_a_wall_is_and_says_that_it_is_stuck() -> None:
    body = rovers(11.0, 5.0)
    driven(body, 4.0, drive=1.0)
    assert float(body.view().robots.x[0]) == pytest.approx(11.8, abs=0.01)  # a robot of 0.2 m at the wall
    assert body.sense([("stuck", None), ("bumper", None)]) == {
        ("stuck", None): [1.0],
        ("bumper", None): [1.0],
    }
    driven(body, 1.0, drive=-1.0)
    assert body.sense([("stuck", None)])["stuck", None] == [0.0]


def test_a_robot_that_failed_stands_and_senses_nothing() -> None:
    body = rovers(*ALONE)
    body.freeze(0)
    driven(body, 1.0, drive=1.0)
    assert float(body.view().robots.x[0]) == pytest.approx(ALONE[0], abs=1e-3)
    assert np.isnan(body.sense([("sonar_ahead", None)])["sonar_ahead", None]).all()


def test_a_robot_fails_when_its_scenario_says() -> None:
    """After 1 s, in which it has come 0.45 m far; then it rolls out."""
    scenario = load_scenario("arena")
    group = replace(scenario.robots[0], fails=(Breakdown(at_s=1.0, robots=(0,)),))
    body = MujocoBody(replace(scenario, robots=(group,), obstacles=()), [0])
    body.place(0, *ALONE, 0.0)
    driven(body, 0.9, drive=1.0)
    assert not body.failed[0]
    driven(body, 2.0, drive=1.0)
    assert body.failed[0]
    assert float(body.view().robots.x[0]) - ALONE[0] == pytest.approx(0.45, abs=0.1)
    assert np.isnan(body.sense([("sonar_ahead", None)])["sonar_ahead", None]).all()


def test_the_goal_is_reached_in_physics() -> None:
    body = rovers(*ALONE)
    flag = next(k for k, name in enumerate(body.world.names.classes) if name == "red_flag")
    place = body.view().objects.kind.tolist().index(flag)
    x, y = float(body.view().objects.x[place]), float(body.view().objects.y[place])
    body.place(0, x - 1.0, y, 0.0)
    driven(body, 3.0, drive=1.0)
    assert body.finished_s[0] == pytest.approx(1.4, abs=0.3)  # 0.6 m at 0.5 m/s, and getting going


def test_food_is_loaded_standing_still() -> None:
    body = MujocoBody(load_scenario("forage"), [2])
    things = body.view().objects
    (at, *_) = np.flatnonzero(things.food).tolist()
    body.place(0, float(things.x[at]), float(things.y[at]), 0.0)
    driven(body, 1.5, drive=0.1, load=1.0)
    assert body.sense([("food_stored", None)])["food_stored", None] == [0.0]
    driven(body, 2.5, load=1.0)
    assert body.sense([("food_stored", None)])["food_stored", None] == [2.0]


@draws
def test_what_comes_and_goes_is_seen_and_captured() -> None:
    """An intruder that is there from 0.2 s on, 0.7 m ahead of a robot, and captured half a second later."""
    scenario = load_scenario("patrol")
    thing = next(each for each in scenario.objects if each.name == "intruder")
    comes = replace(
        thing,
        presence=AppearanceSchedule(away_s=(60, 60), first_s=(0.2, 0.2)),
        capture=CaptureRule(range=0.8, after_s=0.5),
    )
    targets = {"intruder": scenario.targets["intruder"]}
    body = MujocoBody(replace(scenario, objects=(comes,), obstacles=(), squads={}, targets=targets), [1])
    key = ("blob_x", "intruder")
    assert np.isnan(body.sense([key])[key]).all()
    driven(body, 0.3)
    objects = body.view().objects
    x, y = float(objects.x[0]), float(objects.y[0])
    side = -1.0 if x > 6 else 1.0
    body.place(0, x + side * 0.7, y, 0.0 if side < 0 else pi)
    unseen = ("unseen", "intruder")
    assert body.sense([key])[key][0] == pytest.approx(80.0, abs=1.0)
    assert body.sense([unseen])[unseen][0] == 0.0
    driven(body, 1.0)
    assert np.isnan(body.sense([key])[key][0])
    assert body.sense([unseen])[unseen][0] == pytest.approx(0.4, abs=0.11)


def test_boxes_are_refused() -> None:
    scenario: Scenario = load_scenario("boxes")
    with pytest.raises(SettingError, match=r"objects\[1\].pull"):
        MujocoBody(scenario)


@pytest.mark.parametrize("agent", [-1, 1])
def test_nobody_sees_nothing(agent: int) -> None:
    with pytest.raises(SettingError, match=f"agent is {agent}; give one from 0 to 0"):
        rovers(*ALONE).image(agent)
