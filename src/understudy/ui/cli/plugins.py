"""Registry of commands: built-in ones, and those that other packages add by entry points."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import Any

import typer

from understudy.entry_points import COMMANDS, list_entry_points, load_instance
from understudy.errors import UnderstudyError

REMEDY = "let the entry point name a CommandEntry of understudy.spi"

TEACHING, RUNNING, LIBRARY, MEASURING = "Teach", "Run", "Look into a library", "Measure"
PANELS = (TEACHING, RUNNING, LIBRARY, MEASURING)
"""Headings of `understudy --help`, in order."""


@dataclass(frozen=True)
class CommandEntry:
    """Command or group of commands, with the heading under which the help lists it.

    `run` is a function, a group, or the place of one, written `package.module:name`, which is imported when needed.
    """

    name: str
    run: Callable[..., Any] | typer.Typer | str
    panel: str

    def add_to(self, app: typer.Typer) -> None:
        """Add this command to a command line.

        Parameters
        ----------
        app
            The command line.
        """
        run = resolve_name(self.run) if isinstance(self.run, str) else self.run
        if isinstance(run, typer.Typer):
            app.add_typer(run, name=self.name, rich_help_panel=self.panel)
        else:
            app.command(self.name, rich_help_panel=self.panel)(run)


def load_plugins() -> list[CommandEntry]:
    """Load the commands of installed packages; report one that fails on stderr, and skip it."""
    found = []
    for name in list_entry_points(COMMANDS):
        try:
            found.append(load_instance(name, COMMANDS, CommandEntry, where="command", remedy=REMEDY))
        except UnderstudyError as error:
            print(error, file=sys.stderr)
    return found


def order_commands(
    builtin: Sequence[CommandEntry], plugins: Sequence[CommandEntry]
) -> Iterator[CommandEntry]:
    """Order commands by heading; under one heading, those of other packages come first."""
    for panel in PANELS:
        yield from (command for command in (*plugins, *builtin) if command.panel == panel)
