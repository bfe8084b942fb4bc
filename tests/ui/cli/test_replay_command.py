"""Deciding again over recordings, and learning from them: run --record, run --replay, learn --recording."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from shutil import rmtree

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("mcap", reason="needs the extra ros2")

from tests.robots.rovers import ROVER, Wire, odometry, sonar
from tests.robots.twins import Rig as Twins
from tests.sim.patrollers import ROBOTS
from tests.simulated_clock import ReadOnlyClock
from tests.ui.cli.commands import run, run_json

from understudy.addons.robots.recording_transport import RecordingTransport
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Percept, TimeInState
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.records.header import RunInfo
from understudy.records.reader import read_recording
from understudy.records.recorder import RunRecorder
from understudy.runtime.body import Commands, list_reading_keys
from understudy.runtime.link import link
from understudy.runtime.run_loop import Run
from understudy.storage.library_folder import open_library, save_automaton
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy.ui.cli.commands.run_robot import LiveRun
from understudy.ui.cli.named_inputs import find_kit
from understudy_lab.bench.patrol import lead


class Rig(Twins):
    """Robots whose clock waits as it is told to."""

    def wait(self, seconds: float) -> None:
        self.now += seconds


KIT = find_kit(None, "arena")


def after(seconds: float, state: int) -> Tree:
    """To a state once so long in this one, or where something is near."""
    return Tree(
        (
            Node(TestKind.BELOW, 0, high=seconds, yes=1, no=4),
            Node(TestKind.BELOW, 1, high=0.5, yes=2, no=3),
            make_leaf(state),
            make_leaf(STAY),
            make_leaf(state),
        )
    )


WANDER = Automaton(
    "wander",
    (START, State("forward", "forward"), State("left", "rotate_left")),
    (BoundFeature(TimeInState()), BoundFeature(KIT.features["sonar_ahead"])),
    (),
    False,
    {"start": after(0.35, 1), "forward": after(1.05, 2), "left": after(0.55, 1)},
)


def test_a_run_decides_again_as_recorded(library: Path, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    told = run_json("run", "-l", library, "--seed", "1", "--seconds", "40", "--record", path)
    assert (told["seconds"], told["record"]) == (40.0, str(path))
    again = run_json("run", "--replay", path)
    assert (again["behavior"], again["ticks"], again["same"], again["differences"]) == (
        "forage",
        400,
        400,
        [],
    )
    assert (again["whole"], again["changed"], again["library"]) == (True, [], str(library))
    shown = run("run", "--replay", path)
    assert shown.stdout == "forage over 400 ticks (40.0 s): every decision as recorded\n"


def test_where_another_library_decides_otherwise_is_shown(library: Path, tmp_path: Path) -> None:
    """A GoTo that is content with 0.4 m: done earlier, for the distance that was read there."""
    path, other = tmp_path / "run.mcap", tmp_path / "other"
    run_json("run", "-l", library, "--seed", "1", "--seconds", "10", "--record", path)
    other.mkdir()
    for file in library.glob("*.json"):
        content = file.read_text(encoding="utf-8")
        if file.stem == "goto":
            content = content.replace('"cut": 0.3,', '"cut": 0.4,')
        (other / file.name).write_text(content, encoding="utf-8")
    result = run("run", "--replay", path, "-l", other, "--json")
    assert result.exit_code == 1
    told = json.loads(result.stdout)
    assert told["changed"] == ["goto"]
    (first,) = told["differences"]
    assert first["recorded"] == ["harvest", "goto", "forward"]
    assert first["now"] == ["harvest", "goto", "done"]
    decision = first["decision"]
    assert (decision["automaton"], decision["before"], decision["after"]) == (
        "goto(nearest_food)",
        "forward",
        "done",
    )
    assert decision["conditions"] == ["distance_to(A) is below 0.4 m"]
    recording = read_recording(path)
    tick = int(np.searchsorted(recording.times, first["time_s"] - 1e-6))
    distance = recording.records[0].values["range", "nearest_food"][tick]
    assert 0.3 <= distance < 0.4
    assert decision["values"]["distance_to(A)"] == distance
    assert told["same"] == told["decisions"] - first["ticks"]
    shown = run("run", "--replay", path, "-l", other).stdout
    assert "goto is another since it was recorded" in shown
    assert "recorded harvest > goto > forward, now harvest > goto > done" in shown
    assert "it read distance_to(A) = 0." in shown


def test_what_has_changed_since_decides_as_it_was(tmp_path: Path) -> None:
    """Unless a library is named: then it is asked as it is."""
    folder, path = tmp_path / "library", tmp_path / "run.mcap"
    save_automaton(folder, TrainedAutomaton(WANDER))
    run_json("run", "arena", "-l", folder, "--behavior", "wander", "--seconds", "5", "--record", path)
    save_automaton(
        folder,
        TrainedAutomaton(replace(WANDER, transitions={**WANDER.transitions, "forward": after(2.0, 2)})),
    )
    told = run_json("run", "--replay", path)
    assert (told["former"], told["differences"]) == ({"wander": 1}, [])
    assert "wander is another by now: this is its version 1" in run("run", "--replay", path).stdout
    now = run("run", "--replay", path, "-l", folder, "--json")
    assert now.exit_code == 1
    assert json.loads(now.stdout)["changed"] == ["wander"]
    (folder / "wander.json").unlink()
    assert run_json("run", "--replay", path)["differences"] == []
    rmtree(folder / "versions")
    gone = run("run", "--replay", path)
    assert gone.exit_code == 2
    assert "'wander'" in gone.stderr


def test_a_coordinator_decides_again_as_recorded(tmp_path: Path) -> None:
    """What squads read follows from what their robots read, so the robots' readings are enough."""
    library, path = tmp_path / "library", tmp_path / "run.mcap"
    for automaton in (ROBOTS.automaton(name) for name in ROBOTS.taught):
        save_automaton(library, TrainedAutomaton(automaton))
    save_automaton(library / "patrol", TrainedAutomaton(lead()))
    told = run_json(
        "run", "patrol", "-l", library, "--behavior", "lead", "--seconds", "120", "--record", path
    )
    assert told["robots"] == 4
    recording = read_recording(path)
    assert len({path[0] for path in recording.records[0].states}) > 1  # it was ordered to do several things
    again = run_json("run", "--replay", path)
    assert (again["decisions"], again["differences"]) == (4 * recording.ticks, [])


