"""Command `understudy draw`: draw an automaton as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from msgspec import Struct

from understudy.ui.cli.options import LIBRARY, Json, KitName, LibraryOption, SomeWorld

if TYPE_CHECKING:
    from understudy.model.library import Library


def draw_automata(
    name: Annotated[
        str, typer.Argument(help="Name of the automaton; SORT/NAME for one of a squad or robot type.")
    ],
    out: Annotated[
        Path,
        typer.Option(
            "--out", "-o", metavar="FILE", help="File to write: .svg, .pdf, .png or .dot (Graphviz)."
        ),
    ],
    children: Annotated[
        bool, typer.Option("--children", help="Draw the automata that its states run, too, level by level.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file if it exists.")] = False,
    library: LibraryOption = LIBRARY,
    world: SomeWorld = None,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Draw an automaton: its states as a graph, and in words when it switches between them.

    [dim]understudy draw goto --library demo/library -o goto.svg[/]
    """
    from understudy.errors import FileError
    from understudy.storage.atomic_write import convert_os_errors, write_atomically
    from understudy.ui.cli.library_data import find_listed, open_all_libraries
    from understudy.ui.cli.options import find_optional_kit, find_optional_scenario, import_learner
    from understudy.ui.cli.output import make_console, print_json
    from understudy.viz.automaton_file import check_picture_name, render_automata

    ending = check_picture_name(out, where="--out")
    if out.exists() and not force:
        problem, remedy = "this file exists already", "name another file, or give --force to overwrite it"
        raise FileError(path=out, place="", problem=problem, remedy=remedy)
    where = find_optional_scenario(world)
    listings = open_all_libraries(library, where, find_optional_kit(kit, world), import_learner())
    prefix, name = find_listed(listings, name)
    listing = listings[prefix]
    if name not in listing.opened:
        raise listing.problems[f"{name}.json"]
    names = list_automata_below(listing.library, name) if children else [name]
    data = render_automata([listing.library.taught[each] for each in names], ending)
    with convert_os_errors(out, "writing the picture"):
        write_atomically(out, data)
    if as_json:
        print_json(DrawResult(name=name, file=str(out), automata=names, bytes=len(data)))
    else:
        make_console().print(f"Drawn in {out}", markup=False, soft_wrap=True)


class DrawResult(Struct, frozen=True, kw_only=True):
    """What was drawn: the automata, outermost first, and the file with its size."""

    name: str
    file: str
    automata: Sequence[str]
    bytes: int


def list_automata_below(library: Library, name: str) -> list[str]:
    """List an automaton and all below it that the library has, level by level, each once."""
    found = [name]
    for each in found:  # it grows meanwhile
        runs = dict.fromkeys(state.behavior for state in library.automaton(each).states)
        found += [
            child for child in runs if child in library.taught and child is not None and child not in found
        ]
    return found
