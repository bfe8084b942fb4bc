"""What was learned from a drive or a table works everywhere without a kit of one's own."""

import json
from pathlib import Path

import pytest
from tests.segmentation.test_drive import make_drive, write
from typer.testing import CliRunner

from understudy.ui.cli.main import make_command_line

DEFINED = ["--define", "forward: drive 0.8", "--define", "back: drive -0.5", "--features", "range(ball)"]
TABLE = "state,next,kind,front:continuous\ncruise,cruise,default,3\ncruise,avoid,directive,1\navoid,avoid,default,1\n"


def run(*arguments: object, exit_code: int = 0) -> str:
    done = CliRunner().invoke(make_command_line(), [str(each) for each in arguments])
    assert done.exit_code == exit_code, done.output
    return done.output


@pytest.fixture
def driven(tmp_path: Path) -> Path:
    write(tmp_path / "drive.csv", make_drive())
    run("learn", "drive", tmp_path / "drive.csv", *DEFINED, "--library", tmp_path / "lib", "--name", "driven")
    return tmp_path


def test_a_drive_is_repeated_over_its_recording(driven: Path) -> None:
    replayed = json.loads(run("replay", driven / "drive.csv", "--library", driven / "lib", "--json"))
    assert {each["state"] for each in replayed["spans"]} == {"forward", "back"}
    assert replayed["agreement"]["repeated"] >= 0.98 * replayed["agreement"]["ticks"]


@pytest.mark.parametrize("target", ["c99", "python", "btcpp", "xstate"])
def test_it_is_exported(driven: Path, target: str) -> None:
    run("export", "driven", "--library", driven / "lib", "--to", target, "--out", driven / target)
    assert any((driven / target).iterdir())


@pytest.mark.parametrize("command", ["test", "check"])
def test_it_is_tested_and_checked(driven: Path, command: str) -> None:
    assert "driven" in run(command, driven / "lib")


def test_a_table_is_tested_and_exported(tmp_path: Path) -> None:
    (tmp_path / "wall.csv").write_text(TABLE)
    run("learn", "table", tmp_path / "wall.csv", "--library", tmp_path / "lib", "--name", "wall")
    assert "wall" in run("test", tmp_path / "lib")
    run("export", "wall", "--library", tmp_path / "lib", "--to", "c99", "--out", tmp_path / "c")
    said = run("replay", write(tmp_path / "d.csv", make_drive()), "--library", tmp_path / "lib", exit_code=2)
    assert "whose states command nothing" in said


@pytest.mark.parametrize("command", ["run", "eval"])
def test_a_world_that_does_not_fit_is_refused_with_what_does(driven: Path, command: str) -> None:
    said = run(command, "--library", driven / "lib", exit_code=2)
    assert "was learned from a recording" in said
    assert "understudy replay FILE" in said


def test_two_tables_with_other_labels_are_learned_together(tmp_path: Path) -> None:
    """The first has no blue, the second no green; the rule is about all labels."""
    colors = {"a.csv": ("red", "green"), "b.csv": ("red", "blue")}
    for name, (ahead, back) in colors.items():
        rows = [
            f"{tick / 10},{ahead if tick % 20 < 10 else back},{0.8 if tick % 20 < 10 else -0.5}"
            for tick in range(200)
        ]
        (tmp_path / name).write_text("\n".join(["time_s,color,command.drive", *rows]))
    said = run(
        "learn", "drive", tmp_path / "a.csv", tmp_path / "b.csv", *DEFINED[:4], "--features", "color",
        "--library", tmp_path / "lib", "--name", "colored",
    )  # fmt: skip
    assert "back when color is not red" in said
