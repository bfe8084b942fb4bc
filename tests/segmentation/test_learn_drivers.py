"""`understudy learn` with recordings of several drivers: their names, what is printed, and who is trusted."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from tests.segmentation.driven import ANNA, BEN, FAR, MAP
from typer.testing import CliRunner

from understudy.ui.cli.main import make_command_line


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with recordings of Anna, in two files, and of Ben, who goes back earlier."""
    made = tmp_path_factory.mktemp("recorded")
    ANNA.write(made / "anna.csv", seconds=45.0)
    replace(ANNA, seed=7).write(made / "anna 2.csv", seconds=45.0)
    FAR.write(made / "ben.csv")
    (made / "map.toml").write_text(MAP)
    return made


def call(folder: Path, *arguments: str) -> tuple[int, str, str]:
    """Call `understudy learn` in a folder on recordings with its mapping file."""
    given = [
        str(folder / each) if (folder / each).suffix in (".csv", ".toml") else each for each in arguments
    ]
    done = CliRunner().invoke(make_command_line(), ["learn", "--map", str(folder / "map.toml"), *given])
    return done.exit_code, done.stdout, " ".join(done.stderr.split())


THREE = (
    "--recording", "anna.csv", "--recording", "ben.csv", "--recording", "anna 2.csv",
    "--driver", "anna", "--driver", "ben", "--driver", "anna",
)  # fmt: skip


def test_the_command_merges_drivers(recordings: Path) -> None:
    code, out, wrong = call(recordings, *THREE, "--json")
    assert code == 0, wrong
    told = json.loads(out)
    assert "drive" not in told
    assert list(told["drivers"]) == ["anna", "ben"]
    assert {each["file"] for each in told["drivers"]["anna"]["spans"]} == {"anna.csv", "anna 2.csv"}
    noise = {name: each["driver"][0]["noise"] for name, each in told["drivers"].items()}
    assert noise == {"anna": pytest.approx(0.03, abs=0.01), "ben": pytest.approx(0.12, abs=0.03)}
    (row,) = told["contradictions"]
    assert (row["drivers"], row["nexts"], row["settled"]) == (["anna", "ben"], ["forward", "back"], False)
    assert "ben switches from forward to back" in row["sentence"]
    assert (told["trusted"], told["quarantined"]) == (None, 0)


@pytest.mark.parametrize(("trusted", "turn"), [("anna", 1.0), ("ben", 2.0)])
def test_the_command_settles(recordings: Path, trusted: str, turn: float) -> None:
    code, out, wrong = call(recordings, *THREE, "--trust", trusted, "--json")
    assert code == 0, wrong
    told = json.loads(out)
    assert told["contradictions"][0]["settled"] is True
    assert told["quarantined"] > 0
    leaves = told["states"]["forward"]["conditions"][0].replace("at most", "below")
    assert float(leaves.split("below ")[1].split()[0]) == pytest.approx(turn, abs=0.1)


def test_the_command_prints_drivers_and_contradictions(recordings: Path) -> None:
    code, out, wrong = call(recordings, *THREE)
    assert code == 0, wrong
    assert "\nanna\n" in out
    assert "\nben\n" in out
    assert "1 contradiction between drivers\n  anna stays in forward at range(ball) = " in out
    assert "--trust NAME leaves out" in out
    code, out, wrong = call(recordings, *THREE, "--trust", "ben")
    assert "ben is trusted: " in out


def test_recordings_of_one_driver_are_one_drive(recordings: Path) -> None:
    both = ("--recording", "anna.csv", "--recording", "anna 2.csv", "--driver", "anna", "--driver", "anna")
    code, out, wrong = call(recordings, *both, "--json")
    assert code == 0, wrong
    told = json.loads(out)
    assert {"drivers", "contradictions"}.isdisjoint(told)
    assert {each["file"] for each in told["drive"]["spans"]} == {"anna.csv", "anna 2.csv"}


def test_saved_examples_say_where_they_are_from(recordings: Path) -> None:
    code, out, wrong = call(
        recordings, *THREE, "--library", str(recordings / "kept"), "--name", "driven", "--json"
    )
    assert code == 0, wrong
    told = json.loads(out)
    shown = CliRunner().invoke(
        make_command_line(), ["show", "driven", "--library", str(recordings / "kept"), "--json"]
    )
    described = json.loads(shown.stdout)
    examples, times = described["examples"], described["options"]["reaction_times_of_drivers_s"]
    assert times == sorted({each["reaction_s"] for each in told["drivers"].values()})
    assert {(each["source"]["driver"], each["source"]["file"]) for each in examples} == {
        ("anna", "anna.csv"),
        ("anna", "anna 2.csv"),
        ("ben", "ben.csv"),
    }
    text = (
        CliRunner()
        .invoke(make_command_line(), ["show", "driven", "--library", str(recordings / "kept")])
        .stdout
    )
    assert f"presses taken {times[0]:g} or {times[1]:g} s earlier" in " ".join(text.split())
    assert "anna.csv at 0.0 s" in text


BY_FILE = ("--recording", "anna.csv", "--recording", "ben.csv")
REFUSED = [
    ((*BY_FILE, "--driver", "anna"), "--driver is given once for 2 recordings"),
    ((*BY_FILE, "--driver", "anna", "--driver", " "), "--driver is an empty name"),
    (("--recording", "ben.csv", "--recording", "ben.csv"), "two recordings are called 'ben'"),
    (("--recording", "ben.csv", "--trust", "ben"), "--trust is not used with one driver"),
    ((*BY_FILE, "--trust", "bob"), "has no driver 'bob'; it has anna and ben"),
]


@pytest.mark.parametrize(("arguments", "problem"), REFUSED)
def test_the_command_refuses(recordings: Path, arguments: tuple[str, ...], problem: str) -> None:
    code, _, wrong = call(recordings, *arguments)
    assert code == 2
    assert problem in wrong


def test_the_command_refuses_other_robots(recordings: Path) -> None:
    rows = [row.replace("command.drive", "command.move") for row in BEN.drive(30.0)]
    (recordings / "other.csv").write_text("\n".join(rows) + "\n")
    done = CliRunner().invoke(
        make_command_line(),
        ["learn", "--recording", str(recordings / "anna.csv"), "--recording", str(recordings / "other.csv")],
    )
    assert done.exit_code == 2
    assert "recording other.csv: its channels are move, but those of anna.csv are drive" in " ".join(
        done.stderr.split()
    )
