"""Recordings of real robots: none is in another's way, none is left of what never began, and each ends as it should."""

from __future__ import annotations

import os
import signal
from datetime import datetime
from pathlib import Path

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("mcap", reason="needs the extra ros2")

from understudy.errors import FileError
from understudy.ui.cli import robot_connection


class Noon(datetime):
    @classmethod
    def now(cls, tz: object = None) -> Noon:
        return cls(2026, 11, 22, 12)


def test_two_that_begin_in_one_second_have_a_file_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robot_connection, "datetime", Noon)
    for name in ("rover-2026-11-22T12-00-00.mcap", "rover-2026-11-22T12-00-00-2.mcap"):
        place = robot_connection._place(tmp_path / "rover.toml")
        assert place == tmp_path / "recordings" / name
        place.touch()


def test_nothing_is_left_of_what_never_began(tmp_path: Path) -> None:
    path = tmp_path / "rover.toml"
    path.write_text("format = 1", encoding="utf-8")
    with pytest.raises(FileError), robot_connection.connect_twin(path, None, record=None, recorded=True):
        pass
    assert not (tmp_path / "recordings").exists()


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_who_is_told_to_end_leaves_orderly(name: str) -> None:
    number = getattr(signal, name)
    before = signal.signal(number, signal.SIG_DFL)
    try:
        how = KeyboardInterrupt if name == "SIGINT" else SystemExit
        with robot_connection.interrupt_on_termination(), pytest.raises(how) as left:
            signal.raise_signal(number)
        assert name == "SIGINT" or left.value.args == (128 + number,)
        assert signal.getsignal(number) == signal.SIG_DFL
    finally:
        signal.signal(number, before)


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
def test_a_hang_up_is_ignored_where_somebody_wants_that() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with robot_connection.interrupt_on_termination():
            signal.raise_signal(signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)
