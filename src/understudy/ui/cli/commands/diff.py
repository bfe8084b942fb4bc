"""Command `understudy diff`: show the differences between two versions of an automaton."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.markup import escape
from rich.padding import Padding

from understudy.errors import SettingError
from understudy.learning.change_attribution import ConditionChange, attribute_condition_changes
from understudy.learning.fit import learn
from understudy.model.diff import diff_automata
from understudy.storage.library_folder import list_versions, load_version, make_file_stem, read_document
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.library_data import find_optional_kit
from understudy.ui.cli.library_options import DiffOptions
from understudy.ui.cli.output import make_console

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.model.library import Kit, TrainedAutomaton


SHOWN = 20


def show_diff(options: DiffOptions) -> None:
    """Show what changed between two versions of an automaton, and which examples caused it."""
    before = options.before
    parts = find_optional_kit(options.kit, options.world)
    kept = list_versions(options.library, options.name)
    if before is None:
        if not kept:
            _taught(
                options.library, options.name, None, parts
            )  # an automaton that is not there is the first thing to say
            where, problem = f"automaton {options.name!r} in {options.library}", "has no former version"
            raise SettingError(
                where=where, setting="--from", problem=problem, remedy="name a document to compare with"
            )
        before = str(kept[-1].number)
    former, later = (
        _taught(options.library, options.name, before, parts),
        _taught(options.library, options.name, options.after, parts),
    )
    changes, moved = diff_automata(former, later), attribute_condition_changes(former, later)
    after = options.after or "current"
    if options.as_json:
        print_json({"name": options.name, "from": before, "to": after, "changes": changes, "moved": moved})
        return
    head = f"[bold]{escape(options.name)}[/] from {_called(before)} to {_called(after)}"
    _show(head, changes, moved, most=None if options.everything else SHOWN)


def _taught(library: Path, name: str, which: str | None, kit: Kit | None) -> TrainedAutomaton:
    if which is None:
        return read_document(library / f"{make_file_stem(name)}.json", kit, learn).taught
    if which.isdecimal():
        return load_version(library, name, int(which), kit, learn).taught
    return read_document(Path(which), kit, learn).taught


def _show(
    head: str, changes: Mapping[str, Sequence[str]], moved: Sequence[ConditionChange], *, most: int | None
) -> None:
    """Show changes by topic, and the examples that caused them."""
    out = make_console()
    out.print(head)
    if not changes:
        out.print("nothing changed")
    examples = changes.get("examples", ())
    for group, lines in changes.items():
        if lines is not examples:
            _show_lines(group, lines, out)
    if moved:
        out.print("\n[bold]because of[/]")
    for each in moved:
        out.print(Padding(escape(each.said), (0, 0, 0, 4), expand=False))
    if examples:  # last: in a lesson begun anew they are all others
        _show_lines("examples", examples[:most], out)
    if len(examples) > len(examples[:most]):
        out.print(f"[dim]{len(examples) - len(examples[:most])} more: --all[/]")


def _show_lines(group: str, lines: Sequence[str], out: Console) -> None:
    out.print(f"\n[bold]{group}[/]")
    for line in lines:
        color = {"+": "green", "-": "red"}.get(line[0], "default")
        out.print(Padding(f"[{color}]{escape(line)}[/]", (0, 0, 0, 2), expand=False))


def _called(which: str) -> str:
    return f"version {which}" if which.isdecimal() else which