def test_a_robot_decides_again_as_recorded(tmp_path: Path) -> None:
    """Readings come late and irregularly from a real one; a run begins at any time of its clock."""
    folder, path = tmp_path / "library", tmp_path / "run.mcap"
    save_automaton(folder, TrainedAutomaton(WANDER))
    library = open_library(folder, KIT).library
    now, wire = [100.0], Wire()
    with RunRecorder(path, clock=lambda: now[0]) as recorder:
        robot = Robot(
            parse_robot(ROVER), RecordingTransport(wire, recorder), clock=ReadOnlyClock(lambda: now[0])
        )
        now[0] += 3.7
        going = Run.from_program(robot, link(library, "wander", {}))
        ran = RunInfo(scenario="arena", library=str(folder), sorts=["robot"], behavior="wander")
        recorder.begin(robot, names=["rover"], ran=ran, files={"rover.toml": ROVER})
        for tick in range(60):
            if tick in (15, 31):  # between two ticks, when its clock stands at the one before
                going.begin([0], going.interpreters[0].program)
                recorder.write_step("restart")
            now[0] += 0.1 + 0.003 * (tick % 5)
            if tick % 4 == 1:
                wire.deliver("/rover/sonar", sonar((3.0, 0.4, 0.4, 2.0)[tick // 4 % 4]), now[0] - 0.02)
            percept = robot.sense(list_reading_keys(robot))
            going.tick()
            recorder.write_tick(robot.time_s, percept, [going.path(0)])
    recorded = read_recording(path).records[0].states
    assert recorded[0] == ("forward",)  # 3.8 s after it began: long enough in start
    assert sum(one != other for one, other in pairwise(recorded)) > 12
    assert recorded[15] == recorded[31] == ("start",)
    assert run_json("run", "--replay", path)["differences"] == []


@pytest.mark.parametrize("slow_s", [0.0, 0.12])
def test_robots_of_a_team_decide_again_as_recorded(
    slow_s: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As they are run live: armed after a while, when everybody begins anew, and with ticks that come late. Where
    deciding takes longer than a tick, recorded is what was decided on, not what had come by then.
    """
    folder, path = tmp_path / "library", tmp_path / "run.mcap"
    near = BoundFeature(KIT.features["distance_to"], Binding(A="red_flag"))
    save_automaton(
        folder,
        TrainedAutomaton(replace(WANDER, name="approach", features=(BoundFeature(TimeInState()), near))),
    )
    libraries = dict.fromkeys(["rover"], open_library(folder, KIT).library)
    with RunRecorder(path, clock=lambda: 0.0) as recorder:
        rig = Rig(recorder=recorder)
        live = LiveRun(
            rig.twin, libraries, {"rover": ("approach", {})}, clock=lambda: rig.now, sleep=rig.wait
        )
        tick = 0

        def heard(every: int) -> None:
            if tick % every == 0:
                rig.hear(0, odometry(2.6 * (tick % 40) / 40))
                rig.hear(1, odometry(2.6 * (tick % 33) / 33))

        rig.twin.follow(lambda: live.team.paths)
        runner = live.team.runner
        decide = runner.decide

        def slowly(percept: Percept) -> Commands:
            commands = decide(percept)
            rig.now += slow_s
            heard(1)
            return commands

        monkeypatch.setattr(runner, "decide", slowly)
        for tick in range(80):
            heard(3)
            if tick == 12:
                live.restart()
                rig.twin.record(RunInfo(library=str(folder), sorts=["rover"], behavior="approach"))
            rig.now += 0.07 * (tick % 7 == 3)
            live.tick()
    recorded = read_recording(path)
    assert (recorded.ticks, len(recorded.records)) == (68, 2)
    assert all(len({path[0] for path in each.states}) == 3 for each in recorded.records)
    assert run_json("run", "--replay", path)["differences"] == []


def test_a_basic_behavior_is_decided_again(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    run_json(
        "run", "arena", "-l", tmp_path / "none", "--behavior", "forward", "--seconds", "2", "--record", path
    )
    assert run_json("run", "--replay", path)["same"] == 20
    assert run_json("why", path, "--time", "1")["agents"][0]["levels"] == []


def test_what_is_no_recording_is_refused(tmp_path: Path, library: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(b"no")
    refused = run("run", "--replay", tmp_path / "a.mcap")
    assert refused.exit_code == 2
    assert "it is not an MCAP file" in refused.stderr
    again = run("run", "-l", library, "--seconds", "1", "--record", tmp_path / "a.mcap")
    assert again.exit_code == 2
    assert "is there already" in again.stderr
    both = run("run", "arena", "--replay", tmp_path / "a.mcap")
    assert both.exit_code == 2
    assert "SCENARIO is not used with --replay" in both.stderr


def test_presses_over_a_recording_are_learned(tmp_path: Path) -> None:
    """A robot that only drove ahead, and somebody who says afterwards where it ought to have turned."""
    recording, presses, library = tmp_path / "run.mcap", tmp_path / "presses.csv", tmp_path / "library"
    run_json("run", "arena", "--behavior", "forward", "--seconds", "8", "--record", recording)
    found = read_recording(recording)
    ahead = found.records[0].values[("sonar_ahead", None)]
    near = int(np.argmax(ahead < 0.6))
    assert near > 10
    presses.write_text(f"time_s,state\n0,forward\n{found.times[near]:.2f},rotate_left\n", encoding="utf-8")
    options = ("--recording", recording, "--presses", presses, "--features", "sonar_ahead")
    told = run_json("learn", *options, "-l", library, "-n", "wander")
    assert told["states"]["forward"]["conditions"][0] == "rotate_left when sonar_ahead is below 0.6 m"
    again = run("run", "--replay", recording, "-l", library, "--behavior", "wander", "--json")
    taught = json.loads(again.stdout)["differences"][0]
    assert (again.exit_code, taught["now"]) == (1, ["forward"])
    more = run_json("learn", "--recording", recording, "--presses", presses, "-l", library, "-n", "wander")
    assert more["states"]["forward"]["contradictions"] == 0


@pytest.fixture
def toward(tmp_path: Path) -> Path:
    """A recording of a robot that went to the station, with presses of somebody who watched it."""
    from understudy.sim.forage import FORAGE_KIT, Forage

    lesson = new_lesson(
        Library(FORAGE_KIT),
        "goto",
        states=["forward", "rotate_left"],
        flags=["done"],
        features=["distance_to(A)", "angle_to(A)"],
        parameters=["A"],
        live=False,
    )
    session = Session(Forage([42]), Library(FORAGE_KIT), lesson, targets={"A": "station"})
    pressed = {0: "rotate_left", 9: "forward", 39: "rotate_left", 44: "forward", 49: "done"}
    with RunRecorder(tmp_path / "goto.mcap", clock=lambda: session.body.time_s) as recorder:
        recorder.begin(session.body, ran=RunInfo(scenario="forage"))
        for tick in range(50):
            if tick in pressed:
                recorder.write_press(pressed[tick])
                session.direct(pressed[tick])
            time_s, percept = session.body.time_s, session.percept
            session.tick()
            recorder.write_tick(time_s, percept, [session.trainee.path], at_s=time_s)
    save_automaton(tmp_path / "shown", session.make_trained_automaton())
    return tmp_path / "goto.mcap"


GOTO = ("--parameters", "A", "--targets", "A=station", "--features", "distance_to(A),angle_to(A)")


def test_presses_that_were_recorded_are_learned(toward: Path, tmp_path: Path) -> None:
    """The same automaton as the session's; `done`, which is no behavior, is taken for a flag."""
    told = run_json("learn", "--recording", toward, *GOTO, "-l", tmp_path / "again", "-n", "goto")
    assert list(told["states"]) == ["start", "rotate_left", "forward"]
    shown, again = (
        open_library(tmp_path / folder, find_kit(None, "forage")).library.taught["goto"]
        for folder in ("shown", "again")
    )
    assert shown.lesson is not None
    assert again.lesson is not None
    assert again.lesson.examples == shown.lesson.examples
    assert again.automaton.flags == ("done",)
    asked = run("run", "--replay", toward)
    assert "--behavior is missing: nothing ran, a person taught" in asked.stderr
    asked = run("run", "--replay", toward, "--behavior", "goto")
    assert "--library is missing: nothing ran" in asked.stderr
    options = ("-l", tmp_path / "again", "--behavior", "goto", "--bind", "A=station")
    beside = json.loads(run("run", "--replay", toward, *options, "--json").stdout)
    assert (beside["decisions"], beside["differences"][0]["recorded"]) == (50, ["rotate_left"])


def test_presses_are_added_to_a_lesson(toward: Path, tmp_path: Path) -> None:
    more = tmp_path / "more.csv"
    more.write_text("time_s,state\n0,rotate_left\n1,\n", encoding="utf-8")
    options = ("--recording", toward, "--presses", more, "--targets", "A=station")
    told = run_json("learn", *options, "-l", tmp_path / "shown", "-n", "goto")
    assert told["saved"].endswith("goto.json")
    lesson = open_library(tmp_path / "shown", find_kit(None, "forage")).library.taught["goto"].lesson
    assert lesson is not None
    assert [str(each.kind) for each in lesson.examples[-3:]] == ["directive", "default", "confirmation"]
    assert len(lesson.examples) == 9 + 3


REFUSED = [
    ((), "--features is missing; give --features"),
    ((*GOTO, "--agent", "1"), "--agent is 1; count from 0 to 0"),
    (("lesson.csv", *GOTO), "LESSON.csv is one too many beside a recording"),
    ((*GOTO, "--targets", "A=moon"), "the body has no target 'moon'"),
    ((*GOTO, "--states", "forward", "--flags", "done"), "has no state 'rotate_left'"),
    ((*GOTO, "--presses", "none.csv"), "none.csv: it cannot be read"),
    (("-l", "shown", "-n", "goto", "--features", "angle_to(A)"), "--features cannot be changed here"),
]


@pytest.mark.parametrize(("options", "problem"), REFUSED)
def test_a_lesson_that_cannot_be_is_refused(
    options: tuple[str, ...], problem: str, toward: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    refused = run("learn", "--recording", toward, *options)
    assert refused.exit_code == 2
    assert problem in " ".join(refused.stderr.split())


def test_a_table_or_a_recording_is_needed() -> None:
    assert "LESSON.csv is missing; give either a table, or --recording" in run("learn", "--json").stderr
