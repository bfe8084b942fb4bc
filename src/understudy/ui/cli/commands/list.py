"""Command `understudy list`: list the automata of a library."""

from __future__ import annotations

import typer
from rich.markup import escape

from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.library_data import open_listings, summarize_automaton
from understudy.ui.cli.library_options import ListOptions
from understudy.ui.cli.near_libraries import describe_near_libraries
from understudy.ui.cli.output import format_count, format_saved_time, make_console, make_table


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
    if options.as_json:
        print_json({"library": str(options.library), "automata": rows, "problems": problems})
    else:
        made = make_table("automaton", "#states", "#shown", "#watched", "runs", "#former", "saved")
        made.columns[4].no_wrap = False
        for row in rows:
            parameters = f"({', '.join(row['parameters'])})" if row["parameters"] else ""
            numbers = [str(row[name] or "") for name in ("states", "examples", "watched")]
            uses, versions = escape(", ".join(row["uses"])), str(row["versions"] or "")
            saved = format_saved_time(row["saved"])
            made.add_row(escape(row["name"] + parameters), *numbers, uses, versions, saved)
        out = make_console()
        out.print(
            f"[bold]{escape(str(options.library))}[/]: {format_count(len(rows), 'automaton', 'automata')}",
            soft_wrap=True,
        )
        if rows:
            out.print(made)
        for note in [] if rows or problems else describe_near_libraries(options.library, "understudy list"):
            out.print(note, markup=False, soft_wrap=True)
        for problem in problems.values():
            make_console(err=True).print(f"[red]Cannot be opened:[/] {escape(problem)}", soft_wrap=True)
    raise typer.Exit(2 if problems else 0)
