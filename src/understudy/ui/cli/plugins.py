"""Entries of the table of commands: built-in ones, and those that other packages add by entry points."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import typer

from understudy.entry_points import COMMANDS, list_entry_points, load_instance
from understudy.errors import UnderstudyError

REMEDY = "let the entry point name a CommandEntry of understudy.spi"

TEACH, RUN, LOOK, CHECK, SHARE, ROBOTS = HEADINGS = ("Teach", "Run", "Look", "Check", "Share", "Robots")
"""Headings of `understudy --help`, in order."""

RARE = "Rarely needed"
"""Heading of commands that only `understudy more` lists, as it does those under a heading of their own."""


@dataclass(frozen=True)
class CommandEntry:
    """Command, where it is, and how the help lists it.

    Parameters
    ----------
    name
        The words after `understudy`: `teach`, or `robots stop` for a command of the group `robots`.
    run
        The function, or a typer application, or the place of one, written `package.module:name`. A place is imported
        when the command is called, so that its module can import at its top what the command needs. None: a group, of
        the commands whose names begin with this one.
    panel
        The heading of the help under which it is listed.
    summary
        A line for the help, of 60 characters at most. By default the first sentence of the docstring, for which the
        command is imported.
    options
        The class of its options, or its place: a dataclass whose fields are annotated as parameters are for typer, and
        whose docstring is the help. The function takes an instance of it, and is only imported when the command is
        called, not for its help. None: the function has the options as parameters.
    """

    name: str
    run: Callable[..., Any] | typer.Typer | str | None
    panel: str
    summary: str = ""
    options: type | str | None = None


def load_plugins() -> list[CommandEntry]:
    """Load the commands of installed packages; report one that fails on stderr, and skip it."""
    found = []
    for name in list_entry_points(COMMANDS):
        try:
            found.append(load_instance(name, COMMANDS, CommandEntry, where="command", remedy=REMEDY))
        except UnderstudyError as error:
            print(error, file=sys.stderr)
    return found
