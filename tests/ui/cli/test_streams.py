"""What commands print where it cannot be shown or kept, and where they may write."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from inspect import signature
from io import BytesIO, TextIOWrapper
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import pytest
import typer
from typer.testing import CliRunner, Result

from understudy.ui.cli import run_command_line
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.main import COMMANDS as BUILTIN
from understudy.ui.cli.main import make_command_line
from understudy.ui.cli.plugins import CommandEntry

ROOT = Path(__file__).parents[3]
SELF = "state,next,kind,x:continuous\nloop,other,directive,1\n"


def process(*arguments: object, into: str = "", **environment: str) -> subprocess.CompletedProcess[bytes]:
    command = [sys.executable, "-m", "understudy.ui.cli", *map(str, arguments)]
    usual = {**os.environ, "PYTHONPATH": str(ROOT / "src"), "PYTHONUTF8": "0", **environment}
    if into:
        with Path(into).open("wb") as out:
            return subprocess.run(command, stdout=out, stderr=subprocess.PIPE, env=usual, check=False)
    return subprocess.run(command, capture_output=True, env=usual, check=False)


def leaves(name: str, command: Any) -> Iterator[tuple[str, Any]]:
    """All commands that are no groups of others, by their words."""
    children: dict[str, Any] = getattr(command, "commands", {})
    if not children:
        yield name.strip(), command
    for child, below in children.items():
        yield from leaves(f"{name} {child}", below)


COMMANDS = dict(leaves("", typer.main.get_command(make_command_line())))


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_prints_for_programs(name: str) -> None:
    """No exemptions: servers print where they are."""
    assert "--json" in {option for each in COMMANDS[name].params for option in each.opts}


OBJECTS = {
    "worlds": ((), "worlds"),
    "experiment": (("list",), "experiments"),
    "list": ((), "automata"),
    "show": (("goto",), "name"),
    "validate": ((), "valid"),
    "test": ((), "works"),
    "rebuild": ((), "rebuilt"),
}
"""What some print, by a key of it; that it is one object holds of all, for nothing else can be printed."""


@pytest.mark.parametrize("name", OBJECTS)
def test_what_is_printed_for_programs_is_one_object(name: str, library: Path) -> None:
    arguments, key = OBJECTS[name]
    of = () if name in ("worlds", "experiment") else ("-l", str(library))
    done = CliRunner().invoke(make_command_line(), [name, *arguments, *of, "--json"])
    assert done.exit_code == 0, done.output
    assert key in json.loads(done.stdout)


@pytest.mark.parametrize("result", [[], [1], "text", 3, None])
def test_nothing_but_an_object_is_printed(result: object) -> None:
    with pytest.raises(TypeError, match="one object"):
        print_json(result)


def run_with_encoding(encoding: str, *arguments: object) -> tuple[int, bytes]:
    """Run the command line where standard output and error have an encoding; return the exit code and the output."""
    out = BytesIO()
    stdout, stderr = (TextIOWrapper(each, encoding=encoding) for each in (out, BytesIO()))
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(sys, "argv", ["understudy", *map(str, arguments)])
        patched.setattr(sys, "stdout", stdout)
        patched.setattr(sys, "stderr", stderr)
        with pytest.raises(SystemExit) as end:
            run_command_line()
        stdout.flush()
        return int(end.value.code or 0), out.getvalue()


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252"])
def test_a_terminal_without_our_letters(library: Path, encoding: str) -> None:
    for command in (["validate"], ["show", "goto"]):
        code, text = run_with_encoding(encoding, *command, "-l", library)
        assert code == 0, text
        assert text
    code, text = run_with_encoding(encoding, "show", "goto", "-l", library, "--json")
    assert json.loads(text.decode("utf-8"))["name"] == "goto"


def test_a_process_whose_output_is_ascii(library: Path) -> None:
    done = process("show", "goto", "-l", library, PYTHONIOENCODING="ascii")
    assert done.returncode == 0, (done.stdout, done.stderr)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
@pytest.mark.parametrize("extra", [[], ["--json"]])
def test_an_output_that_is_full(library: Path, extra: list[str]) -> None:
    done = process("list", "-l", library, *extra, into="/dev/full")
    assert done.returncode == 2
    assert done.stderr.startswith(b"Error: standard output: ")
    assert done.stderr.count(b"\n") == 1


def test_a_reader_that_leaves_early(library: Path) -> None:
    read, written = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-m", "understudy.ui.cli", "list", "-l", str(library)],
        stdout=written,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
        check=False,
    )
    os.close(written)
    assert (done.returncode, done.stderr) == (0, b"")


def run(*arguments: object) -> Result:
    given = [*map(str, arguments)]
    return CliRunner(env={"COLUMNS": "80", "NO_COLOR": "1"}).invoke(make_command_line(), given)


@pytest.mark.parametrize("taken", ["out", "out/library", "out/pictures"])
def test_a_demo_that_cannot_keep_anything_does_not_begin(
    tmp_path: Path, taken: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def teach(*_: object, **__: object) -> None:
        raise AssertionError("it began")

    monkeypatch.setattr("understudy_lab.forage.teach.teach", teach)
    path = tmp_path / taken
    path.parent.mkdir(exist_ok=True)
    path.write_text("kept")
    result = run("demo", "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "--out" in result.stderr
    assert path.read_text() == "kept"


def test_learning_an_automaton_that_contains_itself(tmp_path: Path) -> None:
    table, folder = tmp_path / "table.csv", tmp_path / "library"
    table.write_text(SELF)
    result = run("learn", table, "--library", folder, "--name", "loop")
    assert result.exit_code == 2
    assert "contains itself (loop -> loop)" in result.stderr
    assert not folder.exists()
    assert run("learn", table, "--library", folder, "--name", "outer").exit_code == 0
    before = sorted(folder.rglob("*"))
    table.write_text("state,next,kind,x:continuous\nouter,halt,directive,1\n")
    result = run("learn", table, "--library", folder, "--name", "other")
    assert result.exit_code == 2
    assert "other -> outer -> other" in result.stderr
    assert sorted(folder.rglob("*")) == before


def test_learning_an_automaton_without_a_name(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text(SELF)
    result = run("learn", tmp_path / "table.csv", "--library", tmp_path / "library", "--name", "")
    assert result.exit_code == 2
    assert not (tmp_path / "library").exists()


LAB = ["understudy_lab", "understudy_lab.commands"]
LAB_HELP = {"demo": "options", "experiment": "options", "bench": "bench"}
"""What the help of commands of the laboratory is read from."""


def test_a_command_is_called_without_the_others() -> None:
    program = """
