"""The library of a command, which every command takes as an argument and as an option."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import Any

from typer.core import TyperCommand

from understudy.errors import SettingError, UnderstudyError
from understudy.storage.library_folder import count_automata
from understudy.ui.cli.loading import import_on_call
from understudy.ui.cli.near_libraries import describe_near_libraries
from understudy.ui.cli.options import LIBRARY

OPTION = "--library"
list_scenarios = import_on_call("understudy.sim.catalog:list_scenarios")


class LibraryCommand(TyperCommand):
    """Command whose option `--library` can be given as an argument, too, before or after its others."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments; one of them that names a library is taken as the option."""
        if ctx.resilient_parsing or any(each in ctx.help_option_names for each in args):
            return super().parse_args(ctx, args)
        tokens: list[str] = [_Token(each) for each in args]
        options = [each for each in self.params if each.param_type_name == "option"]
        parser = TyperCommand(self.name, params=options).make_parser(ctx)
        values, positional, _ = parser.parse_args(list(tokens))
        given = next(
            (values[each.name] for each in options if OPTION in each.opts and each.name in values), None
        )
        place = self._find_library(positional, LIBRARY if given is None else Path(given))
        if place is not None:
            library = positional[place]
            if given is not None and Path(given) != Path(library):
                raise SettingError(
                    where=OPTION,
                    setting=repr(given),
                    problem=f"is another library than {str(library)!r}, which is given as an argument",
                    remedy="name one of them",
                )
            tokens = [f"{OPTION}={library}", *(each for each in tokens if each is not library)]
        return super().parse_args(ctx, tokens)

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Collect the parts of the usage line, with the library as the first argument."""
        options, *arguments = super().collect_usage_pieces(ctx)
        return [options, "[LIBRARY]", *arguments]

    def invoke(self, ctx: Any) -> Any:
        """Run the command; where the library is not there, an error also says which ones lie near."""
        try:
            return super().invoke(ctx)
        except UnderstudyError as error:
            library = ctx.params.get("library")
            about = library is not None and re.match(
                rf"(.* folder )?{re.escape(str(library))}[: ]", str(error)
            )
            if about and not Path(library).exists():
                command = " ".join(["understudy", *ctx.command_path.split()[1:]])
                for note in describe_near_libraries(library, command):
                    error.add_note(note)
            raise

    def _find_library(self, positional: Sequence[str], folder: Path) -> int | None:
        """Return which of the arguments names the library, or None; `folder` is the library if none does.

        A folder with automata does, or any folder where no argument names files; but not the only one that can be an
        argument which is required, nor a name of a scenario or of an automaton. Without such a folder, a surplus
        argument does.
        """
        arguments: list[Any] = [each for each in self.params if each.param_type_name == "argument"]
        least = sum(each.required for each in arguments)
        most = inf if any(each.nargs < 0 for each in arguments) else len(arguments)
        takes_files = any("Path" in str(each.type_descriptor.annotation) for each in arguments)
        if len(positional) <= least:
            return None
        folders = [
            place
            for place, each in enumerate(positional)
            if Path(each).is_dir() and not self._is_name(each, folder)
        ]
        filled = [place for place in folders if _holds_automata(Path(positional[place]))]
        if filled or (folders and not takes_files):
            return (filled or folders)[0]
        surplus = len(positional) > most or (most == inf and not takes_files and not folder.exists())
        return next(
            (place for place, each in enumerate(positional) if surplus and not Path(each).is_file()), None
        )

    def _is_name(self, word: str, folder: Path) -> bool:
        """Return whether a word is the name of a scenario, or of an automaton of a folder, that may be an argument."""
        if os.sep in word or "/" in word:
            return False
        names = {each.name for each in self.params if each.param_type_name == "argument"}
        if "scenario" in names and word in list_scenarios():
            return True
        return bool(names & {"name", "names", "behavior"}) and (folder / f"{word}.json").is_file()


class _Token(str):
    """Argument that is an object of its own, so that it can be told from an equal one."""

    __slots__ = ()


def _holds_automata(folder: Path) -> bool:
    """Return whether a folder has automata, or those of its squads and robot types."""
    return any(map(count_automata, [folder, *(each for each in folder.iterdir() if each.is_dir())]))
