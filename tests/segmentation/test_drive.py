"""From a table of a drive to an automaton, and what is said about tables that are not as they should be."""

import json
from pathlib import Path

import numpy as np
import pytest
from tests.segmentation.driven import MAP
from typer.testing import CliRunner

from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.errors import FileError
from understudy.ui.cli.main import make_command_line

HEADER = "time_s,range(ball),command.drive"


def make_drive(*, noise: float = 0.03) -> list[str]:
    """Rows of a drive to and fro: forward from 3 m to 1 m, then back."""
    random, rows, distance, drive = np.random.default_rng(0), [HEADER], 3.0, 0.8
    for tick in range(300):
        drive = -0.5 if distance < 1.0 else 0.8 if distance > 3.0 else drive
        rows.append(f"{tick / 10:.1f},{distance:.4f},{drive + noise * random.normal():.4f}")
        distance -= 0.1 * drive
    return rows


def write(path: Path, rows: list[str]) -> Path:
    path.write_text("\n".join(rows) + "\n")
    return path


def test_a_drive_becomes_an_automaton(tmp_path: Path) -> None:
    drive, mapping = write(tmp_path / "drive.csv", make_drive()), tmp_path / "map.toml"
    mapping.write_text(MAP)
    arguments = ["learn", "--recording", str(drive), "--map", str(mapping), "--reaction", "0", "--json"]
    done = CliRunner().invoke(make_command_line(), arguments)
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert {each["label"] for each in told["drive"]["spans"]} == {"forward", "back"}
    (leaves, stays) = told["states"]["forward"]["conditions"]
    assert leaves.startswith("back when range(ball) is below")
    assert float(leaves.split("below ")[1].split()[0]) == pytest.approx(1.0, abs=0.1)
    assert stays == "stays otherwise"


def test_the_report_is_printed(tmp_path: Path) -> None:
    drive, mapping = write(tmp_path / "drive.csv", make_drive()), tmp_path / "map.toml"
    mapping.write_text(MAP)
    done = CliRunner().invoke(
        make_command_line(), ["learn", "--recording", str(drive), "--map", str(mapping)]
    )
    assert done.exit_code == 0, done.output
    assert "Driver on drive: noise 0.03" in done.stdout
    assert "100 % of the way in a tick" in done.stdout


SAID = [  # row that is changed, what it becomes, what is said about it, episodes
    (100, "9.9,abc,0.8", "line 101, column 'range(ball)': 'abc' is no number; taken as absent", 1),
    (
        100,
        "9.9,2.0,nan",
        "1 of 300 rows have no command of drive; the last one holds, at most 0.1 s (line 101)",
        1,
    ),
    (300, "29.9,2.0", "line 301: 2 cells instead of 3; the file ends in the middle of it", 1),
    (200, "3.0,2.0,0.8", "line 201: time goes back from 19.8 to 3 s; another episode begins", 3),
]


@pytest.mark.parametrize(("row", "becomes", "said", "episodes"), SAID)
def test_what_cannot_be_used_is_said(
    tmp_path: Path, row: int, becomes: str, said: str, episodes: int
) -> None:
    rows = make_drive()
    rows[row] = becomes
    drive = read_recorded_drive(write(tmp_path / "drive.csv", rows))
    assert said in drive.omissions[0]
    assert len(drive.episodes) == episodes


def test_a_gap_ends_an_episode(tmp_path: Path) -> None:
    rows = make_drive()
    drive = read_recorded_drive(write(tmp_path / "drive.csv", rows[:100] + rows[150:]))
    assert [each.end - each.first for each in drive.episodes] == [99, 151]


REFUSED = [
    ([HEADER, "0,1,0.5", "0.1,1,0.5"], "its commands never change"),
    (["time_s,range", "0,1"], "there is no column such as 'command.drive'"),
    ([], "it has fewer than two rows|it is empty|there is no column"),
]


@pytest.mark.parametrize(("rows", "problem"), REFUSED)
def test_what_is_no_drive_is_refused(tmp_path: Path, rows: list[str], problem: str) -> None:
    with pytest.raises(FileError, match=problem):
        read_recorded_drive(write(tmp_path / "drive.csv", rows))


def test_all_kinds_of_tables_give_the_same_drive(tmp_path: Path) -> None:
    duckdb = pytest.importorskip("duckdb")
    rows = make_drive()
    plain = read_recorded_drive(write(tmp_path / "drive.csv", rows))
    names = HEADER.split(",")
    objects = [json.dumps(dict(zip(names, map(float, row.split(",")), strict=True))) for row in rows[1:]]
    lines = read_recorded_drive(write(tmp_path / "drive.jsonl", objects))
    with duckdb.connect() as database:
        made = f"COPY (SELECT * FROM read_csv('{tmp_path / 'drive.csv'}')) TO '{tmp_path / 'drive.parquet'}'"
        database.execute(made + " (FORMAT parquet)")
    packed = read_recorded_drive(tmp_path / "drive.parquet")
    for other in (lines, packed):
        np.testing.assert_array_equal(other.times, plain.times)
        np.testing.assert_array_equal(other.commands, plain.commands)
        np.testing.assert_array_equal(other.values["range", "ball"], plain.values["range", "ball"])


def test_what_is_no_parquet_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("duckdb")
    with pytest.raises(FileError, match="it cannot be read"):
        read_recorded_drive(write(tmp_path / "drive.parquet", ["no", "table"]))


def test_features_of_the_command_help_to_find_switches(tmp_path: Path) -> None:
    """With much noise, the distance says when the driver switched better than the commands do."""
    rows, mapping, wrong = make_drive(noise=0.8), tmp_path / "map.toml", []
    mapping.write_text(MAP)
    drive = write(tmp_path / "drive.csv", rows)
    nearer = np.diff([float(row.split(",")[1]) for row in rows[1:]]) < 0
    meant = ["forward" if each else "back" for each in nearer]
    arguments = ["learn", "--recording", str(drive), "--map", str(mapping), "--reaction", "0", "--json"]
    for more in ([], ["--features", "range(ball),time_in_state"]):
        done = CliRunner().invoke(make_command_line(), [*arguments, *more])
        assert done.exit_code == 0, done.output
        spans = json.loads(done.stdout)["drive"]["spans"]
        found = [each["label"] for each in spans for _ in range(round((each["to_s"] - each["from_s"]) * 10))]
        wrong.append(sum(one != other for one, other in zip(found, meant, strict=False)))
    assert wrong[1] < wrong[0]
