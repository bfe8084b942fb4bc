"""Tables and data frames of episodes, and the files that they are written to."""

from __future__ import annotations

import csv
import json
import sys
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("narwhals", reason="needs the extra frames")

from hypothesis import given
from hypothesis import strategies as st
from tests.make.records import make_record
from tests.make.sessions import make_session, play
from tests.make.transcripts import FOLDER

from understudy import Categorical, RecordedPress, make_episode_frames, read_records
from understudy.errors import FileError, SettingError
from understudy.model.lesson import ExampleKind
from understudy.model.value_kinds import BOOLEAN, Continuous, Kind
from understudy.records.record import Record
from understudy.records.record_tables import TABLES, DataTable, make_tick_table
from understudy.records.table_files import check_table_path, write_table

pandas: Any = pytest.importorskip("pandas")
polars: Any = pytest.importorskip("polars")
pyarrow: Any = pytest.importorskip("pyarrow")
BACKENDS = ("pandas", "polars", "pyarrow")


def make_steps(**changes: Any) -> Record:
    given: dict[str, Any] = {
        "agent": "robot 0",
        "tick_s": 0.1,
        "times": np.array([0.1, 0.2, 0.3]),
        "states": ((), ("go",), ("go", "left")),
        "readings": {"range(home)": np.array([1.5, nan, 0.25]), "ready": np.array([1.0, 0.0, nan])},
        "kinds": {"range(home)": Continuous(), "ready": BOOLEAN},
        "commands": {"drive": np.array([0.0, 1.0, 1.0])},
        "presses": (RecordedPress(1, "go", True, ExampleKind.DIRECTIVE), RecordedPress(2, None)),
        "source": "run.jsonl",
        "seed": 7,
        "behavior": "goto",
    }
    return make_record(**{**given, **changes})


SQUAD = make_steps(
    agent="squad 0",
    readings={"done": np.array([1.0, 1.0, 0.0])},
    kinds={},
    commands={},
    presses=(),
    seed=None,
)
TICKS = """\
episode,agent,tick,time_s,states,state_1,state_2,reading.range(home),reading.ready,reading.done,command.drive
0,robot 0,0,0.1,,,,1.5,yes,,0.0
0,robot 0,1,0.2,go,go,,,no,,1.0
0,robot 0,2,0.3,go > left,go,left,0.25,,,1.0
1,squad 0,0,0.1,,,,,,1.0,
1,squad 0,1,0.2,go,go,,,,1.0,
1,squad 0,2,0.3,go > left,go,left,,,0.0,
"""
PRESSES = """\
episode,agent,tick,time_s,state,kind,correction
0,robot 0,1,0.2,go,directive,true
0,robot 0,2,0.3,,,false
"""
EPISODES = """\
episode,source,agent,behavior,seed,tick_s,ticks,start_s,end_s,presses,corrections
0,run.jsonl,robot 0,goto,7,0.1,3,0.1,0.3,2,1
1,run.jsonl,squad 0,goto,,0.1,3,0.1,0.3,0,0
"""
WRITTEN = {"ticks": TICKS, "presses": PRESSES, "episodes": EPISODES}


@pytest.mark.parametrize("name", WRITTEN)
def test_the_tables_as_csv(name: str, tmp_path: Path) -> None:
    write_table(TABLES[name]([make_steps(), SQUAD]), tmp_path / "out.csv")
    assert (tmp_path / "out.csv").read_text() == WRITTEN[name]


@pytest.mark.parametrize("name", WRITTEN)
def test_all_files_have_the_same_cells(name: str, tmp_path: Path) -> None:
    duckdb: Any = pytest.importorskip("duckdb", reason="needs the extra parquet")
    table = TABLES[name]([make_steps(), SQUAD])
    write_table(table, tmp_path / "out.jsonl")
    write_table(table, tmp_path / "it's.parquet")
    lines = [json.loads(line) for line in (tmp_path / "out.jsonl").read_text().splitlines()]
    with duckdb.connect() as database:
        found = database.execute("SELECT * FROM read_parquet(?)", [str(tmp_path / "it's.parquet")])
        titles = [column[0] for column in found.description]
        assert [dict(zip(titles, row, strict=True)) for row in found.fetchall()] == lines
    assert titles == list(table.columns)
    assert [tuple(row.values()) for row in lines] == list(zip(*table.columns.values(), strict=True))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["it's.parquet", "out.jsonl"]


