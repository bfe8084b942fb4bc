"""Command `understudy list`: list the automata of a library."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import typer
from rich.markup import escape

from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.library_data import open_listings, summarize_automaton
from understudy.ui.cli.library_options import ListOptions
from understudy.ui.cli.near_libraries import describe_near_libraries
from understudy.ui.cli.output import format_count, format_saved_time, make_console, make_table, print_table

HEADS = ("automaton", "#states", "#shown", "#watched", "runs", "#former", "saved")


def list_automata(options: ListOptions) -> None:
    """List the automata of a library; those of squads and robot types are named SORT/NAME."""
    listings = open_listings(options, lambda _: {})  # it needs no trees
    rows = [
        summarize_automaton(listing.folder, listing.library, opened) | {"name": f"{prefix}{name}"}
        for prefix, listing in listings.items()
        for name, opened in listing.opened.items()
    ]
    problems = {
        f"{prefix}{name}": str(error)
        for prefix, listing in listings.items()
        for name, error in listing.problems.items()
    }
    left_out = {reason for listing in listings.values() for reason in listing.library.left_out.values()}
    damaged = [problem for problem in problems.values() if problem not in left_out]
    if options.as_json:
        print_json({"library": str(options.library), "automata": rows, "problems": problems})
    else:
        columns = list(zip(HEADS, *map(_format_row, rows), strict=True))
        made = make_table(*(head for head, *cells in columns if any(cells)))
        for row in zip(*(cells for _, *cells in columns if any(cells)), strict=True):
            made.add_row(*row)
        out = make_console()
        out.print(
            f"[bold]{escape(str(options.library))}[/]: {format_count(len(rows), 'automaton', 'automata')}",
            soft_wrap=True,
        )
        if rows:
            print_table(out, made)
        for note in [] if rows or problems else describe_near_libraries(options.library, "understudy list"):
            out.print(note, markup=False, soft_wrap=True)
        for problem in damaged:
            make_console(err=True).print(f"[red]Cannot be opened:[/] {escape(problem)}", soft_wrap=True)
    raise typer.Exit(2 if damaged else 0)


def _format_row(row: Mapping[str, Any]) -> tuple[str, ...]:
    """Format what is known of an automaton as the cells of the table."""
    parameters = f"({', '.join(row['parameters'])})" if row["parameters"] else ""
    numbers = (str(row[name] or "") for name in ("states", "examples", "watched"))
    uses, versions = escape(", ".join(row["uses"])), str(row["versions"] or "")
    return escape(row["name"] + parameters), *numbers, uses, versions, format_saved_time(row["saved"])
