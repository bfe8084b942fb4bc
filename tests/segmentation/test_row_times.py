"""Times of rows as people have them: equal, late, zero, set back, in any unit and form of a date, or refused."""

from collections.abc import Callable, Sequence
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.addons.recordings.mapping_file import load_recording_map
from understudy.errors import FileError
from understudy.records.record import Record

MAP = """format = "understudy-recording-map/1"
time = {time}
time_unit = "{unit}"
{more}
[[readings]]
column = "number"
[[commands]]
column = "drive"
"""
SECONDS = [tick / 10 for tick in range(100)]
EPOCH = 1_700_000_000


def read(
    folder: Path,
    times: Sequence[object],
    *,
    time: str = '"t"',
    unit: str = "s",
    head: str = "t",
    more: str = "",
) -> Record:
    """Read a table whose rows are numbered, and alternate between two commands."""
    rows = [f"{at},{number},{number % 20 // 10}" for number, at in enumerate(times)]
    (folder / "drive.csv").write_text("\n".join([f"{head},number,drive", *rows]))
    (folder / "map.toml").write_text(MAP.format(time=time, unit=unit, more=more))
    return read_recorded_drive(folder / "drive.csv", load_recording_map(folder / "map.toml"))


def change(at: int, value: object) -> list[object]:
    """The times of rows 0.1 s apart, but for one."""
    return [value if row == at else second for row, second in enumerate(SECONDS)]


UNDERSTOOD = [  # what is odd about the times, the times, what is said
    ("nothing", SECONDS, ""),
    (
        "whole seconds",
        [int(at) for at in SECONDS],
        "line 2: 10 rows have the time 0 s, and so on 9 more times",
    ),
    ("one stamp twice", change(50, 4.9), "line 51: 2 rows have the time 4.9 s; spread"),
    ("a zero among seconds", change(50, 0), "line 52: no time, or a stamp of 0; put between"),
    (
        "a zero since 1970",
        [0 if at == 5 else EPOCH + at for at in SECONDS],
        "line 52: no time, or a stamp of 0",
    ),
    ("no stamp", change(50, ""), "line 52: no time, or a stamp of 0; put between"),
    ("a stamp that is none", change(50, "inf"), "line 52: no time, or a stamp of 0; put between"),
    ("from the last to the first", SECONDS[::-1], "its last row is the earliest"),
    ("below zero", [at - 30 for at in SECONDS], ""),
]


@pytest.mark.parametrize(("what", "times", "said"), UNDERSTOOD, ids=[each[0] for each in UNDERSTOOD])
def test_odd_times_are_understood(tmp_path: Path, what: str, times: Sequence[object], said: str) -> None:
    drive = read(tmp_path, times)
    np.testing.assert_allclose(drive.times - drive.times[0], SECONDS, atol=1e-6)
    numbers = list(range(100))
    assert drive.values["number", None].tolist() == (numbers[::-1] if "last" in what else numbers)
    assert (said in drive.omissions[0]) if said else drive.omissions == ()
    assert len(drive.episodes) == 1


def test_late_rows_go_where_they_belong(tmp_path: Path) -> None:
    times = [*SECONDS[:50], SECONDS[51], SECONDS[52], SECONDS[50], *SECONDS[53:]]
    drive = read(tmp_path, times)
    assert drive.values["number", None][49:54].tolist() == [49, 52, 50, 51, 53]
    assert "line 54: written after a later one" in drive.omissions[0]


SPLIT = [  # times, where episodes begin, what is said
    ([at - 3 * (at >= 5) for at in SECONDS], [0, 50], "line 52: time goes back from 4.9 to 2 s"),
    ([at + 3600 * (at >= 5) for at in SECONDS], [0, 50], "line 52: nothing was recorded for 3600.1 s"),
    ([at + EPOCH * (at >= 0.3) for at in SECONDS], [0, 3], "line 5: nothing was recorded for"),
    (change(50, -5), [0, 50, 51], "line 52: time goes back from 4.9 to -5 s"),
]


