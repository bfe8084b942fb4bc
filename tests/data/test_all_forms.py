"""Every form in which a run is written is read back, by itself and after another form, but for what it cannot hold."""

from __future__ import annotations

from itertools import product
from math import nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.make.record_files import WRITERS
from tests.make.records import make_record, without_commands
from tests.ui.cli.commands import run, run_json

from understudy.model.lesson import ExampleKind
from understudy.model.value_kinds import BOOLEAN, Categorical, Continuous, Toroidal
from understudy.records.record import Record, RecordedPress
from understudy.records.record_losses import LOSSES, Fact, describe_losses
from understudy.ui.cli.recorded_runs import read_run

for package in ("duckdb", "h5py", "mcap", "rosbags"):
    pytest.importorskip(package, reason="needs the extras parquet, minari and ros2")

COLORS = Categorical(("red", "green", "blue"))
KINDS = {"range(ball)": Continuous(), "bearing(ball)": Toroidal(), "ready": BOOLEAN, "color": COLORS}
UNITS = {"range(ball)": "m", "bearing(ball)": "rad"}


def make_run(numbers: list[float], agent: str = "robot 0") -> Record:
    """A run with everything that a record can have; each label occurs, without which texts do not tell them."""
    count = len(numbers)
    column = np.array(numbers)
    presses = (RecordedPress(0, "fetch", kind=ExampleKind.DIRECTIVE), RecordedPress(2, None))
    return make_record(
        agent=agent,
        tick_s=0.1,
        times=np.arange(count) / 10,
        states=tuple(("fetch", "go") if tick % 2 else ("wait",) if tick % 3 else () for tick in range(count)),
        readings={
            "range(ball)": column,
            "bearing(ball)": np.abs(column) % 6.0,
            "ready": np.array([nan if tick % 5 == 4 else tick % 2 for tick in range(count)]),
            "color": np.arange(count) % 3.0,
        },
        kinds=KINDS,
        units=UNITS,
        commands={"drive": np.sin(np.arange(count)), "turn": np.cos(np.arange(count))},
        channel_units={"drive": "m/s", "turn": "rad/s"},
        pose={"x": np.arange(count) / 4, "y": np.ones(count), "heading": np.zeros(count)},
        presses=presses,
        seed=7,
        behavior="forage",
        source="somewhere",
    )


def list_cells(record: Record) -> dict[str, list[Any]]:
    """The readings by label, labels as texts, absent as None."""
    return {
        label: [
            None if np.isnan(value) else kind.labels[int(value)] if isinstance(kind, Categorical) else value
            for value in column.tolist()
        ]
        for (label, column), kind in zip(
            record.columns.items(), map(record.find_kind, record.values), strict=True
        )
    }


def check_same(read: Record, written: Record, lost: set[Fact]) -> None:
    """What was read is what was written, but for facts that are lost."""
    last = -1 if Fact.LAST_COMMAND in lost else None
    assert read.agent.replace("_", " ") == written.agent
    assert (read.ticks, read.states) == (written.ticks, written.states)
    assert read.tick_s == pytest.approx(written.tick_s)
    np.testing.assert_allclose(read.times, written.times, atol=1e-6)
    assert list_cells(read) == list_cells(written)
    assert [each.name for each in read.channels] == [each.name for each in written.channels]
    np.testing.assert_array_equal(read.commands[:last], written.commands[:last])
    if Fact.KINDS not in lost:
        assert {each.name: (each.kind, each.unit, each.of_targets) for each in read.readings} == {
            each.name: (each.kind, each.unit, each.of_targets) for each in written.readings
        }
        assert [each.unit for each in read.channels] == [each.unit for each in written.channels]
    if Fact.POSE not in lost:
        for name, column in written.pose.items():
            np.testing.assert_allclose(read.pose[name], column, atol=1e-6)
    if Fact.RUN not in lost:
        assert (read.seed, read.behavior) == (written.seed, written.behavior)
    if Fact.PRESSES not in lost:
        pairs = zip(read.presses, written.presses, strict=True)
        assert all((one.tick, one.state) == (other.tick, other.state) for one, other in pairs)
    if not {Fact.PRESSES, Fact.PRESS_KINDS} & lost:
        assert read.presses == written.presses