import sys
from understudy.ui.cli import run_command_line

sys.argv = ["understudy", *sys.argv[1:]]
try:
    run_command_line()
except SystemExit:
    print(*(name for name in sys.modules if name.startswith(("understudy.ui.cli.commands.", "understudy_lab"))))
"""
    for arguments, modules in (
        (["--help"], LAB),
        (["show", "--help"], []),
        *(
            ([name, "--help"], [*LAB, f"understudy_lab.commands.{module}"])
            for name, module in LAB_HELP.items()
        ),
        (["list", "--library", "show"], ["understudy.ui.cli.commands.list"]),
        (["learn", "table", "no.csv"], ["understudy.ui.cli.commands.learn_table"]),
        (["replay", "no.mcap"], ["understudy.ui.cli.commands.replay"]),
    ):
        done = subprocess.run([sys.executable, "-c", program, *arguments], capture_output=True, text=True)
        assert done.stdout.splitlines()[-1].split() == modules


PARTED = [entry for entry in BUILTIN if entry.options is not None]


@pytest.mark.parametrize("entry", PARTED, ids=[entry.name for entry in PARTED])
def test_a_command_takes_an_instance_of_its_options(entry: CommandEntry) -> None:
    run, options = resolve_name(str(entry.run)), resolve_name(str(entry.options))
    (parameter,) = signature(run).parameters.values()
    assert parameter.annotation == options.__name__


def test_all_commands_are_listed() -> None:
    names = typer.main.get_command(make_command_line()).commands.keys()  # type: ignore[attr-defined]
    assert {"list", "show", "demo"} <= names


@pytest.mark.parametrize(
    ("arguments", "code"), [((), 2), (("--help",), 0), (("robots",), 2), (("robots", "-h"), 0)]
)
def test_groups_list_their_commands(arguments: tuple[str, ...], code: int) -> None:
    done = run(*arguments)
    assert done.exit_code == code
    assert done.stdout.startswith("Usage: ")
    assert ("  stop " in done.stdout) == ("robots" in arguments)


def test_the_help_fits_on_one_screen() -> None:
    lines = run("--help").stdout.splitlines()
    assert len(lines) <= 30
    assert max(map(len, lines)) <= 80


def test_paragraphs_of_help_are_wrapped_to_the_terminal() -> None:
    plain = re.sub(r"\x1b\[[0-9;]*m", "", run("eval", "--help").output)
    lines = [line.strip() for line in plain.splitlines()]
    begin = next(at for at, line in enumerate(lines) if line.startswith("A world is a success"))
    paragraph = lines[begin : lines.index("", begin)]
    following = [line.split()[0] for line in paragraph[1:]]
    room = [78 - len(line) for line in paragraph[:-1]]
    assert all(len(word) >= free for word, free in zip(following, room, strict=True)), paragraph
