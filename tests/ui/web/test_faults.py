"""What goes wrong in somebody's own kit, or in the program, is a sentence on the page, and the robot stands still."""

from __future__ import annotations

import logging
from pathlib import Path
from types import MappingProxyType

import pytest
from tests.make.studios import GOTO, Wall, open_page, serve_studio

from understudy.model.features import ReadingsView, feature
from understudy.model.library import Kit
from understudy.model.value_kinds import Column, Continuous
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.ui.web.actions import handler_table
from understudy.ui.web.messages import session as m
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost


def test_a_feature_of_somebodys_own_that_fails(tmp_path: Path) -> None:
    failing = False

    @feature(Continuous())
    def risky(robot: ReadingsView) -> Column:
        """Fails after a while."""
        if failing:
            raise RuntimeError("out of cheese")
        return robot.food_stored * 1.0

    wall, scenario = Wall(), find_scenario("forage")
    host = SessionHost(scenario, tmp_path, make_scenario_kit(scenario) + Kit.from_parts(risky), wall=wall)
    with serve_studio(StudioServer(host, wall=Wall(glance=0.01))) as client, open_page(client) as person:
        person.done(**{**GOTO, "features": ["risky"], "parameters": [], "targets": {}})
        person.done("press", state="forward")
        failing = True
        wall.now += 0.2
        while person.news["message"]["tone"] != "error":
            person.hear()
        assert "out of cheese" in person.news["message"]["text"]
        assert person.news["paused"]
        assert "error" in person.say("step")
        failing = False
        person.done("step")


def test_a_fault_of_the_program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def broken(_: SessionHost, __: m.Undo) -> None:
        raise KeyError("nowhere")

    monkeypatch.setattr(
        handler_table, "HANDLERS", MappingProxyType({**handler_table.HANDLERS, m.Undo: broken})
    )
    scenario = find_scenario("forage")
    made = StudioServer(SessionHost(scenario, tmp_path, make_scenario_kit(scenario), wall=Wall()))
    with caplog.at_level(logging.CRITICAL), serve_studio(made) as client, open_page(client) as person:
        assert "internal error: KeyError" in person.say("undo")["error"]
        person.done("pause", paused=True)


def test_a_picture_that_cannot_be_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = find_scenario("forage")
    made = StudioServer(
        SessionHost(scenario, tmp_path, make_scenario_kit(scenario), wall=Wall()), wall=Wall(glance=0.01)
    )
    with serve_studio(made) as client, open_page(client) as person:
        person.done(**GOTO)
        with monkeypatch.context() as patched:
            patched.setattr(made.host, "frame", lambda: 1 / 0)
            person.done("press", state="forward")
            person.done("step")
        person.done("step")
        assert made.host.paused
