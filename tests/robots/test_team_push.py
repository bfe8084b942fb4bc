"""A library handed to the agents of a team: all take it over, or all go back, and the output says who has which."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.memory_network import MemoryTeam
from tests.robots.test_load_plan import write_team
from tests.ui.cli.commands import run
from typer.testing import Result

from understudy.addons.robots.team_network import agent_process
from understudy.addons.robots.team_network.agent_process import AgentProcess
from understudy.addons.robots.team_network.agent_questions import AgentAnswer, AgentQuestion
from understudy.addons.robots.team_network.library_push import Files, read_library_files
from understudy.addons.robots.team_network.load_plan import load_team_plan
from understudy.addons.robots.team_network.team_push import WhichLibrary, describe_push, push_library
from understudy.ui.cli.commands import team_orders

AGENTS = ("one", "two", "three")


class ScriptedAgents:
    """Agents that answer as a table says: by question and agent, a problem, or None for no answer."""

    def __init__(self, script: Mapping[tuple[str, str], str | None]) -> None:
        self.script, self.asked = script, list[str]()

    def __call__(self, question: AgentQuestion) -> dict[str, AgentAnswer]:
        self.asked.append(question.do)
        problems = {agent: self.script.get((question.do, agent), "") for agent in AGENTS}
        return {agent: AgentAnswer(problem=said) for agent, said in problems.items() if said is not None}


PUSHES = [  # what agents answer, what they are asked, the end of each one's line
    ({}, ["prepare", "switch", "restart"], ["has the new library"] * 3),
    (
        {("prepare", "two"): "is armed"},
        ["prepare", "forget"],
        ["has the former library", "has the former library (is armed)", "has the former library"],
    ),
    (
        {("switch", "two"): "is armed"},
        ["prepare", "switch", "forget"],
        ["has the former library", "has the former library (is armed)", "has the former library"],
    ),
    (
        {("switch", "two"): None, ("forget", "two"): None, ("forget", "three"): "the disk is full"},
        ["prepare", "switch", "forget"],
        [
            "has the former library",
            "has the new library or the former one (did not answer)",
            "has the new library, and runs it once it is started again (the disk is full)",
        ],
    ),
    (
        {("restart", "one"): "is armed"},
        ["prepare", "switch", "restart"],
        [
            "has the new library, and runs it once it is started again (is armed)",
            *["has the new library"] * 2,
        ],
    ),
]


@pytest.mark.parametrize(("script", "asked", "said"), PUSHES)
def test_a_push(script: dict[tuple[str, str], str | None], asked: list[str], said: list[str]) -> None:
    agents = ScriptedAgents(script)
    results = push_library(agents, {"go.json": b"new"}, agents=AGENTS, by="a test")
    assert agents.asked == asked
    assert describe_push(results)[:3] == [
        f"{agent}: {each}." for agent, each in zip(AGENTS, said, strict=True)
    ]
    all_former = {each.library for each in results.values()} == {WhichLibrary.FORMER}
    assert ("All have the former library: nothing was changed." in describe_push(results)) == all_former


OLD, NEW = {"go.json": b"old"}, {"go.json": b"new", "patrol/lead.json": b"lead"}


def write_library(folder: Path, files: Mapping[str, bytes]) -> Path:
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return folder


@pytest.fixture(autouse=True)
def documents_are_not_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(agent_process, "fingerprint_folder", lambda scenario, folder: "")


@pytest.fixture
def memory_team(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[MemoryTeam]:
    """Agents without robots that tick: two share a folder, and each of the others has its own."""
    team = load_team_plan(write_team(tmp_path))
    write_library(tmp_path / "pushed", NEW)
    folders = {
        name: write_library(tmp_path / FOLDERS.get(name, "shared") / "library", OLD) for name in team.agents
    }
    memory = MemoryTeam(team, folders)
    monkeypatch.setattr(team_orders, "ZenohNetwork", lambda team, options: memory.network.join())
    monkeypatch.setattr(team_orders, "FOUND_S", 0.0)
    for name in team.agents:
        memory.make(name, has_robot=False)
    with memory.run_agents():
        yield memory
    memory.close()


@pytest.fixture
def agents(memory_team: MemoryTeam) -> dict[str, AgentProcess]:
    return memory_team.agents


FOLDERS = {"pioneer_3": "third", "patrol_0": "coordinator"}
NAMES = {"pioneer_1", "pioneer_2", *FOLDERS}


def push(folder: Path, *options: str) -> Result:
    return run("team", "push", folder / "team.toml", "--library", folder / "pushed", *options)


def read_libraries(agents: Mapping[str, AgentProcess]) -> list[dict[str, bytes]]:
    return [read_library_files(agents[name].team.library) for name in sorted(NAMES)]


def test_all_agents_take_a_library_over(tmp_path: Path, agents: dict[str, AgentProcess]) -> None:
    result = push(tmp_path)
    assert result.exit_code == 0, result.output
    assert set(result.stdout.splitlines()) == {f"{name}: has the new library." for name in NAMES}
    assert read_libraries(agents) == [NEW] * 4
    assert read_library_files(tmp_path / "shared" / "library.former") == OLD
    assert all(each.restarts for each in agents.values())


def test_if_one_agent_cannot_switch_the_others_go_back(
    tmp_path: Path, agents: dict[str, AgentProcess], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(agents["pioneer_3"]._library, "switch", lambda: "has a full disk")
    result = push(tmp_path, "--json")
    assert result.exit_code == 1
    said = json.loads(result.stdout)
    assert said["agents"] == {**dict.fromkeys(NAMES, ""), "pioneer_3": "has a full disk"}
    assert said["libraries"] == dict.fromkeys(NAMES, "former")
    assert read_libraries(agents) == [OLD] * 4
    assert not any(each.restarts or each.left for each in agents.values())


def test_an_agent_checks_a_library_while_it_ticks(
    tmp_path: Path, memory_team: MemoryTeam, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The coordinator ticks on while the library is checked, however long that takes."""
    coordinator, ticks = memory_team.agents["patrol_0"], list[int]()

    def check_slowly(folder: Path) -> str:
        ticks.append(coordinator.ticks)
        memory_team.clock.sleep(0.5)
        ticks.append(coordinator.ticks)
        return ""

    monkeypatch.setattr(coordinator._library, "_compute", check_slowly)
    assert push(tmp_path).exit_code == 0
    assert ticks[1] - ticks[0] == 5


def test_an_armed_robot_refuses_before_anything_is_checked(
    tmp_path: Path, agents: dict[str, AgentProcess], monkeypatch: pytest.MonkeyPatch
) -> None:
    agent, prepared = agents["pioneer_1"], list[Files]()
    monkeypatch.setattr(agent, "robot", SimpleNamespace(armed=True))
    monkeypatch.setattr(agent._library, "prepare", prepared.append)
    result = push(tmp_path)
    assert result.exit_code == 1
    assert "pioneer_1: has the former library (is armed: stop it first)." in result.stdout
    assert result.stdout.endswith("All have the former library: nothing was changed.\n")
    assert prepared == []
    assert read_libraries(agents) == [OLD] * 4
