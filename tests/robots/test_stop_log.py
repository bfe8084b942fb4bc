"""The log of stops: lines that people and programs read, whole whoever writes at the same time."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from threading import Thread

import pytest
from tests.robots.rovers import ROVER
from tests.ui.cli.commands import run, run_json

from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.safety.stop_log import (
    StopEvent,
    append_stop,
    find_stop_log,
    make_stop_event,
    read_stops,
)
from understudy.errors import FileError

NOON = datetime(2026, 5, 4, 12, tzinfo=UTC)
LOGGED = ROVER.replace("[commands]", '[safety]\nlog = "logs/stops"\n[commands]')


@pytest.mark.parametrize(
    ("text", "path"), [(ROVER, "robots/rover.stops.jsonl"), (LOGGED, "robots/logs/stops")]
)
def test_where_it_is(text: str, path: str) -> None:
    assert find_stop_log(parse_robot(text), "robots/rover.toml") == Path(path)


def test_a_line_is_a_stop(tmp_path: Path) -> None:
    log, stop = tmp_path / "log", StopEvent(time=NOON, robot="rover", cause="a key", by="Ada")
    append_stop(log)
    assert read_stops(log) == ()
    append_stop(log, stop)
    assert log.read_text() == '{"time":"2026-05-04T12:00:00Z","robot":"rover","cause":"a key","by":"Ada"}\n'
    assert read_stops(log) == (stop,)


def test_no_log_yet_and_one_that_is_none(tmp_path: Path) -> None:
    assert read_stops(tmp_path / "log") == ()
    (tmp_path / "log").write_text('{"time":"2026-05-04T12:00:00Z","robot":"","cause":"","by":""}\n{"time"\n')
    with pytest.raises(FileError, match="log at line 2: is not an entry of a log of stops"):
        read_stops(tmp_path / "log")


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        (b'{"robot": "\xff"}', "it is not UTF-8"),
        (b'{"more":' + b"[" * 3000 + b"]" * 3000 + b"}", "it is nested too deeply"),
    ],
)
def test_a_damaged_log_is_refused(line: bytes, problem: str, tmp_path: Path) -> None:
    (tmp_path / "log").write_bytes(line + b"\n")
    with pytest.raises(FileError, match=f"log at line 1: is not an entry of a log of stops .{problem}"):
        read_stops(tmp_path / "log")


def test_two_who_write_at_once_lose_nothing(tmp_path: Path) -> None:
    def write(who: str) -> None:
        for _ in range(200):
            append_stop(tmp_path / "log", make_stop_event("rover", "x" * 500, who))

    writers = [Thread(target=write, args=(who,)) for who in ("guard", "watchdog")]
    for each in writers:
        each.start()
    for each in writers:
        each.join()
    assert sorted(stop.by for stop in read_stops(tmp_path / "log")) == ["guard"] * 200 + ["watchdog"] * 200


def test_stops_are_shown(tmp_path: Path) -> None:
    file = tmp_path / "rover.toml"
    file.write_text(ROVER)
    assert "never been stopped" in run("robots", "stops", file).stdout
    for number, robot in enumerate(("rover", "other", "rover")):
        append_stop(
            file.with_suffix(".stops.jsonl"),
            StopEvent(time=NOON, robot=robot, cause=f"no {number}", by="guard"),
        )
    assert [each["cause"] for each in run_json("robots", "stops", file)["stops"]] == ["no 0", "no 2"]
    shown = run("robots", "stops", file, "--last", 1).stdout
    assert "no 2" in shown
    assert "no 0" not in shown