@pytest.mark.parametrize(("times", "begins", "said"), SPLIT)
def test_jumps_begin_another_episode(
    tmp_path: Path, times: Sequence[float], begins: list[int], said: str
) -> None:
    drive = read(tmp_path, times)
    assert [each.first for each in drive.episodes] == begins
    assert said in drive.omissions[0]
    assert drive.ticks == 100


BEGINS = [  # over noon, over midnight at the end of a month, and on a day that is no month
    datetime(2026, 1, 12, 11, 59, 56),
    datetime(2026, 1, 31, 23, 59, 56),
    datetime(2026, 1, 31, 9, 0, 0),
]
DATES: list[tuple[str, Callable[[datetime], str]]] = [
    ("ISO", lambda at: at.isoformat() + "Z"),
    ("with an offset", lambda at: at.isoformat() + "+05:30"),
    ("with a comma and nine digits", lambda at: f'"{at:%Y-%m-%d %H:%M:%S,%f}789"'),
    ("with slashes", lambda at: f"{at:%Y/%m/%d %H:%M:%S.%f} UTC"),
    ("not padded", lambda at: f"{at.year}/{at.month}/{at.day} {at.hour}:{at:%M:%S.%f}"),
    ("German", lambda at: f"{at:%d.%m.%Y %H:%M:%S.%f}"),
    ("British", lambda at: f"{at:%d/%m/%Y %H:%M:%S.%f}"),
    ("American", lambda at: f'"{at:%m/%d/%Y, %I:%M:%S.%f} {"PM" if at.hour > 11 else "AM"}"'),
    ("named month", lambda at: f"{at.day}-{('Jan', 'Feb')[at.month - 1]}-{at:%Y %H:%M:%S.%f}"),
    ("clock", lambda at: f"{at:%H:%M:%S.%f}"),
    ("clock of twelve hours", lambda at: f"{at:%I:%M:%S.%f} {'p.m.' if at.hour > 11 else 'a.m.'}"),
    ("minutes", lambda at: f"{at:%M:%S.%f}"),
    ("days", lambda at: f"{(at - datetime(2026, 1, 1)).days} days {at:%H:%M:%S.%f}"),
]


@pytest.mark.parametrize("begin", BEGINS)
@pytest.mark.parametrize(("name", "write"), DATES, ids=[each[0] for each in DATES])
def test_dates_and_clocks(
    tmp_path: Path, name: str, write: Callable[[datetime], str], begin: datetime
) -> None:
    drive = read(tmp_path, [write(begin + timedelta(seconds=at)) for at in SECONDS])
    np.testing.assert_allclose(drive.times - drive.times[0], SECONDS, atol=1e-6)
    assert drive.omissions == ()


PARTS = [  # the names of the columns, the unit of the part
    ("stamp.sec", "stamp.nanosec", 1e9),
    ("stamp_secs", "stamp_nsecs", 1e9),
    ("stamp/seconds", "stamp/nanoseconds", 1e9),
    ("stamp.tv_sec", "stamp.tv_usec", 1e6),
    ("stamp.s", "stamp.ms", 1e3),
]


@pytest.mark.parametrize(("whole", "part", "unit"), PARTS)
@pytest.mark.parametrize("named", [True, False])
def test_split_stamps(tmp_path: Path, whole: str, part: str, unit: float, named: bool) -> None:
    times = [f"{EPOCH + row // 10},{round(row % 10 * unit / 10)}" for row in range(100)]
    time = f'["{whole}", "{part}"]' if named else '"stamp"'
    drive = read(tmp_path, times, time=time, head=f"{whole},{part}")
    np.testing.assert_allclose(drive.times - drive.times[0], SECONDS, atol=1e-6)


