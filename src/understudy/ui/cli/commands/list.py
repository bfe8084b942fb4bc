"""Commands `understudy list` and `understudy rebuild`, which process all automata of a library."""

from __future__ import annotations

from dataclasses import replace

import typer

from understudy.ui.cli.options import (
    LIBRARY,
    WORLD,
    AutomatonNames,
    FoundWorld,
    Json,
    KitName,
    LibraryOption,
    SomeWorld,
)


def list_automata(
    library: LibraryOption = LIBRARY, world: SomeWorld = None, kit: KitName = None, as_json: Json = False
) -> None:
    """List the automata of a library; those of squads and robot types are named SORT/NAME.

    [dim]understudy list --library demo/library[/]
    """
    from rich.markup import escape

    from understudy.ui.cli.library_data import open_all_libraries, summarize_automaton
    from understudy.ui.cli.options import find_optional_kit, find_optional_scenario
    from understudy.ui.cli.output import (
        format_count,
        format_saved_time,
        make_console,
        make_table,
        print_json,
    )

    where = find_optional_scenario(world)
    listings = open_all_libraries(
        library, where, find_optional_kit(kit, world), lambda _: {}
    )  # it needs no trees
    rows = [
        replace(summarize_automaton(listing.folder, listing.library, opened), name=f"{prefix}{name}")
        for prefix, listing in listings.items()
        for name, opened in listing.opened.items()
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
            name = f"{row.name}({', '.join(row.parameters)})" if row.parameters else row.name
            numbers = [str(number or "") for number in (row.states, row.examples, row.watched)]
            saved = format_saved_time(row.saved)
            made.add_row(escape(name), *numbers, escape(", ".join(row.uses)), str(row.versions or ""), saved)
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
    world: FoundWorld = None,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Relearn and save automata whose stored trees no longer match their examples.

    This is needed after a document was edited by hand, or with a new version of the learner. The former version is
    kept.
    """
    from rich.markup import escape

    from understudy.storage.library_folder import save_automaton
    from understudy.ui.cli.library_data import find_fitting_world, find_listed, open_all_libraries
    from understudy.ui.cli.options import find_kit, find_optional_scenario, import_learner, open_scenario
    from understudy.ui.cli.output import format_count, make_console, print_json

    named = world or (find_fitting_world(library) if kit is None else WORLD)
    scenario = find_optional_scenario(named)
    where = scenario or open_scenario(WORLD)  # a body of one's own has no team
    called = named if scenario is None else scenario.name
    listings = open_all_libraries(library, where, find_kit(kit, named), import_learner())
    for listing in listings.values():
        for error in listing.problems.values():
            raise error
    wanted = ["".join(find_listed(listings, name)) for name in names or []]
    rebuilt = {}
    for prefix, listing in listings.items():
        for name, opened in listing.opened.items():
            reason, label = opened.rebuilt, f"{prefix}{name}"
            if reason is not None and (not wanted or label in wanted) and "classifier" not in reason:
                save_automaton(listing.folder, opened.taught)
                rebuilt[label] = reason
    if as_json:
        print_json({"library": str(library), "world": called, "rebuilt": rebuilt})
        return
    out = make_console()
    for name, reason in rebuilt.items():
        out.print(name, "learned again and saved:", reason, markup=False)
    found = format_count(len(rebuilt), "automaton", "automata")
    out.print(f"{escape(str(library))}, in {escape(called)}: {found} rebuilt", soft_wrap=True)
