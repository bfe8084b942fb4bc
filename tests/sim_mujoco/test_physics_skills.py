"""Skills of robots in physics: their stand-ins take as long, and end at the same places, as in the 2-D world."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from understudy.addons.bridges.mujoco.body import MujocoBody
from understudy.addons.bridges.mujoco.robot_files import check_ros
from understudy.errors import SettingError
from understudy.runtime.body import Body
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Obstacle, Scenario
from understudy.sim.world import World
from understudy.testing import check_body

SCENARIO = load_scenario(Path(__file__).parents[1] / "sim" / "skilled.toml")
READINGS = [(f"go_to_{each}", None) for each in ("succeeded", "aborted", "timed_out", "distance_remaining")]


def change_skill(**changes: object) -> Scenario:
    """The scenario with another skill go_to."""
    kind = SCENARIO.types["rover"]
    skills = {**kind.skills, "go_to": replace(kind.skills["go_to"], **changes)}
    return replace(SCENARIO, types={"rover": replace(kind, skills=skills)})


def command(body: World | MujocoBody, target: str | None, issued: float = 0.0) -> None:
    """Let the first robot go to a target; None: let it stand. The others stand."""
    world = body.world if isinstance(body, MujocoBody) else body
    numbers = np.zeros(body.agents)
    numbers[0] = 0 if target is None else world.index_skill("go_to", {"A": target})
    body.act({"skill": numbers, "issued": np.full(body.agents, issued)})


def read(body: Body) -> list[float]:
    found = body.sense(READINGS)
    return [float(found[key][0]) for key in READINGS]


def find_place(body: MujocoBody, robot: int) -> tuple[float, float]:
    robots = body.view().robots
    return float(robots.x[robot]), float(robots.y[robot])


def test_a_body_with_skills_keeps_all_laws() -> None:
    check_body(MujocoBody(SCENARIO, [5]), ticks=20)


CASES = [{}, {"success": 0.0}, {"timeout_s": 1.0}, {"duration_s": (0.5, 4.0)}, {"duration_s": 0.1}]


@pytest.mark.parametrize("changes", CASES)
def test_it_goes_to_the_same_places_and_ends_the_same_as_in_the_2d_world(changes: dict[str, object]) -> None:
    flat, body = World(change_skill(**changes), [3]), MujocoBody(change_skill(**changes), [3])
    for tick in range(40):
        for each in (flat, body):
            command(each, "dock" if tick < 20 else "home", issued=0.0 if tick < 20 else 2.0)
        assert read(body) == pytest.approx(read(flat), abs=2e-3, nan_ok=True)
        robots = [each.view().robots for each in (flat, body)]
        assert float(robots[1].x[0]) == pytest.approx(float(robots[0].x[0]), abs=2e-3)


def test_it_goes_through_everything_and_pushes_nothing() -> None:
    """A pillar at x = 3, another robot at x = 4.5, and the dock's edge at x = 6.8; it stops at x = 6.5."""
    group = replace(SCENARIO.robots[0], at=((2.0, 3.0, 0.0), (4.5, 3.0, 0.0)))
    pillar = Obstacle(at=((3.0, 3.0),), radius=0.3)
    body = MujocoBody(replace(SCENARIO, robots=(group,), obstacles=(pillar,)), [0])
    for _ in range(35):
        command(body, "dock")
        assert find_place(body, 1) == pytest.approx((4.5, 3.0), abs=0.02)
    assert find_place(body, 0) == pytest.approx((6.5, 3.0), abs=0.01)
    for _ in range(10):
        command(body, None)
    assert body.arenas[0].data.qpos[body.arenas[0].built.qpos[0] + 2] == pytest.approx(0.0, abs=0.01)


def test_a_body_that_is_restored_goes_on_the_same() -> None:
    body = MujocoBody(SCENARIO, [5])
    for _ in range(7):
        command(body, "dock")
    kept, ends = body.snapshot(), []
    for _ in range(2):
        for _ in range(7):
            command(body, "dock")
        ends.append(body.snapshot())
        body.restore(kept)
    assert ends[0] == ends[1]


def test_simulated_ros_robots_have_no_skills() -> None:
    with pytest.raises(SettingError, match=r"types\.rover\.skills has no action or service on a simulated"):
        check_ros(SCENARIO)
