"""The reference of the command line, made from the commands themselves.

After a command changed, bring the page up to date with: python -m tests.docs.command_line
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from textwrap import fill
from typing import Any

import typer
from tests.docs.pages import ROOT

from understudy.ui.cli.library_argument import LibraryCommand
from understudy.ui.cli.main import make_command_line

PAGE = ROOT / "docs" / "reference" / "command-line.md"
HEAD = """\
# Command line

<!-- made by: python -m tests.docs.command_line -->

Every command takes `--help`, and those that print results take `--json`, which prints one JSON object. Exit codes:
0 fine; 1 the result is bad news, such as a test that fails; 2 something that was given cannot be used, and nothing was
changed; 70 a fault in Understudy itself.

The library of a command, which is the folder `library` by default, is named by an argument or by `--library`, as you
like: `understudy show demo/library goto` and `understudy show goto --library demo/library` are the same.

`python -m understudy` is the same as `understudy`, where no command of that name is found.

## Completion by the shell

`understudy --install-completion` lets the shell in which it is typed (bash, zsh or fish) complete commands, options and
their values by the tab key, from the next shell on. To see what it would add, or to put it into a file of your own:

| shell | what prints the lines to add |
|---|---|
| bash | `_UNDERSTUDY_COMPLETE=source_bash understudy` |
| zsh | `_UNDERSTUDY_COMPLETE=source_zsh understudy` |
| fish | `_UNDERSTUDY_COMPLETE=source_fish understudy` |

## Names

Names are printed as they are typed and as files have them, such as `rotate_left` and `distance_to(A)`. The studio and
the terminal trainer say *turn left* and *distance to A*.
"""
_MARKUP = re.compile(r"\[/?[a-z ]*\]")
VALUES = {str: "TEXT", int: "INTEGER", float: "NUMBER", Path: "PATH"}
_EXAMPLE = re.compile(r"\[dim\](understudy .*?)\[/\]", re.DOTALL)


def make_page() -> str:
    """Return the whole page."""
    root: Any = typer.main.get_command(make_command_line())
    return "\n".join([HEAD, *_describe("understudy", root)]).rstrip() + "\n"


def _describe(name: str, command: Any) -> Iterator[str]:
    children = getattr(command, "commands", None)
    if name != "understudy":
        yield f"{'##' if name.count(' ') == 1 else '###'} {name}\n"
        yield from _explain(name, command)
    if children:
        for child in sorted(children):
            yield from _describe(f"{name} {child}", children[child])


def _explain(name: str, command: Any) -> Iterator[str]:
    text = command.help or ""
    for paragraph in _MARKUP.sub("", _EXAMPLE.sub("", text)).split("\n\n"):
        if words := " ".join(paragraph.split()):
            yield fill(words, 118) + "\n"
    parameters = [
        each for each in command.params if each.name != "help" and not getattr(each, "hidden", False)
    ]
    arguments = [each for each in parameters if each.param_type_name == "argument"]
    options = [each for each in parameters if each.param_type_name == "option"]
    usage = [*(["[LIBRARY]"] if isinstance(command, LibraryCommand) else []), *map(_spell, arguments)]
    yield f"```text\n{' '.join([name, *usage, *(['[OPTIONS]'] if options else [])])}\n```\n"
    if examples := _EXAMPLE.findall(text):
        yield "For example:\n"
        yield "```sh\n" + "\n".join(" ".join(each.split()) for each in examples) + "\n```\n"
    if parameters:
        yield "| argument or option | meaning |\n|---|---|"
        for each in arguments:
            yield f"| `{_spell(each)}` | {_tell(each)} |"
        for each in options:
            yield f"| {_list_names(each)} | {_tell(each)} |"
        yield ""


def _spell(argument: Any) -> str:
    given = (argument.metavar or argument.name.upper()).removesuffix("...").strip("[]")
    return (given if argument.required else f"[{given}]") + ("..." if argument.nargs == -1 else "")


def _list_names(option: Any) -> str:
    names = [*option.opts, *option.secondary_opts]
    if option.is_flag:
        return ", ".join(f"`{each}`" for each in names)
    value = (option.metavar or VALUES.get(option.type_descriptor.annotation, "VALUE")).replace("|", "\\|")
    return ", ".join(f"`{each} {value}`" if each.startswith("--") else f"`{each}`" for each in names)


def _tell(parameter: Any) -> str:
    text = " ".join(_MARKUP.sub("", getattr(parameter, "help", "") or "").split()).replace("|", "\\|")
    default = parameter.default
    if isinstance(default, (str, int, float, Path)) and not isinstance(default, bool):
        return f"{text} Default: `{default}`.".strip()
    return text


if __name__ == "__main__":
    PAGE.write_text(make_page(), encoding="utf-8")
