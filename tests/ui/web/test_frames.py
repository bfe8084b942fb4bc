"""Frames hold what the world's view does, read by code that knows only the contract."""

from __future__ import annotations

from math import isnan, nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.testing import assert_allclose
from tests.make.studios import GOTO, Frame, Wall, make_studio, to_json

from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import list_builtin_scenarios
from understudy.sim.scenario.schema import Sonar
from understudy.ui.controller.training_plan import LessonChoices
from understudy.ui.web.actions import session
from understudy.ui.web.frames import encode_frame
from understudy.ui.web.session_host import SessionHost

NONE = 65535


def same(read: Frame, host: SessionHost) -> None:
    view = host.world.view()
    robots = view.robots
    expected = np.column_stack([robots.x, robots.y, robots.heading]).astype(np.float32)
    assert_allclose([row[:3] for row in read.robots], expected, rtol=0, atol=0)
    assert [row[3] for row in read.robots] == robots.stored.tolist()
    things = view.objects
    assert [(row[0], row[1]) for row in read.objects] == list(
        zip(things.slot.tolist(), things.kind.tolist(), strict=True)
    )
    at = np.column_stack([things.x, things.y]).astype(np.float32).reshape(-1, 2)
    assert_allclose(np.reshape([row[2:4] for row in read.objects], (-1, 2)), at, rtol=0, atol=0)
    assert [row[4:] for row in read.objects] == list(
        zip(things.amount.tolist(), things.at_first.tolist(), strict=True)
    )
    assert read.delivered == robots.delivered.sum()
    assert read.time_s == view.time_s
    assert read.tick == round(view.time_s / host.world.tick_s)


@pytest.mark.parametrize("world", list_builtin_scenarios())
def test_a_frame_is_the_view(tmp_path: Path, world: str) -> None:
    host = make_studio(tmp_path, world=world, seed=3).host
    read = Frame.read(host.frame())
    same(read, host)
    assert (read.kind, read.bits, read.state, read.agent, read.features) == (1, 1, NONE, 0, [])  # paused
    scene: dict[str, Any] = to_json(host.scene())
    sonars = scene["sonars"][scene["robot_type"][0]]
    percept = host.world.sense([(sonar["name"], None) for sonar in sonars])
    expected = [percept[sonar["name"], None][0] for sonar in sonars]
    assert_allclose(read.sonar, np.asarray(expected, np.float32), rtol=0, atol=0)
    assert len(read.robots) == scene["robots"] == len(scene["robot_type"])
    assert all(row[1] < len(scene["classes"]) for row in read.objects)


def test_a_frame_of_a_session(tmp_path: Path) -> None:
    host = make_studio(tmp_path, world="forage-team").host
    session.select_agent(host, 1)
    fields = {key: value for key, value in GOTO.items() if key not in ("do", "name")}
    session.begin_automaton(host, "goto", LessonChoices(**fields), discard=False)
    trainer = host.active_trainer
    trainer.press("rotate_left")
    for _ in range(7):
        trainer.step()
    read = Frame.read(host.frame())
    same(read, host)
    assert (read.bits, read.state, read.agent) == (1 | 4, 2, 1)
    assert [row[4] for row in read.robots] == [NONE, 2, *[NONE] * (len(read.robots) - 2)]
    assert_allclose(read.features, list(trainer.session_view.features.values()), rtol=1e-6)
    trainer.toggle_mode()
    assert Frame.read(host.frame()).bits == 1 | 2 | 4
    host.close()


def test_absent_values_and_numbers_that_are_too_large(tmp_path: Path) -> None:
    host = make_studio(tmp_path).host
    host.world.state.objects["amount"][0] = 2_000_000
    data = encode_frame(host.world.view(), tick=2**40, agent=0, features=(nan, 1.5), sonar=(nan,))
    read = Frame.read(data)
    assert read.tick == 0
    assert isnan(read.features[0])
    assert read.features[1] == 1.5
    assert isnan(read.sonar[0])
    assert {row[4] for row in read.objects} == {NONE}


def test_a_robot_type_with_300_sonar_sectors(tmp_path: Path) -> None:
    forage = find_scenario("forage")
    sectors = {f"sonar_{degree}": (float(degree), float(degree)) for degree in range(300)}
    forager = forage.types["forager"]
    scanning = replace(forager, sensors=(*forager.sensors, Sonar(sectors=sectors)))
    scenario = replace(forage, types={"forager": scanning})
    host = SessionHost(scenario, tmp_path, make_scenario_kit(scenario), seed=3, wall=Wall())
    host.world.state.robots["delivered"][0] = 7
    read = Frame.read(host.frame())
    same(read, host)
    percept = host.world.sense([(name, None) for name in sectors])
    assert_allclose(read.sonar, [np.float32(percept[name, None][0]) for name in sectors], rtol=0, atol=0)
    assert len(set(read.sonar)) > 100


def test_food_that_is_home(tmp_path: Path) -> None:
    host = make_studio(tmp_path, world="forage-team").host
    host.world.state.robots["delivered"][:2] = 40_000, 30_000
    assert Frame.read(host.frame()).delivered == 70_000
