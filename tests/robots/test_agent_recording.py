"""Recordings of agents that run as processes: merged, decided again, and explained across computers."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest

pytest.importorskip("zenoh", reason="needs the extra ros2")
pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from tests.robots.agent_processes import COMMAND, SQUAD, AgentProcesses, run_patrol, wait_until
from tests.ui.cli.commands import run, said

from understudy.analysis.rerun import Rerun
from understudy.robots.recording.header import format_part
from understudy.robots.recording.merge import read_team_clock
from understudy.robots.recording.team_reader import read_team_recording
from understudy.robots.team_network.load_plan import load_team_plan
from understudy.runtime.agents.leadership import is_term_of

pytestmark = [pytest.mark.long, pytest.mark.timed]


class Recorded(NamedTuple):
    """The recordings of a patrol whose coordinator was killed."""

    paths: list[Path]
    library: Path
    deputy: str
    """The robot that leads since."""


def record(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Recorded:
    """Record a patrol whose coordinator is killed."""

    def start(agents: AgentProcesses, name: str) -> None:
        command = [*COMMAND, "agent", str(agents.file), "--name", name]
        record = ["--record", str(folder / f"{name}.mcap")]
        agents.running[name] = subprocess.Popen([*command, *record], stderr=subprocess.DEVNULL)

    monkeypatch.setattr(AgentProcesses, "start", start)
    with run_patrol(1000) as agents:
        subprocess.run(
            ["cp", "-r", agents.file.parent, agents.file.parent.parent / "library", folder], check=True
        )

        def count_ordered() -> int:
            found = [answer.status for answer in agents.ask("status").values()]
            return sum(
                each is not None and each.armed is not None and each.order is not None for each in found
            )

        wait_until(lambda: count_ordered() == 4, "the robots were never ordered")
        agents.running[SQUAD].kill()
        wait_until(lambda: agents.find_leaders() not in ([], [SQUAD]), "no deputy led")
        ticks = {name: answer.status.ticks for name, answer in agents.ask("status").items() if answer.status}

        def has_gone_on() -> bool:
            found = {name: each.status.ticks for name, each in agents.ask("status").items() if each.status}
            return all(found.get(name, 0) > before + 40 for name, before in ticks.items())

        wait_until(has_gone_on, "the robots did not go on")
        (deputy,) = agents.find_leaders()  # on a busy machine, the first may come too late
    return Recorded(sorted(folder.glob("*.mcap")), folder / "library", deputy)


def test_a_team_is_recorded_merged_and_explained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    paths, library, deputy = record(tmp_path, monkeypatch)
    assert [path.stem for path in paths] == [SQUAD, *(f"pioneer_{number}" for number in range(1, 5))]
    merged = tmp_path / "team.mcap"
    assert run("team", "merge", merged, *paths).exit_code == 0
    clock = read_team_clock(merged)
    assert clock is not None
    assert [each.whole for each in clock.members] == [False, True, True, True, True]
    for each in clock.members:  # in truth, all have the clock of this computer
        assert abs(each.ahead_s) <= each.error_s + 1e-3
    decide_again(merged, library, tmp_path / "files" / "team.toml", deputy)
    explain(merged, library, clock.start_ns, deputy)


def decide_again(merged: Path, library: Path, file: Path, deputy: str) -> None:
    """Robots and both coordinators decide as they did, on the orders that they had."""
    team = read_team_recording(merged)
    assert team is not None
    assert set(team.parts) >= {
        f"{SQUAD}/{SQUAD}",
        f"{SQUAD}/{deputy}",
        *(f"pioneer_{each}" for each in range(1, 5)),
    }  # at the beginning, others may lead until the first choice has started
    libraries = load_team_plan(file, library=library).libraries
    for part in team.parts:
        recording = team.read_part(part)
        ran = recording.head.ran
        rerun = Rerun(recording, libraries, ran.sorts, ran.behavior, binding=ran.binding)
        paths = []
        while not rerun.is_over:
            rerun.tick()
            paths.append(rerun.paths[0])
        assert paths == list(recording.paths[0])
        assert len(recording.duties[0]) > 0


def explain(merged: Path, library: Path, start_ns: int, deputy: str) -> None:
    """A robot's order leads to the decision of the coordinator that gave it, on its own computer."""
    team = read_team_recording(merged)
    assert team is not None
    last_ns = 0
    robots = [f"pioneer_{number}" for number in range(1, 5)]
    follower = next(each for each in robots if format_part(SQUAD, each) not in team.parts)
    for name in (follower, deputy):
        last_ns = int(team.read_part(name).logged_ns[-1])
        why = said("why", merged, "--agent", name, "--time", (last_ns - start_ns) / 1e9, "-l", library)
        robot, coordinator = why["agents"]
        assert (robot["agent"], robot["host"], coordinator["agent"]) == (name, name, SQUAD)
        assert robot["order"]["squad"] == SQUAD
        assert robot["order"]["leader"] == deputy
        assert is_term_of(robot["order"]["order"][0], coordinator["host"], (SQUAD, *robots))
        assert (
            coordinator["time_s"]
            <= robot["order"]["heard_s"] + coordinator["error_s"] + robot["error_s"] + 0.1
        )
        (level,) = coordinator["levels"]
        assert level["decision"]["after"] == level["state"]
        assert {each["member"] for each in coordinator["reports"]} == set(robots)
    shown = run("why", merged, "--agent", SQUAD, "--time", (last_ns - start_ns) / 1e9, "-l", library)
    assert shown.exit_code == 0
    assert f"{SQUAD} (led by {deputy}) at" in shown.stdout
    ticks_ns = team.read_part(follower).logged_ns
    lasts_s = (int(ticks_ns[-1]) - int(ticks_ns[0])) / 1e9
    own = merged.parent / f"{follower}.mcap"
    alone = run("why", own, "--agent", follower, "--time", lasts_s, "-l", library)
    assert "is not in this file" in alone.stdout, alone.output
    assert run("why", merged, "--agent", "nobody", "--time", 1, "-l", library).exit_code == 2
    assert run("why", merged, "--agent", SQUAD, "--time", 1e6, "-l", library).exit_code == 2
