"""Ticks, commands and times of recorded messages: held, by the clock, set back, of two clocks; and fields of JSON."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.segmentation.test_messages import BEGAN_NS, MAP, make_map

from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.errors import FileError
from understudy.records.record import Record

pytest.importorskip("mcap")

Message = tuple[float, str, Any]
"""The time of a message, s, its topic and its content."""
TURN = '[[commands]]\ncolumn = "/turn.z"\nchannel = "turn"\n'


def list_messages(
    ball: Callable[[int], Any] | None = lambda tick: {"range": tick / 64},
    command: Callable[[int], Any] = lambda tick: {"linear": {"x": tick // 20 % 2}},
    count: int = 100,
) -> Iterator[Message]:
    """Messages of a drive of 0.1 s a tick; None is not sent. Each range comes 10 ms before its command."""
    for tick in range(count):
        for late, topic, content in ((0.0, "/ball", ball), (0.01, "/cmd_vel", command)):
            if content is not None and (sent := content(tick)) is not None:
                yield tick * 0.1 + late, topic, sent


def read(folder: Path, messages: Sequence[Message], text: str = MAP) -> Record:
    from mcap.writer import Writer

    with (folder / "drive.mcap").open("wb") as file:
        writer: Any = Writer(file)
        writer.start()
        schema = writer.register_schema("any", "jsonschema", b"{}")
        channels: dict[str, int] = {}
        for at_s, topic, content in messages:
            if topic not in channels:
                channels[topic] = writer.register_channel(topic, "json", schema)
            data = content if isinstance(content, bytes) else json.dumps(content).encode()
            writer.add_message(channels[topic], BEGAN_NS + round(at_s * 1e9), data, 0)
        writer.finish()
    return read_recorded_drive(folder / "drive.mcap", make_map(folder, text))


def only_changes(tick: int) -> Any:
    return {"linear": {"x": tick // 20 % 2}} if tick % 20 == 0 else None


def test_commands_that_come_only_when_they_change_hold(tmp_path: Path) -> None:
    drive = read(tmp_path, list(list_messages(command=only_changes)))
    assert drive.tick_s == 0.1
    assert drive.commands[:, 0].tolist() == [tick // 20 % 2 for tick in range(100)]
    assert "commands came only now and then; ticks of 0.1 s follow the clock" in drive.omissions[0]
    assert "95 of 100 rows have no command of drive; the last one holds, at most 1.9 s" in drive.omissions[1]


def test_a_command_holds_as_long_as_is_said(tmp_path: Path) -> None:
    drive = read(
        tmp_path, list(list_messages(command=only_changes)), MAP.replace("[behav", "hold_s = 0.55\n[behav", 1)
    )
    assert drive.commands[20:30, 0].tolist() == [1, 1, 1, 1, 1, 1, 0, 0, 0, 0]
    assert "after 0.55 s the robot is at rest" in drive.omissions[1]


def test_a_pause_of_regular_commands_is_no_gap(tmp_path: Path) -> None:
    """A keyboard that is let go of sends nothing, while the robot goes on and its sensors, too."""

    def command(tick: int) -> Any:
        return None if 30 <= tick < 60 else {"linear": {"x": tick % 7}}

    drive = read(tmp_path, list(list_messages(command=command)))
    assert len(drive.episodes) == 1
    assert drive.values["range", "ball"].tolist() == [tick / 64 for tick in range(100)]
    assert drive.commands[29:61, 0].tolist() == [29 % 7] * 31 + [60 % 7]
    assert "30 of 100 rows have no command of drive; the last one holds, at most 3 s" in drive.omissions[0]


def test_where_nothing_was_recorded_an_episode_ends(tmp_path: Path) -> None:
    messages = [each for each in list_messages(command=only_changes) if not 2.05 < each[0] < 5.05]
    drive = read(tmp_path, messages)
    assert len(drive.episodes) == 2
    assert any("nothing was recorded for" in each for each in drive.omissions)


@pytest.mark.parametrize("jump_s", [3600.0, 1e9])
def test_a_clock_that_jumps_ahead_ends_an_episode(tmp_path: Path, jump_s: float) -> None:
    messages = [(at + jump_s * (at >= 5), *more) for at, *more in list_messages()]
    drive = read(tmp_path, messages)
    assert [each.first for each in drive.episodes] == [0, 50]
    sparse = [(at + jump_s * (at >= 5), *more) for at, *more in list_messages(command=only_changes)]
    assert read(tmp_path, sparse).ticks < 101


@pytest.mark.parametrize("back_s", [3.0, 1e9])
def test_a_clock_that_is_set_back_ends_an_episode(tmp_path: Path, back_s: float) -> None:
    messages = [(at - back_s * (at >= 5), *more) for at, *more in list_messages()]
    drive = read(tmp_path, messages)
    assert [each.first for each in drive.episodes] == [0, 50]
    assert drive.values["range", "ball"].tolist() == [tick / 64 for tick in range(100)]
    assert "topic '/ball': time goes back by" in drive.omissions[0]


def test_topics_may_be_in_any_order_in_a_file(tmp_path: Path) -> None:
    drive = read(tmp_path, sorted(list_messages(), key=lambda each: each[1]))
    assert drive.values["range", "ball"].tolist() == [tick / 64 for tick in range(100)]
    assert drive.omissions == ()


def test_whole_seconds_are_spread(tmp_path: Path) -> None:
    drive = read(tmp_path, [(float(int(at)), *more) for at, *more in list_messages()])
    assert drive.values["range", "ball"].tolist() == [tick / 64 for tick in range(100)]
    np.testing.assert_allclose(np.diff(drive.times), 0.1, atol=1e-6)
    assert "'range(ball)' has 10 messages of one time, and so on; spread evenly" in drive.omissions[0]


def test_times_that_are_all_equal_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="its times are all 0 s"):
        read(tmp_path, [(0.0, *more) for _, *more in list_messages()])


@pytest.mark.parametrize("rate_hz", [1, 20, 200])
def test_rates(tmp_path: Path, rate_hz: int) -> None:
    drive = read(tmp_path, [(at * 10 / rate_hz, *more) for at, *more in list_messages()])
    assert drive.tick_s == pytest.approx(1 / rate_hz)
    assert drive.ticks == 100
    assert drive.omissions == ()


@pytest.mark.parametrize(("tick_s", "ticks"), [(0.05, 199), (0.2, 50), (0.1, 100)])
def test_ticks_may_be_said(tmp_path: Path, tick_s: float, ticks: int) -> None:
    drive = read(tmp_path, list(list_messages()), MAP.replace('"time_s"', f'"time_s"\ntick_s = {tick_s}'))
    assert (drive.tick_s, drive.ticks) == (tick_s, ticks)
    assert drive.values["range", "ball"][-1] == (99 if tick_s < 0.2 else 98) / 64


def test_a_slow_sensor_is_not_absent_in_between(tmp_path: Path) -> None:
    slow = list(
        list_messages(ball=lambda tick: {"range": tick / 64} if tick % 15 == 0 and tick < 40 else None)
    )
    found = read(tmp_path, slow).values["range", "ball"]
    assert found[:45].tolist() == [tick // 15 * 15 / 64 for tick in range(45)]
    told = read(tmp_path, slow, MAP.replace('unit = "m"', 'unit = "m"\nstale_s = 0.55')).values[
        "range", "ball"
    ]
    assert np.isnan(told[6:15]).all()
    assert np.isfinite(told[:6]).all()


def test_channels_of_several_topics(tmp_path: Path) -> None:
    turns = [(tick * 0.1 + 0.02, "/turn", {"z": tick}) for tick in range(0, 100, 5)]
    drive = read(tmp_path, sorted([*list_messages(), *turns]), MAP.replace("[behav", TURN + "[behav", 1))
    assert drive.commands[:, 0].tolist() == [tick // 20 % 2 for tick in range(1, 100)]
    assert drive.commands[:, 1].tolist() == [(tick - 1) // 5 * 5 for tick in range(1, 100)]
    assert "rows have no command of turn; the last one holds" in drive.omissions[0]
    assert "tick 1: before the first command; left out" in drive.omissions[1]


STAMPS: list[tuple[str, Callable[[int], Any]]] = [
    ("s", lambda tick: 100 + tick / 10),
    ("ms", lambda tick: 1_700_000_000_000 + tick * 100),
    ("ns", lambda tick: 1_700_000_000_000_000_000 + tick * 100_000_000),
    ("s", lambda tick: f"2026-05-01T10:00:{tick / 10:06.3f}Z"),
    ("s", lambda tick: {"sec": 100 + tick // 10, "nanosec": tick % 10 * 10**8}),
    ("ms", lambda tick: {"secs": 100 + tick // 10, "nsecs": tick % 10 * 10**8}),
]


@pytest.mark.parametrize(("unit", "stamp"), STAMPS, ids=range(len(STAMPS)))
def test_stamps_in_messages(tmp_path: Path, unit: str, stamp: Callable[[int], Any]) -> None:
    """Messages arrive late by 0.03 s now and then; their stamps say when they were made."""
    messages = [
        (at + 0.03 * (round(at * 10) % 3 == 0), *more)
        for at, *more in list_messages(command=lambda tick: {"linear": {"x": tick % 3}, "at": stamp(tick)})
    ]
    text = MAP.replace('"time_s"', f'"/cmd_vel.at"\ntime_unit = "{unit}"')
    drive = read(tmp_path, messages, text)
    np.testing.assert_allclose(drive.times - drive.times[0], np.arange(100) / 10, atol=1e-5)
    assert drive.omissions == ()


def test_two_clocks_that_drift_apart_are_said(tmp_path: Path) -> None:
    messages = list_messages(ball=lambda tick: {"range": tick / 64, "at": 100 + tick * 0.08})
    drive = read(tmp_path, list(messages), MAP.replace('"time_s"', '"/ball.at"'))
    assert drive.tick_s == pytest.approx(0.08)
    assert "some messages arrived 1.98 s later after their stamps than others" in drive.omissions[0]


def test_stamps_of_zero(tmp_path: Path) -> None:
    text = MAP.replace('"time_s"', '"/ball.at"')
    half = list(list_messages(ball=lambda tick: {"range": 1.0, "at": (100 + tick / 10) * (tick % 2)}))
    drive = read(tmp_path, half, text)
    np.testing.assert_allclose(np.diff(drive.times), 0.1, atol=1e-6)
    assert "50 stamps are 0 or none" in drive.omissions[0]
    with pytest.raises(FileError, match="its stamps are all 0"):
        read(tmp_path, list(list_messages(ball=lambda tick: {"range": 1.0, "at": 0})), text)


FIELDS: list[tuple[Callable[[int], Any], str, str, Sequence[float], str]] = [
    # a message, the path of a field in it, the kind and first values of the reading, what is said
    (lambda tick: {"a": [[1, {"b": tick}]]}, "a.0.1.b", "continuous", [0, 1, 2], ""),
    (lambda tick: {"a": [5] * (tick % 2)}, "a.0", "continuous", [np.nan, 5], "absent in 50 of 100"),
    (lambda tick: [tick, 7], "0", "continuous", [0, 1, 2], ""),
    (lambda tick: {"a": f" {tick} "}, "a", "continuous", [0, 1, 2], ""),
    (lambda tick: {"a": "far" if tick % 2 else "near"}, "a", "categorical(far|near)", [1, 0, 1], ""),
    (lambda tick: {"a": tick % 2 == 0}, "a", "categorical(no|yes)", [1, 0, 1], ""),
    (lambda tick: {"a": None if tick % 2 else 4}, "a", "continuous", [4, np.nan], "absent in 50 of 100"),
    (
        lambda tick: {"a": [np.inf, np.nan, 10**400, 3][tick % 4]},
        "a",
        "continuous",
        [np.nan] * 3 + [3],
        "absent in 75",
    ),
    (
        lambda tick: {"b" if tick % 2 else "a": 2},
        "a",
        "continuous",
        [2, np.nan],
        "50 messages do not have 'range(ball)'",
    ),
    (lambda tick: b"{" if tick % 2 else {"a": 2}, "a", "continuous", [2, 2], "50 messages cannot be decoded"),
]


@pytest.mark.parametrize(("ball", "path", "kind", "values", "said"), FIELDS, ids=range(len(FIELDS)))
def test_fields_of_json(
    tmp_path: Path, ball: Callable[[int], Any], path: str, kind: str, values: Sequence[float], said: str
) -> None:
    drive = read(tmp_path, list(list_messages(ball=ball)), MAP.replace("ball.range", f"ball.{path}"))
    assert str(drive.readings[0].kind) == kind
    np.testing.assert_array_equal(drive.values["range", "ball"][: len(values)], values)
    assert (said in drive.omissions[0]) if said else drive.omissions == ()


def test_texts_of_numbers_have_units(tmp_path: Path) -> None:
    messages = list(list_messages(ball=lambda tick: {"range": str(tick)}))
    drive = read(tmp_path, messages, MAP.replace('unit = "m"', 'unit = "cm"'))
    assert drive.values["range", "ball"][:3].tolist() == pytest.approx([0, 0.01, 0.02])


COMMANDS: list[tuple[Callable[[int], Any], list[float]]] = [
    (lambda tick: tick % 4, [0, 0.5, 1, 1.5]),
    (lambda tick: str(tick % 4), [0, 0.5, 1, 1.5]),
    (lambda tick: tick % 4 > 1, [0, 0, 0.5, 0.5]),
]


@pytest.mark.parametrize(("value", "commands"), COMMANDS, ids=["numbers", "texts", "truth values"])
def test_commands_of_json(tmp_path: Path, value: Callable[[int], Any], commands: list[float]) -> None:
    messages = list(list_messages(command=lambda tick: {"linear": {"x": value(tick)}}))
    drive = read(tmp_path, messages, MAP.replace("[behav", "scale = 0.5\n[behav", 1))
    assert drive.commands[:4, 0].tolist() == commands


REFUSED: list[tuple[str, str, str]] = [  # what is replaced in the mapping file, by what, the problem
    (
        "/ball.range",
        "/ball.rnge",
        "no message has it (there is no 'rnge' in 'rnge'; the fields there are range)",
    ),
    (
        "/ball.range",
        "/ball.range.x",
        "no message has it (there is no 'x' in 'range.x'; end the path before it)",
    ),
    ("/cmd_vel.linear.x", "/cmd_vel.linear", "('linear' is no number; name one of these in it: x)"),
    ("/cmd_vel.linear.x", "/cmd_vel.linear.y", "there is no 'y' in 'linear.y'; the fields there are x"),
    ('"time_s"', '["/ball.sec", "/ball.nanosec"]', "name the stamp itself, as /odom.header.stamp"),
    (
        'name = "range"\ntarget = "ball"',
        'name = "time_s"',
        "it is called 'time_s', as times and commands are",
    ),
]


@pytest.mark.parametrize(("former", "new", "problem"), REFUSED, ids=[each[1] for each in REFUSED])
def test_fields_that_are_not_there_are_refused(tmp_path: Path, former: str, new: str, problem: str) -> None:
    with pytest.raises(FileError) as caught:
        read(tmp_path, list(list_messages()), MAP.replace(former, new))
    assert problem in str(caught.value)


def test_commands_that_are_texts_are_refused(tmp_path: Path) -> None:
    messages = list(list_messages(command=lambda tick: {"linear": {"x": "ahead"}}))
    with pytest.raises(
        FileError, match=r"topic '/cmd_vel': it has no message that can be read \('ahead' is no number\)"
    ):
        read(tmp_path, messages)
