"""`understudy run --team`: all agents in one program, on real robots, as a team without agents decides."""

from __future__ import annotations

from pathlib import Path
from random import Random
from typing import TypeAlias

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import odometry
from tests.robots.twins import Rig
from tests.ui.cli.commands import run_json

from understudy.addons.robots.team_network.load_plan import open_libraries
from understudy.model.features import BoundFeature, TimeInState
from understudy.model.library import TrainedAutomaton
from understudy.records.header import RunInfo
from understudy.records.reader import read_recording
from understudy.records.recorder import RunRecorder
from understudy.runtime.team.team import Team
from understudy.sim.catalog import find_scenario
from understudy.sim.team.assignment import assign_team_members
from understudy.storage.library_folder import save_automaton
from understudy.ui.cli.commands.run_robot import LiveRun
from understudy_lab.tree_builder import TreeBranch, build_automaton, split_below, split_on_flag

NAMES = ("one", "two", "three", "four")
TICKS = 120
Decisions: TypeAlias = list[tuple[list[tuple[str, ...]], list[tuple[float, float]]]]
"""The states of all robots in each tick, and what each was sent."""


SCENARIO = find_scenario("patrol")


def save_library(folder: Path) -> None:
    """Save robots that walk for a while, and a coordinator that lets them turn then, and wait for who is missing."""
    time_in_state = BoundFeature(TimeInState())
    walking: dict[str, TreeBranch] = {
        "start": "forwards", "forwards": split_below("time_in_state", 1.45, "forwards", "done")
    }  # fmt: skip
    walk = build_automaton(
        "walk", walking, readings={"time_in_state": time_in_state}, flags=("done",), basics=("forwards",)
    )
    save_automaton(folder, TrainedAutomaton(walk))
    features = open_libraries(SCENARIO, folder)["patrol"].kit.features
    readings = {name: BoundFeature(features[name]) for name in ("all_done", "present")}
    everybody = split_below("present", 3.5, "wait", "walk")
    led: dict[str, TreeBranch] = {
        "start": "walk",
        "walk": split_on_flag("all_done", "left", everybody),
        "left": split_below("time_in_state", 0.95, "left", "walk"),
        "wait": everybody,
    }
    lead = build_automaton(
        "lead",
        led,
        readings={**readings, "time_in_state": time_in_state},
        runs={"walk": "walk", "left": "left", "wait": "backwards"},
    )
    save_automaton(folder / "patrol", TrainedAutomaton(lead))


def decide(rig: Rig, folder: Path, *, agents: bool, disarms: bool) -> Decisions:
    """What the robots do in the same circumstances, in one program with or without agents."""
    libraries = open_libraries(rig.twin.scenario, folder)
    roots: dict[str, tuple[str, dict[str, str]]] = {"patrol": ("lead", {})}
    run = LiveRun(rig.twin, libraries, roots)
    team = run.team if agents else Team(rig.twin, assign_team_members(rig.twin.scenario), libraries, roots)
    draws, found = Random(4), Decisions()
    rig.twin.follow(lambda: team.paths)
    rig.send_odometry()
    rig.twin.fleet.arm("a test")
    run.restart()
    team.clear()
    if agents:
        rig.twin.record(RunInfo(library=str(folder), sorts=["patrol"], behavior="lead"))
    for tick in range(TICKS):
        if disarms and tick == TICKS // 2:  # it is not counted then
            rig.robots[1].disarm("a test")
        if disarms and tick == TICKS // 2 + 20:
            rig.robots[1].arm("a test")
        rig.now += draws.choice((0.1, 0.13, 0.7)) if tick % 9 == 0 else 0.1
        for robot in range(len(NAMES)):
            rig.hear(robot, odometry(draws.uniform(0.0, 2.5)))
        team.tick()
        found.append((list(team.paths), [rig.sent(robot) for robot in range(len(NAMES))]))
    rig.twin.close()
    return found


@pytest.mark.parametrize("disarms", [False, True])
def test_agents_in_one_program_do_what_a_team_does(disarms: bool, tmp_path: Path) -> None:
    """On the same readings, tick by tick, up to the commands behind the guards."""
    folder = tmp_path / "library"
    save_library(folder)
    found = decide(Rig(NAMES, "patrol"), folder, agents=True, disarms=disarms)
    assert found == decide(Rig(NAMES, "patrol"), folder, agents=False, disarms=disarms)
    ordered = [paths[0] for paths, _ in found]
    assert {path[0] for path in ordered} == {"walk", "left", *(["backwards"] if disarms else [])}
    assert len({sent for _, commands in found for sent in commands}) > 2


def test_a_recorded_run_of_agents_in_one_program_decides_again(tmp_path: Path) -> None:
    folder, path = tmp_path / "library", tmp_path / "run.mcap"
    save_library(folder)
    with RunRecorder(path, clock=lambda: 0.0) as recorder:
        found = decide(Rig(NAMES, "patrol", recorder=recorder), folder, agents=True, disarms=False)
    recording = read_recording(path)
    assert list(recording.records[2].states) == [paths[2] for paths, _ in found]
    again = run_json("run", "--replay", path)
    assert (again["decisions"], again["differences"]) == (len(NAMES) * TICKS, [])
    why = run_json("why", path, "--agent", 3, "--time", 3.0, "-l", folder)
    assert len(why["agents"]) == 2  # the robot and its coordinator
