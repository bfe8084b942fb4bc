"""Old spellings of commands, which keep working until 1.0: no help lists them."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, TypeAlias

import typer

from understudy.errors import SettingError
from understudy.ui.cli.options import CommandOptions

CLI = "understudy.ui.cli"
COMMANDS, HERE = f"{CLI}.commands", f"{CLI}.old_spellings"
HELP = ("--help", "-h")
AUTOMATON = "automaton"
DATA_TARGETS = (None, "lerobot", "minari")
SPELLINGS = {"mapping": "--map", "scenario": "SCENARIO"}


@dataclass(frozen=True, slots=True)
class OldSpelling:
    """A command as it was before it was renamed, or parted into several.

    It is a function `run` and the class of its options; of several commands, it takes the options of all of them, and
    refuses those that exclude each other. It is called if there is no command of its name any more; in place of a group
    of commands if the first argument is none of them; in place of a command if one of `words` is among the arguments,
    of which `:` stands for the name of a function, MODULE:NAME.
    """

    run: str
    options: str
    words: str = ""
    name: str = ""
    """What the usage calls it, if that is another name."""

    def applies(self, arguments: Sequence[str], commands: Container[str] | None) -> bool:
        """Return whether arguments are of the old spelling; `commands` are those of the group, if it is one now."""
        if commands is not None:
            return bool(arguments) and arguments[0] not in HELP and arguments[0] not in commands
        return any(self._names(argument) for argument in arguments)

    def _names(self, argument: str) -> bool:
        name = argument.partition("=")[0] if argument.startswith("--") else argument[:2]
        words = self.words.split()
        return name in words or (":" in words and ":" in argument)


@dataclass(frozen=True, slots=True)
class ExportSpelling(OldSpelling):
    """`export NAME --to TARGET` for `export automaton NAME ...`, where NAME may be that of a command."""

    def applies(self, arguments: Sequence[str], commands: Container[str] | None) -> bool:
        """Return whether the command is left out, which the option `--to` tells where an automaton has its name."""
        if not arguments or arguments[0] in HELP:
            return False
        word, after = arguments[0], arguments[1:2]
        has_argument = bool(after) and not after[0].startswith("-")
        if word == AUTOMATON:
            return not (has_argument or not after or after[0] in HELP)
        if word != "data" and (commands is None or word not in commands):
            return True
        return not has_argument and _find_target(arguments) not in DATA_TARGETS


def _find_target(arguments: Sequence[str]) -> str | None:
    """Return the value of `--to`, or None if the option is missing."""
    for place, each in enumerate(arguments):
        name, _, value = each.partition("=")
        if name == "--to":
            return value or "".join(arguments[place + 1 : place + 2])
    return None


RobotFileOption: TypeAlias = Annotated[Path | None, typer.Option("--robot", metavar="FILE")]
TeamFileOption: TypeAlias = Annotated[Path | None, typer.Option("--team", metavar="FILE")]
RecordingOption: TypeAlias = Annotated[list[Path] | None, typer.Option("--recording", metavar="FILE")]


class OldOptions(CommandOptions):
    """Options of an old spelling that refuses some of them."""

    context: typer.Context

    def is_given(self, option: str) -> bool:
        """Return whether an option was given on the command line."""
        source = self.context.get_parameter_source(option)
        return source is not None and source.name == "COMMANDLINE"

    def refuse_given(self, options: Iterable[str], *, where: str, problem: str, remedy: str) -> None:
        """Refuse the first of some options that was given on the command line."""
        for option in filter(self.is_given, options):
            spelled = SPELLINGS.get(option, f"--{option.replace('_', '-')}")
            raise SettingError(where=where, setting=spelled, problem=problem, remedy=remedy)


OLD_SPELLINGS: Mapping[str, OldSpelling] = MappingProxyType(
    {
        "learn": OldSpelling(f"{HERE}.old_teaching:old_learn", f"{HERE}.old_teaching:OldLearnOptions"),
        "agent": OldSpelling(f"{COMMANDS}.team:run_agent", f"{CLI}.robots_options:AgentOptions"),
        "export": ExportSpelling(
            f"{COMMANDS}.export:export_behavior",
            f"{CLI}.export_options:ExportOptions",
            name="export automaton",
        ),
        "export data": OldSpelling(
            f"{HERE}.old_running:old_export_data", f"{HERE}.old_running:OldExportDataOptions"
        ),
        "falsify": OldSpelling(
            f"{HERE}.old_running:old_falsify", f"{HERE}.old_running:OldFalsifyOptions", words="--goal :"
        ),
        "run": OldSpelling(
            f"{HERE}.old_running:old_run",
            f"{HERE}.old_running:OldRunOptions",
            words="--robot --team --no-record --replay",
        ),
        "studio": OldSpelling(
            f"{HERE}.old_teaching:old_studio",
            f"{HERE}.old_teaching:OldStudioOptions",
            words="--robot --team --no-record --recording --drive --driver --trust --map --name -n --behaviors "
            "--features --targets --agent -a",
        ),
        "teach": OldSpelling(
            f"{HERE}.old_teaching:old_teach",
            f"{HERE}.old_teaching:OldTeachOptions",
            words="--robot --no-record",
        ),
        "why": OldSpelling(
            f"{COMMANDS}.export:explain_exported",
            f"{CLI}.export_options:ExportWhyOptions",
            words="--exported",
        ),
    }
)