@pytest.mark.parametrize(("unit", "per_s"), [("ns", 10**9), ("us", 10**6), ("ms", 10**3)])
def test_stamps_since_1970(tmp_path: Path, unit: str, per_s: int) -> None:
    drive = read(tmp_path, [EPOCH * per_s + row * per_s // 10 for row in range(100)], unit=unit)
    np.testing.assert_allclose(drive.times - drive.times[0], SECONDS, atol=1e-6)


@pytest.mark.parametrize("rate_hz", [1, 10, 50, 200])
def test_rates(tmp_path: Path, rate_hz: int) -> None:
    drive = read(tmp_path, [f"{row / rate_hz:.4f}" for row in range(100)])
    assert drive.tick_s == 1 / rate_hz
    assert drive.ticks == 100
    assert drive.omissions == ()


def test_rows_between_ticks_are_counted(tmp_path: Path) -> None:
    drive = read(tmp_path, [row / 10 for row in range(60)] + [6 + row / 50 for row in range(40)])
    assert drive.tick_s == 0.1
    assert (
        "ticks of 0.1 s follow the clock, and 32 of 100 rows between two ticks are left out"
        in drive.omissions[0]
    )


def test_rows_in_bursts_have_the_ticks_of_their_average(tmp_path: Path) -> None:
    drive = read(tmp_path, [row // 5 * 0.5 + row % 5 * 0.001 for row in range(100)])
    assert 0.09 < drive.tick_s < 0.11
    assert 90 < drive.ticks < 110


REFUSED = [  # times, their unit, the problem
    ([0] * 100, "s", "its times are all 0 s; name another column"),
    (["soon"] * 100, "s", "line 2, column 't': 'soon' is no time; write seconds"),
    ([at * 1000 for at in SECONDS], "s", "rows are 100 s apart, farther than 2 s; give the right time_unit"),
    (SECONDS, "us", "rows are 1e-07 s apart; give the right time_unit"),
    ([EPOCH * 1000 + row for row in range(100)], "s", "are after the year 2900"),
    ([f"20260501{10_00_00 + row}" for row in range(60)], "s", "are after the year 2900"),
    ([EPOCH + row for row in range(100)], "ms", "are seconds since 1970, and not ms"),
    (
        [row // 2 / 10 + 1000 * (row % 2) for row in range(100)],
        "s",
        "column 't': time goes back there and at 48",
    ),
]


@pytest.mark.parametrize(("times", "unit", "problem"), REFUSED, ids=[each[2] for each in REFUSED])
def test_other_times_are_refused(tmp_path: Path, times: list[object], unit: str, problem: str) -> None:
    with pytest.raises(FileError) as caught:
        read(tmp_path, times, unit=unit)
    assert problem in str(caught.value)


WRONG_PARTS = [
    (
        '["stamp.nanosec", "stamp.sec"]',
        "it reaches 1700000009, which is no part of a second; name the seconds first",
    ),
    ('["stamp.sec", "fine"]', "so it does not seem to be in nanoseconds"),
    ('["stamp.sec", "none"]', "there is no column 'none' for the time"),
]


@pytest.mark.parametrize(("time", "problem"), WRONG_PARTS)
def test_other_split_stamps_are_refused(tmp_path: Path, time: str, problem: str) -> None:
    times = [f"{EPOCH + row // 10},{row % 10 * 10**8},{row % 10 * 10**5}" for row in range(100)]
    with pytest.raises(FileError, match=problem):
        read(tmp_path, times, time=time, head="stamp.sec,stamp.nanosec,fine")


@given(st.lists(st.floats(0, 50) | st.just(0.0) | st.integers(0, 50), min_size=2, max_size=40))
def test_times_rise_within_an_episode(tmp_path_factory: pytest.TempPathFactory, times: list[float]) -> None:
    try:
        drive = read(tmp_path_factory.mktemp("times"), times, more="gap_s = 60")
    except FileError:
        return
    for each in drive.episodes:
        assert (np.diff(drive.times[each.ticks]) > 0).all()
