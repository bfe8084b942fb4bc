"""Cells as people have them: numbers, labels, truth values, or nothing."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.segmentation.test_row_times import SECONDS

from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.addons.recordings.mapping_file import load_recording_map
from understudy.addons.recordings.table_cells import format_label, read_cells
from understudy.errors import DefinitionError, FileError
from understudy.model.value_kinds import BOOLEAN, Categorical, Continuous, Kind
from understudy.records.join_records import align_labels, join_records
from understudy.records.record import Record

nan = np.nan
NUMBERS = Continuous()
CELLS: list[tuple[Sequence[Any], Kind | None, list[float], list[int]]] = [
    # cells, their kind, values, rows that are wrong
    ([1, 2.5, None], NUMBERS, [1, 2.5, nan], []),
    (["1", " -2.5e1 ", "+3.", ".5"], NUMBERS, [1, -25, 3, 0.5], []),
    (["1", "", "NaN", "n/a", "null", "-"], NUMBERS, [1, nan, nan, nan, nan, nan], []),
    (["\N{MINUS SIGN}1", "2"], NUMBERS, [-1, 2], []),
    (["1", "2", "inf", "-Infinity"], NUMBERS, [1, 2, nan, nan], [2, 3]),
    ([1, 2, 10**400], NUMBERS, [1, 2, nan], [2]),
    (["1", "2", "3", "err"], NUMBERS, [1, 2, 3, nan], [3]),
    (["1", "2", "3", "1_000"], NUMBERS, [1, 2, 3, nan], [3]),
    (["1", "2", "3", "0x1f"], NUMBERS, [1, 2, 3, nan], [3]),
    (["open", "closed", "open"], Categorical(("closed", "open")), [1, 0, 1], []),
    (["open", "", None], Categorical(("open",)), [0, nan, nan], []),
    (["near", "far", "2.0"], Categorical(("2.0", "far", "near")), [2, 1, 0], []),
    (["two  words", "two\nwords"], Categorical(("two words",)), [0, 0], []),
    ([True, False, None], BOOLEAN, [1, 0, nan], []),
    (["TRUE", "no", "Yes", "false"], BOOLEAN, [1, 0, 1, 0], []),
    (["true", "0", "1"], BOOLEAN, [1, 0, 1], []),
    ([True, "2", "3", "4"], NUMBERS, [1, 2, 3, 4], []),
    ([f"id {row}" for row in range(21)], None, [nan] * 21, []),
    (["a|b", "c"], None, [nan, nan], []),
    (["", None], NUMBERS, [nan, nan], []),
]


@pytest.mark.parametrize(("cells", "kind", "values", "wrong"), CELLS)
def test_cells(cells: Sequence[Any], kind: Kind | None, values: list[float], wrong: list[int]) -> None:
    read = read_cells(cells)
    assert read.kind == kind
    np.testing.assert_array_equal(read.values, values)
    assert read.wrong == wrong


GIVEN: list[tuple[Sequence[Any], Kind, list[float], list[int]]] = [
    # cells, the kind that is given, values, rows that are wrong
    (["red", "none", ""], Categorical(("none", "red")), [1, 0, nan], []),
    ([0, 1.0, "2"], Categorical(("a", "b", "c")), [0, 1, 2], []),
    ([0, 1.5, 3], Categorical(("a", "b", "c")), [0, nan, nan], [1, 2]),
    (["1", "2"], Categorical(("2", "1")), [1, 0], []),
    (["red", "blue"], Categorical(("none", "red")), [1, nan], [1]),
    (["on", "true", "0"], BOOLEAN, [nan, 1, 0], [0]),
    (["1", "open"], NUMBERS, [1, nan], [1]),
]


@pytest.mark.parametrize(("cells", "kind", "values", "wrong"), GIVEN)
def test_cells_of_a_kind(cells: Sequence[Any], kind: Kind, values: list[float], wrong: list[int]) -> None:
    read = read_cells(cells, kind)
    np.testing.assert_array_equal(read.values, values)
    assert read.wrong == wrong


def test_labels_of_numbers() -> None:
    assert [format_label(each) for each in (2.0, 2.5, " a  b ", True)] == ["2", "2.5", "a b", "True"]


SAID = [  # the cells of a column in turn, what is said
    (["open", "closed"], None),
    (["rover"], "column 'x': 'rover' in all rows, which tells nothing"),
    ([f"id{row}" for row in range(100)], "column 'x': 100 different texts, such as 'id0'; left out"),
    (["a|b", "c"], "column 'x': texts with | in them, such as 'a|b'; left out"),
    (["1 m", "2 m"], "column 'x': texts, such as '1 m', are taken as labels and not as numbers"),
    (["1", "2", "3", "err"], "line 5, column 'x': 'err' and 24 more is no number; taken as absent"),
    (["1", "", "3"], "x is absent in 33 of 100 rows"),
    (["inf"], "line 2, column 'x': 'inf' and 99 more is no number; taken as absent"),
]


def read(folder: Path, cells: Sequence[str], name: str = "drive.csv") -> Record:
    rows = [f"{at},{cells[row % len(cells)]},{row % 20 // 10}" for row, at in enumerate(SECONDS)]
    (folder / name).write_text("\n".join(["time_s,x,command.drive", *rows]))
    return read_recorded_drive(folder / name)


@pytest.mark.parametrize(("cells", "said"), SAID, ids=[str(each[1]) for each in SAID])
def test_what_is_guessed_or_left_out_is_said(tmp_path: Path, cells: Sequence[str], said: str | None) -> None:
    drive = read(tmp_path, cells)
    assert (said in drive.omissions[0]) if said else drive.omissions == ()
    assert (("x", None) in drive.values) == (said is None or "left out" not in said)


@pytest.mark.parametrize(
    ("cells", "problem"), [("far,near", "'far' and 99 more is no number"), ("0.5,2", "is no label")]
)
def test_cells_of_which_none_is_of_the_kind_are_refused(tmp_path: Path, cells: str, problem: str) -> None:
    read(tmp_path, cells.split(","))
    kind = "continuous" if "far" in cells else "categorical(a|b)"
    (tmp_path / "map.toml").write_text(
        'format = "understudy-recording-map/1"\ntime = "time_s"\n'
        f'[[readings]]\ncolumn = "x"\nkind = "{kind}"\n[[commands]]\ncolumn = "command.drive"\n'
    )
    with pytest.raises(FileError, match=problem):
        read_recorded_drive(tmp_path / "drive.csv", load_recording_map(tmp_path / "map.toml"))


JOINED = [  # the cells of each file, the labels of all, the first labels of each
    (["closed", "open"], ["open", "stuck"], "closed|open|stuck", ["closed", "open"]),
    (["open"], ["closed", "open"], "closed|open", ["open", "closed"]),
    (["", ""], ["closed", "open"], "closed|open", [None, "closed"]),
    (["yes", "no"], ["true", "false"], "no|yes", ["yes", "yes"]),
]


@pytest.mark.parametrize(("ours", "theirs", "labels", "firsts"), JOINED)
def test_labels_of_several_files(
    tmp_path: Path, ours: list[str], theirs: list[str], labels: str, firsts: list[str | None]
) -> None:
    drives = [read(tmp_path, ours, "ours.csv"), read(tmp_path, theirs, "theirs.csv")]
    joined = join_records(drives)
    (reading,) = joined.readings
    assert str(reading.kind) == f"categorical({labels})"
    names = [
        None if np.isnan(each) else labels.split("|")[int(each)]
        for each in joined.values["x", None][[0, 100]]
    ]
    assert names == firsts
    aligned = align_labels(drives)
    assert [each.readings for each in aligned] == [joined.readings] * 2
    np.testing.assert_array_equal(
        joined.values["x", None], np.concatenate([each.values["x", None] for each in aligned])
    )


def test_numbers_and_labels_of_one_reading_are_refused(tmp_path: Path) -> None:
    drives = [read(tmp_path, ["1", "2"], "ours.csv"), read(tmp_path, ["a", "b"], "theirs.csv")]
    with pytest.raises(
        DefinitionError, match=r"theirs.csv: its values of x are categorical\(a\|b\), but those of ours"
    ):
        join_records(drives)
