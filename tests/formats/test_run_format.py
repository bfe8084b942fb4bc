"""Traces and recordings of 0.1.0 are read, and runs of the same seed leave the same trace."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("mcap", reason="needs the extra ros2")
pytest.importorskip("sklearn", reason="needs the extra sklearn")

from tests.bodies import kit as scripted_kit
from tests.make.sessions import ROBOT
from tests.make.transcripts import FOLDER
from tests.ui.cli.commands import run, run_json

from understudy.addons.recordings.teach_from_recording import list_recorded_presses, teach_from_recording
from understudy.learning.fit import learn
from understudy.model.learner_options import LearnerOptions, TreeOptions
from understudy.records.reader import read_recording
from understudy.records.record import RecordedPress
from understudy.records.trace_writer import COLUMNS
from understudy.storage.document import decode_document, encode_document
from understudy.training.lesson_design import new_lesson

RUNS = FOLDER / "runs"
PLACE = "/tmp/v0_1_0"
"""Where the libraries were when the runs were made."""
TRACES: list[tuple[str, list[object]]] = [
    ("forage", ["-l", FOLDER / "library", "--behavior", "forage", "--seed", "1", "--seconds", "30"]),
    ("patrol", ["patrol", "-l", FOLDER / "squad", "--behavior", "lead", "--seed", "2", "--seconds", "8"]),
]


def lines(path: Path, place: str) -> list[dict[str, Any]]:
    """What version 1 has of a trace, with its library where it was."""
    header, *rows = map(json.loads, path.read_text(encoding="utf-8").replace(place, PLACE).splitlines())
    return [
        former(header),
        *({name: row[name] for name in COLUMNS} for row in rows if row["robot"] is not None),
    ]


def former(header: dict[str, Any]) -> dict[str, Any]:
    """The header of a trace as version 1 has it."""
    added = ("readings", "commands", "coordinators")
    return {key: value for key, value in {**header, "version": 1}.items() if key not in added}


@pytest.mark.parametrize(("name", "arguments"), TRACES)
def test_the_same_run_leaves_the_same_trace(name: str, arguments: list[object], tmp_path: Path) -> None:
    run_json("run", *arguments, "--trace", tmp_path / "again.jsonl")
    again = lines(tmp_path / "again.jsonl", str(FOLDER))
    assert again == lines(RUNS / f"{name}.jsonl", PLACE)
    assert len(again) > 300


def rows(path: Path) -> list[Any]:
    duckdb = pytest.importorskip("duckdb", reason="needs the extra parquet")
    found: list[Any] = duckdb.sql(f"SELECT {', '.join(COLUMNS)} FROM read_parquet('{path}')").fetchall()
    return found


def about(path: Path) -> dict[str, Any]:
    duckdb = pytest.importorskip("duckdb", reason="needs the extra parquet")
    ((value,),) = duckdb.sql(f"SELECT value FROM parquet_kv_metadata('{path}')").fetchall()
    return former(json.loads(bytes(value).decode().replace(str(FOLDER), PLACE)))


def test_the_same_run_leaves_the_same_table(tmp_path: Path) -> None:
    run_json("run", *TRACES[0][1], "--trace", tmp_path / "again.parquet")
    assert rows(tmp_path / "again.parquet") == rows(RUNS / "forage.parquet")
    assert about(tmp_path / "again.parquet") == about(RUNS / "forage.parquet")
    header = (RUNS / "forage.jsonl").read_text(encoding="utf-8").splitlines()[0]
    assert about(RUNS / "forage.parquet") == json.loads(header)


@pytest.mark.parametrize("ending", ["jsonl", "parquet"])
def test_a_trace_is_explained(ending: str) -> None:
    if ending == "parquet":
        pytest.importorskip("duckdb", reason="needs the extra parquet")
    told = run_json("why", RUNS / f"forage.{ending}", "--time", "12", "-l", FOLDER / "library")
    assert [each["automaton"] for each in told["agents"][0]["levels"]] == ["forage", "harvest"]


def test_a_recorded_run_is_decided_again() -> None:
    told = run_json("run", "--replay", RUNS / "forage.mcap", "-l", FOLDER / "library")
    assert (told["behavior"], told["ticks"], told["same"]) == ("forage", 200, 200)
    assert (told["whole"], told["changed"], told["differences"]) == (True, [], [])
    told = run_json("why", RUNS / "forage.mcap", "--time", "12", "-l", FOLDER / "library")
    assert [each["automaton"] for each in told["agents"][0]["levels"]] == ["forage", "harvest"]


def test_a_real_robots_recording_is_read() -> None:
    found = read_recording(RUNS / "rover.mcap")
    assert (found.ticks, found.whole, found.head.ran.behavior) == (4, True, "wander")
    sonar = found.records[0].values[("sonar_ahead", None)]
    assert sonar[[0, 3]].tolist() == [2.0, 0.25]
    assert [*found.records[0].presses] == [RecordedPress(3, "backward"), RecordedPress(3, None)]
    assert found.records[0].states == (*[("wander", "forward")] * 3, ("wander", "backward"))
    assert list(found.head.files) == ["rover.toml"]


def test_a_recorded_lesson_is_learned_again() -> None:
    recording = read_recording(RUNS / "lesson.mcap")
    lesson = new_lesson(
        ROBOT, "taught", states=["forward", "left", "right"], features=["range_of(ball)", "load"],
        options=LearnerOptions(reaction_s=0.2, learner=TreeOptions(order="gain first")), live=False)  # fmt: skip
    again = teach_from_recording(recording, ROBOT, lesson, list_recorded_presses(recording))
    document = (RUNS / "lesson.json").read_bytes()
    assert encode_document(again.make_trained_automaton()) == document
    assert decode_document(document, scripted_kit, path=RUNS / "lesson.json", learn=learn).rebuilt is None


def test_a_library_that_has_changed_is_said_to_have(tmp_path: Path) -> None:
    """The fingerprints in traces and recordings are of documents as 0.1.0 wrote them."""
    header = json.loads((RUNS / "forage.jsonl").read_text(encoding="utf-8").splitlines()[0])
    assert sorted(header["run"]["automata"]["forager"]) == ["deposit", "forage", "goto", "harvest"]
    gone = run("run", "--replay", RUNS / "forage.mcap", "-l", tmp_path, "--json")
    assert gone.exit_code == 2
