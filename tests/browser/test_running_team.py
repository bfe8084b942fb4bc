"""A team of agents at the page, in processes of their own: seen, armed, frozen, killed, trained, and left alone."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("zenoh", reason="needs the extra ros2")

from tests.robots.agent_processes import SQUAD, AgentProcesses, run_patrol, wait_until

from understudy.addons.robots.team_network.agent_questions import AgentStatus

pytestmark = pytest.mark.xdist_group("running team")
ROBOTS = [f"pioneer_{number}" for number in range(1, 5)]


@pytest.fixture(scope="module")
def agents() -> Iterator[AgentProcesses]:
    """Four robots and their coordinator; a computer called laptop may train them."""
    with run_patrol(1000, trainer="laptop") as made:
        yield made


@pytest.fixture
def studio(agents: AgentProcesses) -> Iterator[Studio]:
    made = Studio(agents.file.parent.parent / "library", "--team", str(agents.file))
    made.start()
    yield made
    made.stop()


def status(agents: AgentProcesses, name: str) -> AgentStatus:
    found = agents.ask("status")[name].status
    assert found is not None
    return found


def test_a_running_team_is_seen_and_armed(
    visit: Callable[[], Page], agents: AgentProcesses, snap: Callable[[Page, str], None]
) -> None:
    page = visit()
    team = page.get_by_role("main", name="Team")
    squad = team.get_by_role("region", name=SQUAD)
    expect(team).to_contain_text("5 of 5 agents are heard")
    expect(squad).to_contain_text("led by")
    row = squad.get_by_role("listitem", name="pioneer_4")
    expect(row).to_contain_text("order ")

    row.get_by_role("button", name="Stop pioneer_4").click()
    expect(row.get_by_role("button", name="Arm…")).to_be_enabled()
    expect(row).to_contain_text("not counted: emergency: asked to by the studio: stopped in the studio")
    row.get_by_role("button", name="Arm…").click()
    expect(row).to_contain_text("It will move.")
    row.get_by_role("button", name="Cancel").click()
    assert status(agents, "pioneer_4").armed is False
    row.get_by_role("button", name="Arm…").click()
    row.get_by_role("button", name="Arm pioneer_4").click()
    wait_until(
        lambda: any("armed by the studio" in line for line in agents.ask("logs")["pioneer_4"].log),
        "never armed",
    )
    page.set_viewport_size({"width": 1280, "height": 800})
    snap(page, "team")
    page.set_viewport_size({"width": 390, "height": 844})
    wide = page.evaluate("document.documentElement.scrollWidth")
    assert wide <= 390
    snap(page, "team-phone")


def test_silent_and_missing_agents_are_marked(
    visit: Callable[[], Page], agents: AgentProcesses, snap: Callable[[Page, str], None]
) -> None:
    page = visit()
    team = page.get_by_role("main", name="Team")
    squad = team.get_by_role("region", name=SQUAD)
    row = squad.get_by_role("listitem", name="pioneer_4")
    expect(team).to_contain_text("5 of 5 agents are heard")
    os.kill(agents.processes["pioneer_4"].pid, signal.SIGSTOP)
    try:
        expect(row).to_contain_text("is silent")
        expect(team).to_contain_text("Not heard: pioneer_4")
    finally:
        os.kill(agents.processes["pioneer_4"].pid, signal.SIGCONT)
    expect(team).to_contain_text("5 of 5 agents are heard")
    agents.processes[SQUAD].kill()
    agents.processes[SQUAD].wait()
    expect(squad).to_contain_text("its own agent is not there")
    expect(squad).to_contain_text("led by pioneer_")
    snap(page, "team-without-coordinator")
    agents.start(SQUAD)
    expect(team).to_contain_text("5 of 5 agents are heard")


def test_a_coordinator_is_trained_and_its_robots_are_left_alone_afterwards(
    visit: Callable[[], Page], studio: Studio, agents: AgentProcesses, snap: Callable[[Page, str], None]
) -> None:
    page = visit()
    team = page.get_by_role("main", name="Team")
    squad = team.get_by_role("region", name=SQUAD)
    expect(team).to_contain_text("5 of 5 agents are heard")
    squad.locator("header").get_by_role("button", name="Train").click()
    teacher = Teacher(page)
    teacher.click("Teach something new")
    form = page.locator("form.choice")
    form.get_by_role("textbox", name="Name", exact=True).fill("gather")
    for label in ("disperse", "patrol", "all done", "present"):
        form.get_by_role("checkbox", name=label, exact=True).check()
    teacher.begin_as_in_the_paper()
    teacher.state_button("disperse").click()
    expect(page.get_by_role("tab", name="Lesson")).to_contain_text("2")
    wait_until(
        lambda: all(status(agents, name).trainer == "laptop" for name in ROBOTS),
        "the robots were never driven",
    )
    assert status(agents, SQUAD).trainer == ""
    snap(page, "team-coordinator-training")
    teacher.click("Save")
    page.get_by_role("group", name="View").get_by_role("button", name="Team").click()
    for name in ROBOTS:
        row = squad.get_by_role("listitem", name=name)
        expect(row).to_contain_text("trained from laptop")
    page.close()
    studio.stop()
    wait_until(
        lambda: all(status(agents, name).trainer == "" for name in ROBOTS), "the robots were not left alone"
    )


def test_a_robot_is_trained_and_left_alone_when_the_studio_dies(
    visit: Callable[[], Page], studio: Studio, agents: AgentProcesses, snap: Callable[[Page, str], None]
) -> None:
    page = visit()
    team = page.get_by_role("main", name="Team")
    row = team.get_by_role("listitem", name="pioneer_3")
    expect(team).to_contain_text("5 of 5 agents are heard")
    row.get_by_role("button", name="Train").click()
    teacher = Teacher(page)
    teacher.click("Teach something new")
    form = page.locator("form.choice")
    form.get_by_role("textbox", name="Name", exact=True).fill("dash")
    for label in ("forwards", "backwards", "sonar front left"):
        form.get_by_role("checkbox", name=label, exact=True).check()
    teacher.begin_as_in_the_paper()
    teacher.state_button("forwards").click()
    expect(page.get_by_role("tab", name="Lesson")).to_contain_text("2")
    wait_until(lambda: status(agents, "pioneer_3").trainer == "laptop", "the robot was never driven")
    assert status(agents, "pioneer_2").trainer == ""
    snap(page, "team-training")
    page.get_by_role("group", name="View").get_by_role("button", name="Team").click()
    expect(row).to_contain_text("trained from laptop")

    studio.kill()
    wait_until(lambda: status(agents, "pioneer_3").trainer == "", "the robot was not left alone")
    wait_until(lambda: status(agents, "pioneer_3").path != [], "it did nothing then")
    assert status(agents, "pioneer_3").unfit != "is being trained"
    journals = list((agents.file.parent.parent / "library").rglob("*journal*"))
    assert journals, "the presses are on this computer"
