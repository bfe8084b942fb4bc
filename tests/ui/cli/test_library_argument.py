"""The library of a command: an argument or an option, in all commands alike."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from tests.ui.cli.commands import run

from understudy.errors import UnderstudyError
from understudy.ui.cli.library_argument import LibraryCommand
from understudy.ui.cli.main import make_command_line

REQUIRED = {"to": "python", "out": "out.svg"}
"""Options that some commands require."""


def list_commands(group: Any = None, path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield all commands with their names."""
    group = group or typer.main.get_command(make_command_line())
    for word in group.commands:
        command, name = group.commands[word], f"{path} {word}".strip()
        if hasattr(command, "commands"):
            yield from list_commands(command, name)
        else:
            yield name, command


COMMANDS = {name: command for name, command in list_commands() if isinstance(command, LibraryCommand)}


def fill(command: Any, file: Path) -> list[str]:
    """Return values of the arguments and options that a command requires."""
    filled = []
    for each in command.params:
        if each.param_type_name == "argument" and each.required:
            filled.append(str(file) if "Path" in str(each.type_descriptor.annotation) else "goto")
        elif each.required:
            filled += [each.opts[0], REQUIRED.get(each.name, "scout")]
    return filled


def parse(command: Any, arguments: list[str]) -> dict[str, Any]:
    params: dict[str, Any] = command.make_context("command", list(arguments)).params
    return params


def test_every_option_of_a_library_is_of_such_a_command() -> None:
    others = [
        name
        for name, command in list_commands()
        if name not in COMMANDS and any("--library" in each.opts for each in command.params)
    ]
    assert others == []
    assert {
        "list",
        "show",
        "run",
        "eval",
        "check",
        "test",
        "falsify",
        "team push",
        "learn table",
    } < COMMANDS.keys()


@pytest.mark.parametrize("name", COMMANDS)
def test_the_library_is_an_argument_or_an_option(name: str, library: Path, tmp_path: Path) -> None:
    command, file = COMMANDS[name], tmp_path / "rover.toml"
    file.touch()
    others = fill(command, file)
    expected = parse(command, [*others, "--library", str(library)])
    assert expected["library"] == library
    for arguments in (
        [str(library), *others],
        [*others, str(library)],
        [*others, "-l", str(library)],
        [str(library), *others, f"--library={library}"],
    ):
        assert parse(command, arguments) == expected, arguments
    with pytest.raises(UnderstudyError, match=r"--library: .* is another library than"):
        parse(command, [str(library), *others, "--library", "another"])
    assert "[LIBRARY]" in run(*name.split(), "--help").output


# folders here (with automata or empty), command, arguments, library, other arguments
ARGUMENTS = [
    (["mine"], [], "list", "mine", "mine", {}),
    ([], [], "list", "nowhere", "nowhere", {}),
    (["goto"], [], "show", "goto", "library", {"name": "goto"}),  # the only argument is the one that is required
    (["goto"], [], "show", "goto goto", "goto", {"name": "goto"}),
    ([], [], "show", "nowhere goto", "nowhere", {"name": "goto"}),
    (["mine"], ["goto"], "show", "goto mine", "mine", {"name": "goto"}),  # an empty folder is none
    (["forage", "mine"], [], "run", "forage", "library", {"scenario": "forage"}),  # a scenario's name
    (["forage", "mine"], [], "run", "forage mine", "mine", {"scenario": "forage"}),
    (["forage"], [], "run", "./forage", "forage", {"scenario": None}),
    ([], ["new"], "studio", "new", "new", {"scenario": None}),
    (["library", "goto"], [], "validate", "goto", "library", {"names": ["goto"]}),  # an automaton's name
    (["mine"], [], "check", "mine goto harvest", "mine", {"names": ["goto", "harvest"]}),
    (["mine"], [], "check", "goto --library mine", "mine", {"names": ["goto"]}),
    ([], [], "check", "nowhere", "nowhere", {"names": ()}),
    (["library"], [], "check", "nowhere", "library", {"names": ["nowhere"]}),
    ([], ["bag"], "learn drive", "bag", None, {}),  # a recording is a folder, too
    (["mine"], ["bag"], "learn drive", "bag bag mine --name x", "mine", {"name": "x"}),
    ([], [], "learn table", "lesson.csv new --name x", "new", {"name": "x"}),
    (["mine"], [], "eval", "--against mine", "library", {"against": Path("mine")}),
    (["mine"], [], "eval", "--against mine mine", "mine", {"against": Path("mine")}),
]  # fmt: skip


@pytest.mark.parametrize(("filled", "empty", "name", "words", "expected", "others"), ARGUMENTS)
def test_which_argument_is_the_library(
    filled: list[str],
    empty: list[str],
    name: str,
    words: str,
    expected: str | None,
    others: dict[str, object],
    library: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    place = tmp_path / "here"
    for folder in (*filled, *empty):
        (place / folder).mkdir(parents=True)
    for folder in filled:
        for document in library.glob("*.json"):
            (place / folder / document.name).write_bytes(document.read_bytes())
    place.mkdir(exist_ok=True)
    (place / "lesson.csv").touch()
    monkeypatch.chdir(place)
    params = parse(COMMANDS[name], words.split())
    assert params["library"] == (None if expected is None else Path(expected))
    assert {key: params[key] for key in others} == others
