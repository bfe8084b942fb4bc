"""Mapping files: the example of the documentation, its table of keys, and what is said about invalid ones."""

import re
from pathlib import Path

import pytest
from tests.docs.pages import ROOT, blocks

from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.addons.recordings.mapping_file import (
    UNITS,
    CommandColumn,
    ReadingColumn,
    RecordingMap,
    load_recording_map,
)
from understudy.errors import FileError

PAGE = ROOT / "docs" / "formats.md"
EXAMPLE = next(each.text for each in blocks(PAGE) if each.text.startswith("format = "))
SECTION = PAGE.read_text(encoding="utf-8").split("## A mapping file")[1].split("\n## ")[0]


def load(folder: Path, text: str) -> RecordingMap:
    path = folder / "map.toml"
    path.write_text(text, encoding="utf-8")
    return load_recording_map(path)


def test_the_example_maps_a_table(tmp_path: Path) -> None:
    rows = [f"{100 * tick},{300 - tick},{tick % 2},{100 if tick < 50 else -50}" for tick in range(100)]
    (tmp_path / "drive.csv").write_text("\n".join(["stamp_ms,ball_cm,gripper,stick_y", *rows]))
    drive = read_recorded_drive(tmp_path / "drive.csv", load(tmp_path, EXAMPLE))
    assert drive.times[10] == pytest.approx(1.0)
    assert drive.values["range", "ball"][:2].tolist() == pytest.approx([3.0, 2.99])
    assert drive.values["gripper", None][:2].tolist() == [0.0, 1.0]
    assert drive.commands[[0, 99], 0].tolist() == pytest.approx([1.0, -0.5])
    assert [str(each.kind) for each in drive.readings] == ["continuous", "categorical(open|closed)"]


def test_the_page_has_every_key_and_unit() -> None:
    keys = set(re.findall(r"^\| `([\w.]+)`", SECTION, re.MULTILINE))
    parts = {"readings.": ReadingColumn, "commands.": CommandColumn, "": RecordingMap}
    fields = {prefix + field for prefix, part in parts.items() for field in part.__struct_fields__}
    assert keys == fields - {"behaviors"} | {"behaviors.NAME"}
    named = SECTION.split("Units are ")[1].split(". ")[0]
    assert set(re.split(r"; and |[,;]? and |[,;] ", named)) == {unit for unit in UNITS if unit}


INVALID = [  # what is replaced in the example, by what, the place and the problem that are named
    ("map/1", "map/2", "format: is 'understudy-recording-map/2'"),
    ('unit = "cm"', 'unit = "inch"', r"readings\[0\].unit: is 'inch'"),
    ('kind = "categorical(open|closed)"', 'kind = "round"', r"readings\[1\].kind"),
    ("scale = 0.01", "scale = 0", r"commands\[0\].scale: is 0"),
    ("tick_s = 0.1", "tick_s = -1", "tick_s: is -1"),
    ("drive = 0.8", "fly = 0.8", "behaviors.forward.fly: is no channel"),
    ('target = "ball"', "targets = 1", r"readings\[0\]"),
]


@pytest.mark.parametrize(("former", "new", "problem"), INVALID)
def test_invalid_files_are_refused(tmp_path: Path, former: str, new: str, problem: str) -> None:
    assert former in EXAMPLE
    with pytest.raises(FileError, match=problem.replace(": ", ".*")):
        load(tmp_path, EXAMPLE.replace(former, new))
