"""`understudy diff`: what changed between two versions of an automaton, in words."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from understudy.ui.cli.options import LIBRARY, Json, KitName, LibraryOption, SomeWorld

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.learning.change_attribution import ConditionChange
    from understudy.model.library import Kit, TrainedAutomaton


SHOWN = 20


def show_diff(
    name: Annotated[str, typer.Argument(help="The automaton.")],
    before: Annotated[
        str | None, typer.Option("--from", metavar="VERSION|FILE", help="By default the last former version.")
    ] = None,
    after: Annotated[
        str | None, typer.Option("--to", metavar="VERSION|FILE", help="By default the current version.")
    ] = None,
    library: LibraryOption = LIBRARY,
    world: SomeWorld = None,
    kit: KitName = None,
    everything: Annotated[bool, typer.Option("--all", help="All examples that changed.")] = False,
    as_json: Json = False,
) -> None:
    """Say what changed between two versions of an automaton, and which examples are behind it.

    [dim]understudy diff goto --from 1 --to 3 --library demo/library[/]
    """
    from understudy.errors import SettingError
    from understudy.learning.change_attribution import attribute_condition_changes
    from understudy.model.diff import diff_automata
    from understudy.storage.library_folder import list_versions
    from understudy.ui.cli.options import find_optional_kit
    from understudy.ui.cli.output import print_json

    parts = find_optional_kit(kit, world)
    kept = list_versions(library, name)
    if before is None:
        if not kept:
            _taught(library, name, None, parts)  # an automaton that is not there is the first thing to say
            where, problem = f"automaton {name!r} in {library}", "has no former version"
            raise SettingError(
                where=where, setting="--from", problem=problem, remedy="name a document to compare with"
            )
        before = str(kept[-1].number)
    told: dict[str, Any] = {"name": name, "from": before, "to": after or "current"}
    former, later = _taught(library, name, before, parts), _taught(library, name, after, parts)
    told["changes"] = diff_automata(former, later)
    told["moved"] = [_moved(each) for each in attribute_condition_changes(former, later)]
    if as_json:
        print_json(told)
    else:
        _show(told, most=None if everything else SHOWN)


def _taught(library: Path, name: str, which: str | None, kit: Kit | None) -> TrainedAutomaton:
    from understudy.storage.library_folder import load_version, make_file_stem, read_document
    from understudy.ui.cli.options import import_learner

    if which is None:
        return read_document(library / f"{make_file_stem(name)}.json", kit, import_learner()).taught
    if which.isdecimal():
        return load_version(library, name, int(which), kit, import_learner()).taught
    return read_document(Path(which), kit, import_learner()).taught


def _show(told: dict[str, Any], *, most: int | None) -> None:
    from rich.markup import escape
    from rich.padding import Padding

    from understudy.ui.cli.output import make_console

    out = make_console()
    out.print(f"[bold]{escape(told['name'])}[/] from {_called(told['from'])} to {_called(told['to'])}")
    if not told["changes"]:
        out.print("nothing changed")
    examples = told["changes"].get("examples", [])
    for group, lines in told["changes"].items():
        if lines is not examples:
            _show_lines(group, lines, out)
    if told["moved"]:
        out.print("\n[bold]because of[/]")
    for each in told["moved"]:
        out.print(Padding(escape(each["said"]), (0, 0, 0, 4), expand=False))
    if examples:  # last: in a lesson begun anew they are all others
        _show_lines("examples", examples[:most], out)
    if len(examples) > len(examples[:most]):
        out.print(f"[dim]{len(examples) - len(examples[:most])} more: --all[/]")


def _show_lines(group: str, lines: list[str], out: Console) -> None:
    from rich.markup import escape
    from rich.padding import Padding

    out.print(f"\n[bold]{group}[/]")
    for line in lines:
        color = {"+": "green", "-": "red"}.get(line[0], "default")
        out.print(Padding(f"[{color}]{escape(line)}[/]", (0, 0, 0, 2), expand=False))


def _moved(each: ConditionChange) -> dict[str, Any]:
    return {
        "state": each.state,
        "next": each.next,
        "what": each.what,
        "gone": each.gone,
        "new": each.new,
        "said": str(each),
        "examples": each.examples,
    }


def _called(which: str) -> str:
    return f"version {which}" if which.isdecimal() else which