NUMBERS = st.lists(st.one_of(st.just(nan), st.floats(-1e9, 1e9)), max_size=6)


@pytest.mark.parametrize("form", WRITERS)
@given(drawn=NUMBERS)
@settings(deadline=None, max_examples=6)
def test_what_is_written_is_read(form: str, drawn: list[float]) -> None:
    written = [make_run([1.5, 0.25, *drawn, -3.0], f"robot {number}") for number in range(2)]
    with TemporaryDirectory() as folder:
        found = read_run(WRITERS[form](written, Path(folder)))
    for read, one in zip(found, written, strict=True):
        check_same(read, one, set(LOSSES[form]))


@pytest.mark.parametrize(("first", "second"), [*product(WRITERS, WRITERS)])
def test_one_form_is_turned_into_another(first: str, second: str, tmp_path: Path) -> None:
    written = [make_run([1.5, nan, -2.0, 1 / 3, 1e6, 0.0], f"robot {number}") for number in range(2)]
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
    between = read_run(WRITERS[first](written, tmp_path / "one"))
    found = read_run(WRITERS[second](between, tmp_path / "two"))
    for read, one in zip(found, written, strict=True):
        check_same(read, one, {*LOSSES[first], *LOSSES[second]})


@pytest.mark.parametrize("form", WRITERS)
def test_every_form_is_learned_from_and_exported_by_commands(form: str, tmp_path: Path) -> None:
    """The driver goes ahead while the ball is far; no mapping file is given."""
    count = 60
    ranges = np.array([2.0 - 0.1 * (tick % 20) for tick in range(count)])
    ahead = ranges > 1.0
    driven = make_record(
        tick_s=0.1,
        times=np.arange(count) / 10,
        states=(("driven",),) * count,
        readings={"range(ball)": ranges},
        kinds={"range(ball)": Continuous()},
        units={"range(ball)": "m"},
        commands={"drive": np.where(ahead, 0.5, 0.0)},
        presses=(),
        pose={"x": ranges, "y": ranges, "heading": ranges},
        behavior="",
        seed=1,
    )
    path = WRITERS[form]([driven], tmp_path)
    kit = ["--kit", "tests.data.ball_kit:KIT"]
    learned = run_json(
        "learn",
        "drive",
        path,
        *kit,
        "--features",
        "range(ball)",
        "--library",
        tmp_path / "made",
        "--name",
        "near",
        "--behaviors",
        "ahead,stand",
    )
    (agreement,) = (
        each["agreement"] for each in learned.values() if isinstance(each, dict) and "agreement" in each
    )
    assert agreement["repeated"] >= 0.9 * agreement["ticks"]
    out = tmp_path / "again.parquet"
    assert run("export", "table", path, "--out", out).exit_code == 0
    assert [each.ticks for each in read_run(out)] == [count]


def test_what_a_form_cannot_hold_is_said_when_it_is_written(tmp_path: Path) -> None:
    path = WRITERS["lerobot"]([make_run([1.0, 2.0, 3.0, 4.0])], tmp_path)
    said = run("export", "table", path, "--out", tmp_path / "out.csv").stderr
    for fact in (
        "units and kinds of readings, and that bearing(ball) is on a circle",
        "presses (export the table of presses)",
        "the seed and the name of the automaton",
    ):
        assert f"out.csv: it has no place for {fact}" in said
    said = run("export", "dataset", path, "--to", "minari", "--out", tmp_path / "new-v0").stderr
    assert "it has no place for the command of the last tick of an episode" in said
    assert run("export", "dataset", path, "--to", "lerobot", "--out", tmp_path / "new").stderr == ""


def test_what_a_record_lacks_is_not_said_to_be_lost() -> None:
    bare = make_record(presses=(), seed=None, behavior="", readings={}, commands={}, pose={})
    assert [describe_losses([bare], form) for form in LOSSES] == [[]] * len(LOSSES)


@pytest.mark.parametrize("form", ["lerobot", "minari"])
def test_states_of_a_run_without_commands_are_no_commands(form: str, tmp_path: Path) -> None:
    (read,) = read_run(WRITERS[form]([without_commands()], tmp_path))
    assert (read.channels, read.commands.shape) == ((), (3, 0))
    assert read.states == (("fetch",), ("fetch",), ("deliver",))
