"""`understudy learn --recording` with traces: what simulated robots did is explained without a mapping file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from tests.ui.cli.commands import run, run_json


def read_states(trace: Path, level: int) -> dict[float, str]:
    """The state of robot 0 at a level of the hierarchy, by the time of the tick, as the trace has it."""
    rows = map(json.loads, trace.read_text().splitlines()[1:])
    paths = {row["time_s"]: row["doing"].split(" > ") for row in rows if row["robot"] == 0}
    return {time_s: path[level] for time_s, path in paths.items() if len(path) > level}


def compute_agreement(drive: dict[str, Any], states: dict[float, str]) -> float:
    """The share of ticks whose label is the state that the robot was in, of those with a state that can be a label."""
    known = {each["label"] for each in drive["labels"]}
    spans = [(each["from_s"], each["to_s"], each["label"]) for each in drive["spans"]]
    right = [
        any(first - 1e-6 <= time_s < end - 1e-6 and label == state for first, end, label in spans)
        for time_s, state in states.items()
        if state in known
    ]
    assert len(right) > 0.8 * len(states)
    return sum(right) / len(right)


@pytest.fixture
def trace(library: Path, tmp_path: Path) -> Path:
    """A trace of a robot that forages."""
    path = tmp_path / "forage.jsonl"
    assert run_json("run", "--library", library, "--seed", 7, "--trace", path)["success"]
    return path


def test_a_trace_needs_no_mapping_file(library: Path, tmp_path: Path) -> None:
    path = tmp_path / "goto.jsonl"
    goto = ("run", "--library", library, "--behavior", "goto", "--bind", "A=station", "--seed", 3)
    run_json(*goto, "--seconds", 60, "--trace", path)
    found = run_json("learn", "--recording", path, "--behaviors", "forward,rotate_left,rotate_right")
    assert compute_agreement(found["drive"], read_states(path, 0)) >= 0.95


def test_automata_of_the_library_explain_a_trace(library: Path, trace: Path) -> None:
    """The level above harvest and deposit is found from what the robot did, and saved beside them."""
    given = ("--library", library, "--name", "driven", "--behaviors", "harvest,deposit")
    found = run_json("learn", "--recording", trace, *given)
    assert {each["label"] for each in found["drive"]["labels"]} == {"harvest", "deposit"}
    assert compute_agreement(found["drive"], read_states(trace, 0)) >= 0.98
    assert Path(found["saved"]) == library / "driven.json"
    for before, after in (("harvest", "deposit"), ("deposit", "harvest")):
        assert found["states"][before]["conditions"] == [f"{after} when done is yes", "stays otherwise"]


def test_parquet_is_the_same(library: Path, trace: Path) -> None:
    pytest.importorskip("duckdb", reason="needs the extra parquet")
    table = trace.with_suffix(".parquet")
    run_json("run", "--library", library, "--seed", 7, "--trace", table)
    steps = "forward,rotate_left,rotate_right,load_food,unload_food"
    found, same = (
        [
            {**span, "file": ""}
            for span in run_json("learn", "--recording", path, "--behaviors", steps)["drive"]["spans"]
        ]
        for path in (trace, table)
    )
    assert found == same


def test_one_robot_of_several(library: Path, tmp_path: Path) -> None:
    path = tmp_path / "team.jsonl"
    team = ("run", "--library", library, "--world", "forage-team", "--seconds", 60)
    run_json(*team, "--trace", path)
    steps = "forward,rotate_left,rotate_right,load_food,unload_food"
    first, second = (
        run_json("learn", "--recording", path, "--agent", number, "--behaviors", steps)["drive"]["spans"]
        for number in (0, 1)
    )
    assert first != second
    missing = run("learn", "--recording", path, "--agent", 4)
    assert missing.exit_code == 2
    assert "--agent is 4; count from 0 to 3" in " ".join(missing.stderr.split())


def test_a_robot_that_stands_still_is_refused(library: Path, tmp_path: Path) -> None:
    path = tmp_path / "still.jsonl"
    run_json(
        "run",
        "--library",
        library,
        "--behavior",
        "goto",
        "--bind",
        "A=station",
        "--seconds",
        0.1,
        "--trace",
        path,
    )
    result = run("learn", "--recording", path)
    assert result.exit_code == 2
    assert "its commands never change" in " ".join(result.stderr.split())
