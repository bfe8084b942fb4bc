"""Tables of ticks are read back: what was written as CSV, JSON lines or Parquet gives the same episodes."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.make.records import make_record

from understudy.addons.bridges.datasets.lerobot import write_lerobot
from understudy.addons.bridges.datasets.lerobot_reader import read_lerobot
from understudy.addons.bridges.datasets.minari import write_minari
from understudy.addons.recordings.run_drives import choose_agent
from understudy.errors import DefinitionError, FileError, SettingError
from understudy.judging.record_files import read_records
from understudy.model.value_kinds import Categorical, Continuous, Kind, Toroidal
from understudy.records.join_records import join_records
from understudy.records.record import Record
from understudy.records.record_losses import describe_losses
from understudy.records.record_tables import make_tick_table
from understudy.records.table_files import is_tick_table, read_tick_records, write_table
from understudy.ui.cli.recorded_runs import read_run

KINDS: dict[str, Kind] = {
    "range(ball)": Continuous(),
    "bearing(ball)": Toroidal(),
    "color": Categorical(("green", "none", "red")),
}
UNITS = {"range(ball)": "m", "bearing(ball)": "rad", "color": ""}
VALUES = st.one_of(st.just(float("nan")), st.floats(-1e6, 1e6))


def make_ticks(values: list[tuple[float, int]], agent: str = "robot 0") -> Record:
    """A record whose readings are drawn."""
    times = np.arange(len(values), dtype=np.float64) * 0.1
    return make_record(
        agent=agent,
        tick_s=0.1,
        times=times,
        states=tuple(("fetch", "forward") if label else () for _, label in values),
        readings={
            "range(ball)": np.array([value for value, _ in values]),
            "bearing(ball)": np.array([abs(value) % 6.0 for value, _ in values]),
            "color": np.array([label if label < 3 else np.nan for _, label in values], np.float64),
        },
        kinds=KINDS,
        units=UNITS,
        commands={"drive": np.array([0.5 * label for _, label in values])},
        channel_units={"drive": "m/s"},
        source="somewhere",
        presses=(),
        behavior="",
        seed=None,
    )


@pytest.mark.parametrize("suffix", [".csv", ".jsonl", ".parquet"])
@given(rows=st.lists(st.tuples(VALUES, st.integers(0, 3)), min_size=2, max_size=6))
def test_what_was_written_is_read(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, rows: list[tuple[float, int]]
) -> None:
    pytest.importorskip("duckdb")
    rows = [*rows, (1.0, 0), (1.0, 1), (1.0, 2)]  # all labels occur, without which texts do not tell them
    written = [make_ticks(rows), make_ticks(rows[::-1], "robot 1")]
    path = tmp_path_factory.mktemp("ticks") / f"ticks{suffix}"
    write_table(make_tick_table(written), path)
    assert is_tick_table(path)
    for read, one in zip(read_records(path), written, strict=True):
        assert (read.agent, read.states) == (one.agent, one.states)
        np.testing.assert_allclose(read.times, one.times)
        for label, column in one.columns.items():
            np.testing.assert_array_equal(read.columns[label], column)
        np.testing.assert_array_equal(read.commands, one.commands)
        if suffix == ".parquet":
            assert (read.readings, read.channels) == (one.readings, one.channels)


def read_drive(path: Path, robot: int = 0) -> Record:
    return choose_agent(read_tick_records(path), path, robot)


def test_a_data_set_of_lerobot_is_read(tmp_path: Path) -> None:
    pytest.importorskip("duckdb")
    rows = [(float(tick), tick % 4) for tick in range(20)]
    written = [make_ticks(rows), make_ticks(rows[::-1])]
    write_lerobot(written, tmp_path / "set")
    for read, one in zip(read_lerobot(tmp_path / "set"), written, strict=True):
        assert (read.agent, read.states, read.tick_s) == (one.agent, one.states, one.tick_s)
        assert (read.readings, read.channels) == (one.readings, one.channels)
        np.testing.assert_array_equal(read.times, one.times)
        for label, column in one.columns.items():
            np.testing.assert_array_equal(read.columns[label], column)
        np.testing.assert_array_equal(read.commands, one.commands)
    (tmp_path / "set/meta/info.json").write_text(
        (tmp_path / "set/meta/info.json").read_text().replace('"v3.0"', '"v2.1"')
    )
    with pytest.raises(FileError, match=r"convert it to v3\.0"):
        read_lerobot(tmp_path / "set")


def test_what_a_file_cannot_hold_is_said(tmp_path: Path) -> None:
    records = [make_ticks([(1.0, 0), (2.0, 1), (3.0, 2)])]
    (said,) = describe_losses(records, "csv")
    assert said.startswith(
        "it has no place for units and kinds of readings, and that bearing(ball) is on a circle"
    )
    assert describe_losses(records, "parquet") == []
    write_table(make_tick_table(records), tmp_path / "out.csv")
    assert "does not say units and kinds" in read_drive(tmp_path / "out.csv").omissions[-1]


def test_a_drive_of_each_agent_is_read(tmp_path: Path) -> None:
    rows = [(float(tick), tick % 3) for tick in range(20)]
    write_table(
        make_tick_table([make_ticks(rows), make_ticks(rows[::-1], "robot 1")]), tmp_path / "out.jsonl"
    )
    first, second = (read_drive(tmp_path / "out.jsonl", robot=robot) for robot in (0, 1))
    np.testing.assert_array_equal(first.commands, second.commands[::-1])
    with pytest.raises(SettingError, match="count from 0 to 1: they are robot 0 and robot 1"):
        read_drive(tmp_path / "out.jsonl", robot=2)


def test_the_length_of_a_tick_is_that_of_the_file(tmp_path: Path) -> None:
    """Also for an episode of one tick, and where times jitter a little."""
    text = "episode,agent,tick,time_s,states,reading.x,command.drive\n"
    text += "".join(f"0,robot 0,{tick},{tick / 10 + 1e-5 * (tick % 2):.6f},,{tick},1\n" for tick in range(9))
    (tmp_path / "out.csv").write_text(text + "1,robot 0,0,0.0,,1,0\n")
    assert [each.tick_s for each in read_tick_records(tmp_path / "out.csv")] == [0.1, 0.1]


def test_rows_with_too_few_cells_are_left_out_and_said(tmp_path: Path) -> None:
    rows = "".join(f"0,robot 0,{tick},{tick / 10},,{tick},1\n" for tick in range(5))
    cut = rows.replace("0,robot 0,2,0.2,,2,1", "0,robot 0")
    titles = "episode,agent,tick,time_s,states,reading.x,command.drive"
    (tmp_path / "out.csv").write_text(f"{titles}\n{cut}")
    (record,) = read_tick_records(tmp_path / "out.csv")
    assert record.ticks == 4
    assert "at line 4: 1 of 5 rows have too few cells; left out" in record.omissions[0]


def test_states_of_levels_have_their_own_columns(tmp_path: Path) -> None:
    record = make_ticks([(1.0, 0), (1.0, 1), (1.0, 2)])
    named = replace(record, states=(("a > b", "c"), ("a > b",), ()))
    write_table(make_tick_table([named]), tmp_path / "out.csv")
    assert read_tick_records(tmp_path / "out.csv")[0].states == named.states


def test_units_that_differ_are_not_taken_for_one(tmp_path: Path) -> None:
    """A data set is refused; a table says nothing of the unit, which is said when it is read."""
    meters, centimeters = (
        make_record(readings={"r": np.ones(3)}, kinds={}, units={"r": unit}, presses=())
        for unit in ("m", "cm")
    )
    with pytest.raises(DefinitionError, match="r is in cm, and in m in the first episode"):
        write_lerobot([meters, centimeters], tmp_path / "set")
    write_table(make_tick_table([meters, centimeters]), tmp_path / "out.parquet")
    first, _ = read_tick_records(tmp_path / "out.parquet")
    assert first.find_unit(("r", None)) == ""
    assert "does not say units" in first.omissions[0]


@pytest.mark.parametrize("write", [write_lerobot, write_minari, None])
def test_kinds_that_are_unknown_stay_unknown(
    write: Callable[[Sequence[Record], Path], None] | None, tmp_path: Path
) -> None:
    """From CSV, which does not say them, to another form, which could."""
    write_table(make_tick_table([make_ticks([(1.0, 0), (2.0, 1), (3.0, 2)])]), tmp_path / "out.csv")
    unknown = read_tick_records(tmp_path / "out.csv")
    path = tmp_path / ("again.parquet" if write is None else "set-v0")
    if write is None:
        write_table(make_tick_table(unknown), path)
    else:
        write(unknown, path)
    (again,) = read_run(path)
    assert not again.kinds_known
    assert any("does not say units and kinds" in each for each in again.omissions)


def test_drives_of_one_name_are_left_out_one_by_one(tmp_path: Path) -> None:
    """Examples are known by source and time: of two drives that begin at 0, each has a source of its own."""
    joined = join_records([make_ticks([(1.0, 0), (2.0, 1)]), make_ticks([(3.0, 0), (4.0, 1)])])
    assert [each.source for each in joined.episodes] == ["somewhere", "somewhere (2)"]


BAD = [
    (
        "episode,agent,tick,time_s,states,reading.x\n0,robot 0,0,0.0,,1,7\n",
        "at line 2: it has 7 cells, and the first line 6",
    ),
    (
        "episode,agent,tick,time_s,states,reading.x,reading.x\n0,robot 0,0,0.0,,1,2\n",
        "two columns are called",
    ),
    ("episode,agent,tick,time_s,states\n", "it has no tick"),
    ("episode,agent,tick,time_s\n0,robot 0,0,0.0\n", "it has no column 'states'"),
    (
        "episode,agent,tick,time_s,states\n0,robot 0,0,soon,\n",
        "a row of it is not as tables of ticks have them",
    ),
]


@pytest.mark.parametrize(("text", "problem"), BAD)
def test_what_is_no_table_of_ticks_is_refused(tmp_path: Path, text: str, problem: str) -> None:
    (tmp_path / "out.csv").write_text(text)
    with pytest.raises(FileError, match=problem):
        read_tick_records(tmp_path / "out.csv")
