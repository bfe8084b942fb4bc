"""`understudy list` and `understudy rebuild`: a library as a whole."""

from __future__ import annotations

import typer

from understudy.ui.cli.options import (
    LIBRARY,
    WORLD,
    AutomatonNames,
    Json,
    KitName,
    LibraryOption,
    SomeWorld,
    WorldOption,
)


def list_automata(
    library: LibraryOption = LIBRARY, world: SomeWorld = None, kit: KitName = None, as_json: Json = False
) -> None:
    """List the automata of a library, those of squads and types of robots as SORT/NAME.

    [dim]understudy list --library demo/library[/]
    """
    from rich.markup import escape

    from understudy.ui.cli.library_data import open_all_libraries, summarize_automaton
    from understudy.ui.cli.options import find_optional_kit, open_scenario
    from understudy.ui.cli.output import (
        format_count,
        format_saved_time,
        make_console,
        make_table,
        print_json,
    )

    where = None if world is None else open_scenario(world)
    listings = open_all_libraries(
        library, where, find_optional_kit(kit, world), lambda _: {}
    )  # it needs no trees
    rows = [
        {**row, "name": f"{prefix}{row['name']}"}
        for prefix, listing in listings.items()
        for opened in listing.opened.values()
        for row in [summarize_automaton(listing.folder, listing.library, opened)]
    ]
    problems = {
        f"{prefix}{name}": str(error)
        for prefix, listing in listings.items()
        for name, error in listing.problems.items()
    }
    if as_json:
        print_json({"library": str(library), "automata": rows, "problems": problems})
    else:
        made = make_table("automaton", "#states", "#shown", "#watched", "runs", "#former", "saved")
        made.columns[4].no_wrap = False
        for row in rows:
            name = f"{row['name']}({', '.join(row['parameters'])})" if row["parameters"] else row["name"]
            numbers = [str(row[key] or "") for key in ("states", "examples", "watched")]
            saved = format_saved_time(row["saved"])
            made.add_row(
                escape(name), *numbers, escape(", ".join(row["uses"])), str(row["versions"] or ""), saved
            )
        out = make_console()
        out.print(
            f"[bold]{escape(str(library))}[/]: {format_count(len(rows), 'automaton', 'automata')}",
            soft_wrap=True,
        )
        if rows:
            out.print(made)
        for problem in problems.values():
            make_console(err=True).print(f"[red]Cannot be opened:[/] {escape(problem)}", soft_wrap=True)
    raise typer.Exit(2 if problems else 0)


def rebuild(
    names: AutomatonNames = None,
    library: LibraryOption = LIBRARY,
    world: WorldOption = WORLD,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Learn automata again whose stored trees no longer fit their examples, and save them.

    Needed after editing a document by hand, or with a new version of the learner; the former version is kept.
    """
    from understudy.storage.library_folder import open_library, save_automaton
    from understudy.ui.cli.options import find_kit, import_learner
    from understudy.ui.cli.output import format_count, make_console, print_json

    opened = open_library(library, find_kit(kit, world), import_learner())
    for name in names or []:
        opened.library.automaton(name)
    rebuilt = {}
    for name, reason in opened.rebuilt.items():
        if (not names or name in names) and "classifier" not in reason:
            save_automaton(library, opened.library.taught[name])
            rebuilt[name] = reason
    if as_json:
        print_json({"library": str(library), "rebuilt": rebuilt})
        return
    for name, reason in rebuilt.items():
        make_console().print(name, "learned again and saved:", reason, markup=False)
    make_console().print(f"{format_count(len(rebuilt), 'automaton', 'automata')} rebuilt")