@pytest.mark.parametrize("backend", BACKENDS)
def test_frames_have_the_cells_of_the_tables(backend: str) -> None:
    episodes = [make_steps(), SQUAD]
    frames = make_episode_frames(episodes, backend)
    for name, make_table in TABLES.items():
        table, frame = make_table(episodes), polars.DataFrame(getattr(frames, name))
        assert frame.columns == list(table.columns)
        for title, cells in table.columns.items():
            found = [None if cell != cell else cell for cell in frame[title].to_list()]  # pandas has NaN
            assert found == cells
    assert type(frames.ticks).__module__.split(".")[0] == backend


@pytest.mark.parametrize("backend", BACKENDS)
def test_no_episodes_are_empty_frames(backend: str) -> None:
    frames = make_episode_frames([], backend)
    assert all(len(frame) == 0 for frame in frames)
    assert "time_s" in polars.DataFrame(frames.ticks).columns


values = st.one_of(st.just(nan), st.floats(allow_nan=False, allow_infinity=False))


@pytest.mark.parametrize("backend", BACKENDS)
@given(column=st.lists(values, min_size=1, max_size=6))
def test_readings_keep_every_digit(backend: str, column: list[float]) -> None:
    times = np.arange(len(column), dtype=np.float64)
    episode = make_steps(
        times=times,
        states=((),) * len(column),
        readings={"x": np.array(column)},
        kinds={},
        commands={},
        presses=(),
    )
    frame = make_episode_frames([episode], backend).ticks
    found = polars.DataFrame(frame)["reading.x"].to_numpy()
    assert repr(found.tolist()) == repr([float(value) for value in column])


@pytest.mark.parametrize("backend", ["pandas", "polars"])
def test_a_journal_as_frames(backend: str, tmp_path: Path) -> None:
    path = tmp_path / "taught.journal"
    play(make_session(journal=path), "forward", 3, "left", 2, "test", 1, "right", 1).close()
    frames = make_episode_frames(read_records(path), backend)
    ticks, presses = polars.DataFrame(frames.ticks), polars.DataFrame(frames.presses)
    assert ticks["state_1"].to_list()[:5] == ["forward"] * 3 + ["left"] * 2
    assert ticks["reading.seen"].to_list()[:3] == ["no", "yes", "no"]
    assert ticks["reading.range(ball)"].to_list()[:3] == [100.0, 99.0, 98.0]
    assert presses["kind"].to_list() == ["directive"] * 3
    assert presses["correction"].to_list() == [False, False, True]


def test_a_trace_as_frames() -> None:
    frames = make_episode_frames(read_records(FOLDER / "runs" / "forage.jsonl"), "pandas")
    rows = pandas.read_json(FOLDER / "runs" / "forage.jsonl", lines=True).iloc[1:]
    assert np.allclose(frames.ticks["x"], rows["x"], rtol=0, atol=1e-12)
    assert frames.ticks["states"].tolist() == rows["doing"].tolist()
    assert frames.episodes["seed"].tolist() == [1]


TWO: list[tuple[list[Kind], list[Any]]] = [
    ([BOOLEAN, BOOLEAN], ["yes", "yes"]),
    ([BOOLEAN, Categorical(("a", "b"))], ["yes", "b"]),
    ([BOOLEAN, Continuous()], [1.0, 1.0]),
]


@pytest.mark.parametrize(("kinds", "cells"), TWO)
def test_a_reading_of_several_kinds_is_a_number(kinds: list[Kind], cells: list[Any]) -> None:
    episodes = [
        make_steps(
            times=np.array([0.1]),
            states=((),),
            readings={"x": np.array([1.0])},
            kinds={"x": kind},
            commands={},
            presses=(),
        )
        for kind in kinds
    ]
    assert make_tick_table(episodes).columns["reading.x"] == cells


def test_texts_that_csv_must_quote(tmp_path: Path) -> None:
    cells: list[Any] = ['a,"b"', "größe\n", None]
    write_table(DataTable({"state": cells}, {"state": str}), tmp_path / "out.csv")
    with (tmp_path / "out.csv").open(newline="") as lines:
        assert [row for row in csv.reader(lines) if row] == [["state"], ['a,"b"'], ["größe\n"], [""]]


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_text("former")
    with pytest.raises(FileError, match="is there already; name another file, or move that one away"):
        write_table(make_tick_table([SQUAD]), path)
    assert path.read_text() == "former"


def test_a_file_that_is_no_table_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        SettingError, match=r"is no table; name a file that ends in \.csv, \.jsonl or \.parquet"
    ):
        check_table_path(tmp_path / "out.xlsx")


def test_parquet_needs_duckdb(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "duckdb", None)
    with pytest.raises(SettingError, match=r"understudy-robots\[parquet\]"):
        check_table_path(tmp_path / "out.parquet")
