"""Groups of commands, each of which is imported when it is called, and their help."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, fields
from functools import cached_property
from inspect import Parameter, Signature, getdoc
from pkgutil import resolve_name
from typing import Any, get_type_hints

import typer
from typer.core import TyperCommand, TyperGroup

from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.library_argument import LibraryCommand
from understudy.ui.cli.loading import import_on_call
from understudy.ui.cli.old_spellings import OLD_SPELLINGS
from understudy.ui.cli.options import Json
from understudy.ui.cli.plugins import HEADINGS, CommandEntry, load_plugins


class CommandTable:
    """All commands: built-in ones, and those of other packages, which are loaded when they are needed."""

    def __init__(self, builtin: Sequence[CommandEntry]) -> None:
        self._builtin = {entry.name: entry for entry in builtin}

    @cached_property
    def entries(self) -> Mapping[str, CommandEntry]:
        """Entries of all commands by name, those of other packages first."""
        added = {entry.name: entry for entry in load_plugins() if entry.name not in self._builtin}
        return {**added, **self._builtin}

    def find(self, name: str) -> CommandEntry | None:
        """Return the entry of a command, or None; other packages are loaded only if no built-in one has the name."""
        return self._builtin.get(name) or self.entries.get(name)

    def list_group(self, group: str) -> list[CommandEntry]:
        """List the entries of the commands of a group, those of the command line itself for ''."""
        return [entry for entry in self.entries.values() if entry.name.rpartition(" ")[0] == group]

    def load(self, entry: CommandEntry) -> Any:
        """Import a command."""
        word = entry.name.rpartition(" ")[2]
        if entry.run is None:
            return CommandGroup(entry.name, self, name=word, help=f"{entry.summary}.")
        is_split = entry.options is not None
        run = take_options(_resolve(entry.options), entry.run) if is_split else _resolve(entry.run)
        app = typer.Typer(add_completion=False, rich_markup_mode="rich")
        if isinstance(run, typer.Typer):
            app.add_typer(run, name=word)
        else:
            has_library = is_split and any(each.name == "library" for each in fields(_resolve(entry.options)))
            kind = LibraryCommand if has_library else TyperCommand
            app.command(word, cls=kind, help=_join_lines(getdoc(run) or ""))(run)
        return typer.main.get_group(app).commands[word]

    def describe(self, entry: CommandEntry) -> str:
        """Describe a command in a line."""
        return entry.summary or self.load(entry).get_short_help_str(60).removesuffix(".")


def take_options(options: type, run: Callable[..., Any] | str) -> Callable[..., None]:
    """Make a function whose parameters are the fields of a class, and which calls another with an instance of it.

    The fields of a class come before those of the classes that it is derived from.
    """
    hints = get_type_hints(options, include_extras=True)
    defaults = {
        each.name: Parameter.empty if each.default is MISSING else each.default for each in fields(options)
    }
    names = dict.fromkeys(name for each in options.__mro__ for name in vars(each).get("__annotations__", ()))
    parameters = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=defaults[name], annotation=hints[name])
        for name in names
    ]

    called = import_on_call(run) if isinstance(run, str) else run

    def call(**given: Any) -> None:
        called(options(**given))

    call.__doc__, call.__annotations__ = options.__doc__, hints
    vars(call)["__signature__"] = Signature(parameters)
    return call


def _join_lines(text: str) -> str:
    """Join the lines of each paragraph, which are as long in the source as no terminal need be wide."""
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in text.split("\n\n"))


def _resolve(place: Any) -> Any:
    return resolve_name(place) if isinstance(place, str) else place


class GroupCommands(Mapping[str, Any]):
    """Commands of a group by their last word, each imported when it is looked up."""

    def __init__(self, group: str, table: CommandTable) -> None:
        self._group, self._table = group, table

    def __iter__(self) -> Iterator[str]:
        return (entry.name.rpartition(" ")[2] for entry in self._table.list_group(self._group))

    def __len__(self) -> int:
        return len(self._table.list_group(self._group))

    def __contains__(self, word: object) -> bool:
        return bool(word) and self._find(word) is not None

    def __getitem__(self, word: str) -> Any:
        entry = self._find(word)
        if entry is None:
            raise KeyError(word)
        return self._table.load(entry)

    def _find(self, word: object) -> CommandEntry | None:
        return self._table.find(f"{self._group} {word}".strip())


class CommandGroup(TyperGroup):
    """Group of commands that imports only the one that is called, and lists the others by their entries."""

    def __init__(self, path: str, table: CommandTable, **attributes: Any) -> None:
        super().__init__(**attributes)
        self.path, self.table = path, table
        self.commands = GroupCommands(path, table)  # type: ignore[assignment]

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments; without any, print the help and end with exit code 2."""
        if not args and not ctx.resilient_parsing:  # a shell that completes a word wants no help
            typer.echo(ctx.get_help())
            ctx.exit(2)
        return super().parse_args(ctx, args)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find the command that the arguments name, in an old spelling if they have it."""
        old = OLD_SPELLINGS.get(f"{self.path} {args[0]}".strip())
        if old is not None:
            command = self.get_command(ctx, args[0])
            if command is None or old.applies(args[1:], getattr(command, "commands", None)):
                return (
                    old.name or args[0],
                    self.table.load(CommandEntry(args[0], old.run, "", options=old.options)),
                    args[1:],
                )
        return super().resolve_command(ctx, args)

    def list_commands(self, ctx: Any) -> list[str]:
        """List the names of the commands."""
        return list(self.commands)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help: a line for each command, those of the command line itself under headings."""
        entries = self.table.list_group(self.path)
        rows = [("", entry) for entry in entries]
        if not self.path:
            rows = [(heading, entry) for heading in HEADINGS for entry in entries if entry.panel == heading]
        usage = f"Usage: {ctx.command_path} COMMAND [ARGUMENTS] [OPTIONS]"
        lines = [usage, "", self.help or "", "", *self.format_rows(rows)]
        formatter.write("\n".join([*lines, *(["", self.epilog] if self.epilog else []), ""]))

    def format_rows(self, rows: Sequence[tuple[str, CommandEntry]]) -> list[str]:
        """Format commands and their descriptions as columns; a heading is written once, before its first command."""
        words = [entry.name.rpartition(" ")[2] for _, entry in rows]
        width, margin = max(map(len, words), default=0), max((len(heading) for heading, _ in rows), default=0)
        lines, before = [], ""
        for word, (heading, entry) in zip(words, rows, strict=True):
            shown = typer.style(f"{heading if heading != before else '':{margin}}", bold=True)
            name = typer.style(f"{word:{width}}", fg="cyan")
            lines.append(f"{shown}  {name}  {self.table.describe(entry)}")
            before = heading
        return lines


def show_rare_commands(context: typer.Context, as_json: Json = False) -> None:
    """List the commands that are rarely needed, and those that other packages add under headings of their own."""
    line: Any = context.find_root().command
    rare = [entry for entry in line.table.list_group("") if entry.panel not in HEADINGS]
    if as_json:
        print_json({"commands": {entry.name: line.table.describe(entry) for entry in rare}})
    else:
        typer.echo("\n".join(line.format_rows([("", entry) for entry in rare])))
