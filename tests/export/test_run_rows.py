"""Readings of recorded runs in conformance files: the exported code is tried on what robots sensed."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from math import nan
from pathlib import Path

import numpy as np
import pytest
from tests.export.exports import FIXTURE
from tests.make.records import make_record
from tests.ui.cli.commands import run, run_json

from understudy.addons.export.conformance import list_run_rows
from understudy.addons.export.hierarchy import ChildRef, Hierarchy, ReadingSlot
from understudy.judging.record_files import read_records
from understudy.model.binding import Binding
from understudy.model.value_kinds import Categorical, Continuous, Kind
from understudy.records.record_tables import make_tick_table
from understudy.records.table_files import write_table

LIBRARY = FIXTURE


def make_hierarchy(*readings: ReadingSlot) -> Hierarchy:
    """A hierarchy that has nothing but readings."""
    return Hierarchy(
        "bare", Binding(), ChildRef(is_automaton=False, index=0), readings, (), (), (), (), (), 0.1, ()
    )


def trace_run(folder: Path) -> Path:
    """Trace ten seconds of the automaton that is exported."""
    path = folder / "run.jsonl"
    assert run("run", "forage", "--library", LIBRARY, "--seconds", 10, "--trace", path).exit_code == 0
    return path


def test_exported_code_decides_as_the_run_that_was_recorded(tmp_path: Path) -> None:
    """The rows have the readings of the run, and the states in which it was recorded."""
    trace, out = trace_run(tmp_path), tmp_path / "out"
    exported = run_json(
        "export", "automaton", "forage", "--library", LIBRARY, "--to", "python", "--out", out, "--run", trace
    )
    (record,) = read_records(trace)
    facts = json.loads((out / "manifest.json").read_text())
    assert facts["conformance"]["from_runs"] == record.ticks
    first = facts["conformance"]["from_lessons"]
    with (out / "conformance.csv").open(newline="") as lines:
        rows = list(csv.DictReader(lines))
    assert len(rows) == exported["ticks"]
    mine = rows[first : first + record.ticks]
    assert [row["starts"] for row in mine] == ["1", *["0"] * (record.ticks - 1)]
    for label in ("distance(station)",):
        if label in mine[0]:
            np.testing.assert_array_equal([float(row[label] or "nan") for row in mine], record.columns[label])
    automata = facts["automata"]
    states = [each["name"] for each in automata[facts["root"]]["states"]]
    found = [states[int(row["path"].split(".")[0])] for row in mine]
    assert found == [path[0] for path in record.states]
    answered = subprocess.run([sys.executable, "conformance.py"], cwd=out, capture_output=True, text=True)
    assert answered.returncode == 0, answered.stdout + answered.stderr


def test_labels_are_those_of_the_export_and_what_a_run_lacks_is_absent() -> None:
    """The run has the labels in another order, one that the export does not know, and no reading of the goal."""
    colors, goal = Categorical(("blue", "red")), ReadingSlot("range", "goal", Continuous())
    hierarchy = make_hierarchy(ReadingSlot("color", None, colors), goal)
    record = make_record(
        readings={"color": np.array([0.0, 1.0, 2.0])}, kinds={"color": Categorical(("green", "red", "blue"))}
    )
    ((times, rows),) = list_run_rows(hierarchy, [record])
    assert times == [0.1, 0.15, 0.21]
    np.testing.assert_array_equal(rows, [[nan, nan], [1.0, nan], [0.0, nan]])


@pytest.mark.parametrize("kind", [Continuous(), Categorical(("a", "b"))])
def test_a_reading_of_another_kind_is_absent(kind: Kind) -> None:
    other = Categorical(("a", "b")) if isinstance(kind, Continuous) else Continuous()
    record = make_record(readings={"x": np.array([0.0, 1.0, 1.0])}, kinds={"x": other})
    ((_, rows),) = list_run_rows(make_hierarchy(ReadingSlot("x", None, kind)), [record])
    assert np.isnan(rows).all()


def test_a_run_without_any_of_the_readings_is_refused(tmp_path: Path) -> None:
    write_table(make_tick_table([make_record(readings={"x": np.ones(3)})]), tmp_path / "other.csv")
    result = run(
        "export", "automaton", "forage", "--library", LIBRARY, "--to", "python", "--out", tmp_path / "out",
        "--run", tmp_path / "other.csv",
    )  # fmt: skip
    assert result.exit_code == 2
    assert "has none of the readings of forage" in " ".join(result.stderr.split())
