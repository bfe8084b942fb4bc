"""Traces: every tick that ran is in the file, whatever ended the run."""

from __future__ import annotations

import errno
import json
import os
import sys
from io import FileIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.make.run_frames import make_crossing

from understudy.errors import FileError, SettingError
from understudy.records.trace_writer import COLUMNS, TraceWriter, write_trace
from understudy.sim.view import RunFrame

ABOUT: dict[str, Any] = {"scenario": "crossing", "seed": 7, "tick_s": 0.1, "robots": 3}
HEADER = {"format": "understudy trace", "version": 2, **ABOUT}


def paths(frame: RunFrame) -> list[tuple[str, ...]]:
    return [("cross", name) for name in frame.doing[:-1]] + [()]


def add(trace: TraceWriter, frame: RunFrame, doing: list[tuple[str, ...]] | None = None) -> None:
    trace.add(frame.view.time_s, frame.view.pose, paths(frame) if doing is None else doing)


def record(path: Path, ticks: int) -> list[RunFrame]:
    frames = make_crossing(ticks)
    with write_trace(path, **ABOUT) as trace:
        for frame in frames:
            add(trace, frame)
    return frames


def test_a_line_for_each_robot_and_tick(tmp_path: Path) -> None:
    frames = record(tmp_path / "run.jsonl", 4)
    first, *rows = [json.loads(line) for line in (tmp_path / "run.jsonl").read_text().splitlines()]
    assert first == HEADER
    assert [(row["time_s"], row["robot"]) for row in rows] == [
        (round(frame.view.time_s, 6), robot) for frame in frames for robot in range(3)
    ]
    assert all(list(row) == list(COLUMNS) for row in rows)
    assert np.allclose([row["x"] for row in rows], np.concatenate([frame.view.robots.x for frame in frames]))
    assert {row["doing"] for row in rows} == {"cross > ahead", ""}


def test_while_it_runs_what_was_there_stays_and_every_tick_is_on_disk(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    path.write_text("former")
    with write_trace(path, **ABOUT) as trace:
        add(trace, make_crossing(1)[0], [("a",)] * 3)
        assert path.read_text() == "former"
        (unfinished,) = tmp_path.glob(".run.jsonl.*.unfinished")
        assert len(unfinished.read_text().splitlines()) == 4
    assert len(path.read_text().splitlines()) == 4
    assert list(tmp_path.iterdir()) == [path]


def test_an_interrupted_run_leaves_what_it_recorded(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"

    def interrupt() -> None:
        with write_trace(path, **ABOUT) as trace:
            add(trace, make_crossing(1)[0], [("a",)] * 3)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupt()
    assert [json.loads(line).get("robot") for line in path.read_text().splitlines()] == [None, 0, 1, 2]


def test_a_run_without_a_tick_leaves_nothing(tmp_path: Path) -> None:
    with write_trace(tmp_path / "run.jsonl", **ABOUT):
        pass
    assert not list(tmp_path.iterdir())


class FullDisk(FileIO):
    """A file on a disk that has room for so many bytes, and takes the part of a write for which it has."""

    def __init__(self, path: Path, room: int) -> None:
        super().__init__(path, "w")
        self._room = room

    def write(self, data: Any, /) -> int:
        if not self._room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = super().write(bytes(data[: self._room]))
        self._room -= written
        return written


SHORT = [(0, 0), (1, 0), (1, 1), (4, 0), (4, 150), (8, -1), (28, 0)]
"""How many lines of a trace of 9 ticks of 3 robots a disk has room for, and how many bytes more."""


@pytest.mark.parametrize(("lines", "more"), SHORT)
def test_a_disk_that_gets_full_leaves_whole_ticks(
    lines: int, more: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, usual = tmp_path / "run.jsonl", Path.open
    frames = record(path, 9)
    whole = path.read_bytes().splitlines(keepends=True)
    path.unlink()
    room, ticks = sum(map(len, whole[:lines])) + more, (lines - 1 - (more < 0)) // 3

    def open_path(each: Path, mode: str = "r", *given: Any, **named: Any) -> Any:
        unfinished = ".jsonl.unfinished" in each.name and mode == "wb"
        return FullDisk(each, room) if unfinished else usual(each, mode, *given, **named)

    def trace_all() -> None:
        with write_trace(path, **ABOUT) as trace:
            for frame in frames:
                add(trace, frame)

    monkeypatch.setattr(Path, "open", open_path)
    if ticks == len(frames):
        trace_all()
    else:
        with pytest.raises(
            FileError, match=r"run\.jsonl: writing the trace failed: No space left .*; free space"
        ):
            trace_all()
    if ticks > 0:
        assert path.read_bytes() == b"".join(whole[: 1 + 3 * ticks])
    assert [each.name for each in tmp_path.iterdir()] == (["run.jsonl"] if ticks > 0 else [])


def test_paths_of_other_robots_are_refused_and_leave_no_part_of_a_tick(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    frame = make_crossing(1)[0]
    with write_trace(path, **ABOUT) as trace:
        add(trace, frame)
        with pytest.raises(ValueError, match="shorter"):
            add(trace, frame, [("a",)])
    assert len(path.read_text().splitlines()) == 4


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match=r"ends in \.jsonl"), write_trace(tmp_path / "run.csv", **ABOUT):
        pass


def test_parquet_needs_duckdb(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "duckdb", None)
    opening = write_trace(tmp_path / "run.parquet", **ABOUT)
    with pytest.raises(SettingError, match=r"understudy-robots\[parquet\]"), opening:
        pass
    assert not list(tmp_path.iterdir())


def test_parquet(tmp_path: Path) -> None:
    duckdb = pytest.importorskip("duckdb")
    folder = tmp_path / "it's [a] *star?"
    folder.mkdir()
    frames = record(folder / "run.parquet", 4)
    record(folder / "run.jsonl", 4)
    assert sorted(file.name for file in folder.iterdir()) == ["run.jsonl", "run.parquet"]
    (folder / "run.parquet").rename(tmp_path / "run.parquet")
    with duckdb.connect() as database:
        table = database.execute(f"SELECT * FROM '{tmp_path}/run.parquet'")
        assert [column[0] for column in table.description] == list(COLUMNS)
        lines = (folder / "run.jsonl").read_text().splitlines()[1:]
        assert table.fetchall() == [tuple(json.loads(line).values()) for line in lines]
        about = database.execute(
            f"SELECT value FROM parquet_kv_metadata('{tmp_path}/run.parquet')"
        ).fetchone()
    assert json.loads(about[0]) == HEADER
    assert len(frames) == 4
