"""Episodes of traces, journals and recordings: they have what the world sensed and what the agents decided."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.make.sessions import make_session, play
from tests.make.transcripts import FOLDER

from understudy import RecordedPress, make_team, read_lesson, read_records
from understudy.errors import FileError
from understudy.model.features import format_reading_label
from understudy.model.lesson import ExampleKind
from understudy.model.value_kinds import BOOLEAN, Continuous, Toroidal
from understudy.records.record import Record
from understudy.records.trace_writer import add_team_tick, describe_trace_columns, write_trace
from understudy.runtime.team.team import Team
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.sim.world import World
from understudy.training.journal import RobotMoved, read_journal
from understudy.ui.cli.named_inputs import assign_run

RUNS, JOURNALS = FOLDER / "runs", FOLDER / "journals"
DIRECTIVE, CONFIRMATION = ExampleKind.DIRECTIVE, ExampleKind.CONFIRMATION


def make_patrol() -> Team:
    """A team of four robots with a coordinator, and its world of seed 2."""
    scenario = find_scenario("patrol")
    assigned = assign_run(scenario, "lead", FOLDER / "squad", make_scenario_kit(scenario), None)
    return make_team(scenario, [2], assigned.libraries, assigned.roots)


def trace_patrol(path: Path, ticks: int) -> dict[str, list[Any]]:
    """Trace a patrol; return what was sensed, commanded and decided, by agent, in each tick."""
    team = make_patrol()
    world = team.ground
    assert isinstance(world, World)
    known: dict[str, list[Any]] = {}
    robots, squad = team.layers
    with write_trace(
        path,
        scenario="patrol",
        seed=2,
        tick_s=world.tick_s,
        robots=4,
        columns=describe_trace_columns(team),
    ) as trace:
        for _ in range(ticks):
            sensed = world.sense(robots.runner.keys)
            team.tick()
            view = world.view()
            add_team_tick(trace, team, view.time_s, view.pose, team.paths)
            for robot in range(4):
                values = {format_reading_label(key): float(sensed[key][robot]) for key in sensed}
                commands = {channel: float(column[robot]) for channel, column in robots.commands.items()}
                known.setdefault(f"robot {robot}", []).append((values, commands, team.paths[robot]))
            statistics = {
                format_reading_label(key): float(squad.percept[key][0]) for key in squad.runner.keys
            }
            known.setdefault("patrol 0", []).append((statistics, {}, squad.runner.path(0)))
    return known


def list_ticks(episode: Record) -> list[Any]:
    """What an episode has of each tick: readings, commands and states."""
    return [
        (
            {label: float(column[tick]) for label, column in episode.columns.items()},
            {
                each.name: float(episode.commands[tick, column])
                for column, each in enumerate(episode.channels)
            },
            episode.states[tick],
        )
        for tick in range(episode.ticks)
    ]


@pytest.mark.parametrize("ending", ["jsonl", "parquet"])
def test_a_trace_has_what_was_sensed_decided_and_commanded(ending: str, tmp_path: Path) -> None:
    if ending == "parquet":
        pytest.importorskip("duckdb", reason="needs the extra parquet")
    path = tmp_path / f"run.{ending}"
    known = trace_patrol(path, 60)
    episodes = read_records(path)
    assert [each.agent for each in episodes] == ["robot 0", "robot 1", "robot 2", "robot 3", "patrol 0"]
    for each in episodes:
        assert repr(list_ticks(each)) == repr(known[each.agent])  # absent is NaN, which equals nothing
        assert each.seed == 2
        assert np.allclose(each.times, [0.1 * (tick + 1) for tick in range(60)])
    assert episodes[0].find_kind(("sonar_front_left", None)) == Continuous()
    assert {each.kind for each in episodes[4].readings} == {BOOLEAN}
    assert all(set(each.pose) == {"x", "y", "heading"} for each in episodes[:4])
    assert (episodes[4].pose, episodes[4].channels) == ({}, ())
    assert any(np.isnan(column).any() for column in episodes[0].values.values())


@pytest.mark.parametrize("ending", ["jsonl", "parquet"])
def test_traces_of_version_1_have_no_readings(ending: str) -> None:
    if ending == "parquet":
        pytest.importorskip("duckdb", reason="needs the extra parquet")
    (episode,) = read_records(RUNS / f"forage.{ending}")
    rows = [json.loads(line) for line in (RUNS / "forage.jsonl").read_text().splitlines()[1:]]
    assert episode.times.tolist() == [row["time_s"] for row in rows]
    assert [" > ".join(path) for path in episode.states] == [row["doing"] for row in rows]
    assert episode.pose["x"].tolist() == [row["x"] for row in rows]
    assert (episode.values, episode.channels, episode.behavior) == ({}, (), "forage")


def test_an_interrupted_trace_is_read(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    trace_patrol(path, 3)
    path.write_bytes(path.read_bytes()[:-20])
    assert [each.ticks for each in read_records(path)] == [3, 3, 3, 3, 2]
    assert "its last line has no end" in read_records(path)[0].omissions[0]


PLAYED = ("forward", 3, "left", 2, "confirm", 2, "right", 1)
PRESSES = (
    RecordedPress(0, "forward", False, DIRECTIVE),
    RecordedPress(3, "left", False, DIRECTIVE),
    RecordedPress(5, None, False, CONFIRMATION),
    RecordedPress(7, "right", False, DIRECTIVE),
)
STATES = ["forward"] * 3 + ["left"] * 4 + ["right"]


def test_a_journal_has_readings_presses_and_states(tmp_path: Path) -> None:
    path = tmp_path / "taught.journal"
    taught = play(make_session(journal=path), *PLAYED)
    taught.close()
    (episode,) = read_records(path)
    assert episode.states == tuple((state,) for state in STATES)
    assert episode.presses == PRESSES
    assert episode.columns["range(ball)"].tolist() == [100.0 - tick for tick in range(8)]
    assert episode.columns["seen"].tolist() == [0.0, 1.0] * 4
    assert np.allclose(episode.times, np.arange(8) * 0.1)
    assert episode.find_kind(("bearing", "goal")) == Toroidal()
    assert episode.find_kind(("seen", None)) == BOOLEAN
    assert (episode.behavior, episode.tick_s, episode.agent) == ("taught", 0.1, "agent 0")
    lesson = read_lesson(path)
    assert [(each.state, each.next, each.values) for each in lesson.examples] == [
        (each.state, each.next, each.values) for each in taught.lesson.examples
    ]


def test_corrections_in_a_journal_are_said_to_be_some(tmp_path: Path) -> None:
    path = tmp_path / "taught.journal"
    play(make_session(journal=path), "forward", 3, "left", 2, "test", 2, "right", 1).close()
    presses = [press for episode in read_records(path) for press in episode.presses]
    assert [(press.state, press.correction) for press in presses] == [
        ("forward", False),
        ("left", False),
        ("right", True),
    ]


def test_the_states_of_a_journal_are_those_after_each_tick(tmp_path: Path) -> None:
    path = tmp_path / "taught.journal"
    taught = play(make_session(journal=path), "forward", 3, "left", 2, "test")
    states = []
    for _ in range(4):
        taught.tick()
        states.append((taught.trainee.taught.state_name,))
    taught.close()
    assert states == [("forward",), ("left",), ("left",), ("left",)]
    assert read_records(path)[-1].states == tuple(states)


def test_a_press_that_was_taken_back_before_it_acted_is_none(tmp_path: Path) -> None:
    path = tmp_path / "taught.journal"
    play(make_session(journal=path), "forward", 2, "left", "right", 1, "left", "undo", 1).close()
    (episode,) = read_records(path)
    assert [(press.tick, press.state) for press in episode.presses] == [(0, "forward"), (2, "right")]


@pytest.mark.parametrize("name", ["steps", "random-1", "random-2", "random-3"])
def test_a_restart_begins_another_episode(name: str) -> None:
    path = JOURNALS / f"{name}.journal"
    episodes = read_records(path)
    assert 1 < len(episodes) <= 1 + sum(isinstance(entry, RobotMoved) for entry in read_journal(path))
    for each in episodes:
        assert np.allclose(np.diff(each.times), each.tick_s)
        assert all(0 <= press.tick < each.ticks for press in each.presses)
        assert len(each.states) == each.ticks == len(each.columns["load"])
    assert "does not say kinds" in episodes[0].omissions[0]  # journals of 0.1.0


@pytest.mark.parametrize("path", sorted(JOURNALS.glob("*.journal")), ids=lambda path: path.stem)
def test_directives_lead_to_the_state_that_was_pressed(path: Path) -> None:
    """Presses and states are of the same ticks."""
    found = [
        (press.state, episode.states[press.tick])
        for episode in read_records(path)
        for press in episode.presses
        if press.kind is DIRECTIVE and not press.correction
    ]
    assert found
    assert all((state,) == states for state, states in found)


def need_recordings() -> None:
    pytest.importorskip("rosbags", reason="needs the extra ros2")
    pytest.importorskip("mcap", reason="needs the extra ros2")


def test_a_recording_has_readings_and_states() -> None:
    need_recordings()
    from understudy.records.reader import read_recording

    recording = read_recording(RUNS / "forage.mcap")
    (episode,) = read_records(RUNS / "forage.mcap")
    assert (episode.agent, episode.behavior, episode.ticks) == ("robot 0", "forage", 200)
    assert episode.states == recording.records[0].states
    for key, column in episode.values.items():
        assert np.array_equal(column, recording.records[0].values[key], equal_nan=True)


def test_a_recording_has_presses_and_corrections() -> None:
    need_recordings()
    (episode,) = read_records(RUNS / "lesson.mcap")
    assert [(press.tick, press.state, press.correction) for press in episode.list_presses()] == [
        (0, "forward", False),
        (7, "right", False),
        (15, None, False),
        (22, "right", False),
        (30, "forward", False),
        (45, "left", True),
        (66, "forward", True),
    ]
    (rover,) = read_records(RUNS / "rover.mcap")
    assert (rover.agent, rover.list_presses()) == ("rover", [RecordedPress(3, None)])


def test_each_run_of_a_recording_is_an_episode(tmp_path: Path) -> None:
    need_recordings()
    from tests.bodies import Scripted

    from understudy.records.recorder import RunRecorder

    body = Scripted(2)
    keys = [("load", None), ("range", "ball")]
    with RunRecorder(tmp_path / "runs.mcap", clock=lambda: body.time_s) as recorder:
        for ticks in (2, 3):
            recorder.begin(body)
            for _ in range(ticks):
                recorder.write_tick(body.time_s, body.sense(keys), [("a",), ("b", "c")])
                body.act({})
    episodes = read_records(tmp_path / "runs.mcap")
    assert [(each.agent, each.ticks) for each in episodes] == [
        ("robot0", 2), ("robot1", 2), ("robot0", 3), ("robot1", 3),
    ]  # fmt: skip
    assert episodes[3].columns["range(ball)"].tolist() == [99.0, 98.0, 97.0]
    assert episodes[3].states == (("b", "c"),) * 3


def test_each_part_of_a_teams_recording_is_an_episode(tmp_path: Path) -> None:
    need_recordings()
    from tests.bodies import Scripted

    from understudy.records.header import RunInfo
    from understudy.records.recorder import RunRecorder

    body = Scripted(1)
    keys = (("load", None),)
    with RunRecorder(tmp_path / "scout.mcap", clock=lambda: body.time_s) as recorder:
        recorder.begin(body, names=["scout"], ran=RunInfo(behavior="wander", agent="scout"))
        leads = recorder.open_part(
            "squad/scout", body, ran=RunInfo(behavior="lead", agent="scout", squad="squad")
        )
        for _ in range(2):
            percept = body.sense(keys)
            recorder.write_tick(body.time_s, percept, [("wander", "forward")])
            leads.write_tick(body.time_s, keys, [7.0], ("out",))
            body.act({})
    robot, squad = read_records(tmp_path / "scout.mcap")
    assert (robot.agent, robot.behavior, robot.states) == ("scout", "wander", (("wander", "forward"),) * 2)
    assert (squad.agent, squad.behavior, squad.states) == ("squad/scout", "lead", (("out",),) * 2)
    assert (robot.columns["load"].tolist(), squad.columns["load"].tolist()) == ([0.0, 0.0], [7.0, 7.0])


BAD: list[tuple[str, bytes | None, str]] = [
    ("run.txt", b"hello", "it is neither a journal nor a recording nor a trace; name a session's journal"),
    ("run.journal", b"", "it is empty; name a session's journal, a recording"),
    ("run.journal", None, "reading it failed: No such file or directory; name a session's journal"),
    ("run.jsonl", b"", "it is not a trace of a run; name a file that `understudy run --trace` wrote"),
    ("run.jsonl", b'{"format":"understudy trace","version":3}\n', "its version is 3; read it with the version of"),
    ("run.mcap", None, "there is no such file; name a file that `understudy run --record"),
    ("run.mcap", b"hello", "it is not an MCAP file"),
    ("run.parquet", b"hello", "it cannot be read"),
]  # fmt: skip
HEADER = b'{"format":"understudy trace","version":2,"scenario":"x","seed":1,"tick_s":0.1,"robots":1,"readings":{"a":{"kind":"continuous"}}}\n'  # noqa: E501
BAD += [
    ("run.jsonl", HEADER, "the trace has no tick; name a trace of a run that"),
    ("run.jsonl", HEADER + b'{"time_s":0.1,"robot":0,"doing":"x"}\n', "a line of it is not as traces have them"),
    ("run.jsonl", HEADER + b"{\n", "a line of it cannot be read"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "content", "says"), BAD)
def test_other_files_are_refused_in_one_sentence(
    name: str, content: bytes | None, says: str, tmp_path: Path
) -> None:
    if name.endswith(".mcap"):
        need_recordings()
    if name.endswith(".parquet"):
        pytest.importorskip("duckdb", reason="needs the extra parquet")
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(FileError) as caught:
        read_records(path)
    assert str(caught.value).startswith(f"{path}: {says}")


def test_a_journal_without_ticks_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "taught.journal"
    make_session(journal=path).close()
    with pytest.raises(FileError, match="its session has no tick; name the journal of a session that ran"):
        read_records(path)


OTHERS = ["runs/forage.jsonl", "runs/forage.mcap", "library"]


@pytest.mark.parametrize("name", OTHERS)
def test_what_has_no_lesson_is_refused(name: str) -> None:
    with pytest.raises(FileError, match=r"name a library's document|a session's journal"):
        read_lesson(FOLDER / name)


def test_lessons_are_read_without_their_kit() -> None:
    lesson = read_lesson(FOLDER / "library" / "goto.json")
    assert [str(bound) for bound in lesson.automaton.features] == ["distance_to(A)", "angle_to(A)"]
    assert len(lesson.examples) > 10
