"""While the studio arms a robot whose agent elsewhere is slow, it drives the others, and every page can stop them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from threading import Event
from typing import Any

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.make.studios import GOTO, Page, Wall, open_page, serve_studio
from tests.robots.slow_agents import SlowAgents, make_fleet, wait_for

from understudy.addons.robots.team_network.remote_robot import drive_robots
from understudy.addons.robots.twin import DigitalTwin
from understudy.sim.kit import make_scenario_kit
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost

ROBOTS = ("one", "two")
LONGEST_S = 60.0


class Lab:
    """A studio that shows two robots elsewhere and drives the first; two pages, of which the first is in control."""

    def __init__(self, folder: Path) -> None:
        self.agents = SlowAgents()
        fleet = make_fleet(self.agents, ROBOTS)
        twin = DigitalTwin(fleet)
        kit = make_scenario_kit(twin.scenario)
        host = SessionHost(twin.scenario, folder, kit, ground=twin, wall=Wall())  # no page is ever silent
        self.studio = StudioServer(host)
        drive_robots(fleet, [0])
        self.page: Page
        self.other: Page

    def arm(self, name: str) -> int:
        """Order from the page in control that a robot is armed, and return the number of the message."""
        number = next(self.page.numbers)
        self.page.socket.send_text(json.dumps({"id": number, "do": "arm_robot", "name": name}))
        return number

    def wait_asked(self, name: str, do: str) -> None:
        assert wait_for(lambda: (name, do) in self.agents.asked, LONGEST_S)

    def is_heard(self) -> bool:
        """Report that the page in control is there, and return whether that was answered."""
        return bool(self.page.done("heartbeat", holding=False))


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Lab]:
    made = Lab(tmp_path)
    with serve_studio(made.studio) as client, open_page(client) as made.page, open_page(client) as made.other:
        yield made


@pytest.fixture(params=["ready", "arm"])
def answer(request: pytest.FixtureRequest, lab: Lab) -> Iterator[Event]:
    """The agent of the second robot answers one of the two questions of an arming when the event is set."""
    held = lab.agents.hold("two", request.param)
    number = lab.arm("two")
    lab.wait_asked("two", request.param)
    yield held
    held.set()
    assert "it was stopped meanwhile" in lab.page.answer(number)["error"]
    assert wait_for(lambda: not any(lab.agents.armed.values()), LONGEST_S)


STOPS: list[dict[str, Any]] = [{"do": "stop"}, {"do": "stop_robot", "name": "two"}]


@pytest.mark.parametrize("stop", STOPS, ids=str)
def test_a_stop_from_another_page_passes_and_wins(lab: Lab, answer: Event, stop: dict[str, Any]) -> None:
    lab.other.send(stop)
    lab.wait_asked("two", "stop")
    assert not answer.is_set()


def test_arming_says_so_and_then_that_it_is_done(lab: Lab) -> None:
    held = lab.agents.hold("two", "arm")
    number = lab.arm("two")
    lab.wait_asked("two", "arm")
    assert lab.studio.host.status.text == "Arming…"
    held.set()
    assert lab.page.answer(number)["ok"]
    assert lab.studio.host.status.text == "two is armed"
    assert lab.agents.armed == {"two": True}


def test_meanwhile_the_other_robot_is_driven(lab: Lab) -> None:
    """Without commands for half a second it would be left to its agent."""
    lab.page.done(**{**GOTO, "targets": {"A": "red_flag"}})
    held = lab.agents.hold("two", "arm")
    number = lab.arm("two")
    lab.wait_asked("two", "arm")
    known = len(lab.agents.published)
    assert wait_for(
        lambda: lab.is_heard() and len(lab.agents.published) >= known + 6, LONGEST_S
    )  # ten are due in a second
    held.set()
    assert lab.page.answer(number)["ok"]


def test_where_the_page_is_closed_meanwhile_nothing_is_armed(tmp_path: Path) -> None:
    lab = Lab(tmp_path)
    held = lab.agents.hold("two", "arm")
    with serve_studio(lab.studio) as client:
        with open_page(client) as lab.page:
            lab.arm("two")
            lab.wait_asked("two", "arm")
        lab.wait_asked("two", "stop")
        held.set()
        assert wait_for(lambda: lab.agents.asked.count(("two", "stop")) == 2, LONGEST_S)
    assert not lab.agents.armed["two"]
