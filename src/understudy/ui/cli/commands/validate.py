"""Command `understudy validate`: check every document, name and lesson of a library."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from understudy.ui.cli.options import (
    LIBRARY,
    WORLD,
    AutomatonNames,
    Json,
    KitName,
    LibraryOption,
    WorldOption,
)

if TYPE_CHECKING:
    from collections.abc import Collection

    from understudy.storage.document import LoadedDocument
    from understudy.storage.library_folder import LoadedLibrary


def validate(
    names: AutomatonNames = None,
    library: LibraryOption = LIBRARY,
    world: WorldOption = WORLD,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Check a library: open every file, resolve every name, and examine every lesson.

    The exit code is 2 if there are problems. Notes do not change it.

    [dim]understudy validate --library demo/library[/]
    """
    from understudy.ui.cli.library_data import find_listed, find_problems, open_all_libraries
    from understudy.ui.cli.options import find_kit, find_optional_scenario, import_learner, open_scenario
    from understudy.ui.cli.output import make_console, print_json

    where = find_optional_scenario(world) or open_scenario(WORLD)  # a body of one's own has no team
    listings = open_all_libraries(library, where, find_kit(kit, world), import_learner())
    problems = {label: [str(error)] for label, error in find_problems(library, listings, where).items()}
    labels = [f"{prefix}{name}" for prefix, listing in listings.items() for name in listing.opened]
    names = ["".join(find_listed(listings, name)) if name not in problems else name for name in names or []]
    noted = {
        f"{prefix}{name}": found
        for prefix, listing in listings.items()
        for name in listing.opened
        if (found := find_warnings(listing, name))
    }
    checked = [name for name in dict.fromkeys([*labels, *problems]) if not names or name in names]
    problems = {name: problems[name] for name in checked if name in problems}
    noted = {name: noted[name] for name in checked if name in noted}
    advice = suggest_other_scenario(library, problems) if problems and kit is None else None
    if as_json:
        result = {"library": str(library), "valid": not problems, "checked": checked}
        print_json({**result, "problems": problems, "notes": noted, "advice": advice})
    else:
        _show(library, checked, problems, noted)
        if advice is not None:
            make_console().print(advice, soft_wrap=True, markup=False)
    raise typer.Exit(2 if problems else 0)


def _show(
    folder: Path, checked: list[str], problems: dict[str, list[str]], noted: dict[str, list[str]]
) -> None:
    from rich.markup import escape
    from rich.padding import Padding

    from understudy.ui.cli.output import format_count, make_console

    out = make_console()
    for name in checked:
        mark = "[red]✗[/]" if name in problems else "[yellow]•[/]" if name in noted else "[green]✓[/]"
        out.print(f"{mark} [bold]{escape(name)}[/]")
        for text in (*problems.get(name, []), *noted.get(name, [])):
            out.print(Padding(escape(text), (0, 0, 0, 4), expand=False))
    bad = f"[red]{format_count(len(problems), 'is', 'are')} invalid[/]" if problems else "[green]all valid[/]"
    out.print(
        f"{escape(str(folder))}: {format_count(len(checked), 'automaton', 'automata')}, {bad}", soft_wrap=True
    )


def suggest_other_scenario(folder: Path, problems: Collection[str]) -> str | None:
    """Suggest a scenario or kit in which a library with problems would be valid; None if none could help."""
    from understudy.sim.scenario.files import list_builtin_scenarios
    from understudy.ui.cli.library_data import find_broken_documents, find_misfits
    from understudy.ui.cli.options import open_scenario

    worlds = [world for world in list_builtin_scenarios() if not find_misfits(folder, open_scenario(world))]
    if worlds:
        return f"It is all valid in another scenario: give {' or '.join(f'--world {world}' for world in worlds)}."
    if set(problems) <= set(find_broken_documents(folder)):
        return None
    return "If it was taught in another scenario, give --world SCENARIO; with a kit of your own, --kit MODULE:NAME."


def find_warnings(listing: LoadedLibrary, name: str) -> list[str]:
    """Return notes on an automaton: stale trees, contradictions, unused features, states never entered."""
    from understudy.errors import join_names
    from understudy.model.tree import Tree
    from understudy.model.tree_regions import find_tested_features

    opened = listing.opened[name]
    automaton, lesson = opened.taught.automaton, opened.taught.lesson
    found = []
    if opened.rebuilt is not None and "classifier" not in opened.rebuilt:
        found.append(f"its trees were built again: {opened.rebuilt}; `understudy rebuild {name}` stores them")
    trees = [function for function in automaton.transitions.values() if isinstance(function, Tree)]
    if lesson is not None:
        found += _lesson_notes(opened)
    if len(trees) == len(automaton.transitions) and trees:
        used = find_tested_features(trees)
        idle = [str(bound) for index, bound in enumerate(automaton.features) if index not in used]
        if idle:
            found.append(f"{join_names(idle)} {'decides' if len(idle) == 1 else 'decide'} nothing")
        entered = {tree.nodes[leaf].yes for tree in trees for _, leaf in tree.leaves()}
        never = [state.name for index, state in enumerate(automaton.states) if index and index not in entered]
        if never:
            found.append(f"nothing ever leads to {join_names(never)}")
    return found


def _lesson_notes(opened: LoadedDocument) -> list[str]:
    from understudy.learning.report import find_contradictions, find_disagreements, find_overruled
    from understudy.ui.cli.output import format_count

    automaton, lesson = opened.taught.automaton, opened.taught.lesson
    found: list[str] = []
    if lesson is None:
        return found
    if not lesson.examples:
        return ["there are no examples yet"]
    for state, function in automaton.transitions.items():
        for group in find_contradictions(lesson, state):
            said = ", ".join(f"{example.number} says {example.next}" for example in group)
            found.append(f"in {state}, examples contradict each other: {said}")
        against = find_disagreements(lesson, state, function)
        if against:
            which = ", ".join(str(example.number) for example in against)
            found.append(
                f"in {state}, {format_count(len(against), 'example')} decided differently than shown: {which}"
            )
        watched = find_overruled(lesson, state, function)
        if watched:
            found.append(
                f"in {state}, {format_count(len(watched), 'watched example')} decided differently than the robot did"
            )
    return found
