"""Commands `understudy validate` and `understudy rebuild`, which process all automata of a library in a world."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.markup import escape
from rich.padding import Padding

from understudy.errors import join_names
from understudy.learning.fit import learn
from understudy.learning.report import find_contradictions, find_disagreements, find_overruled
from understudy.model.tree import Tree
from understudy.model.tree_regions import find_tested_features
from understudy.sim.catalog import find_scenario
from understudy.sim.scenario.files import list_builtin_scenarios
from understudy.storage.library_folder import save_automaton
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.library_data import find_listed, report_left_out
from understudy.ui.cli.library_options import RebuildOptions, ValidateOptions
from understudy.ui.cli.named_inputs import find_kit, find_optional_scenario
from understudy.ui.cli.options import WORLD
from understudy.ui.cli.output import format_count, make_console
from understudy.ui.cli.world_libraries import (
    find_broken_documents,
    find_fitting_world,
    find_misfits,
    find_problems,
    open_all_libraries,
)

if TYPE_CHECKING:
    from understudy.storage.document import LoadedDocument
    from understudy.storage.library_folder import LoadedLibrary


def validate(options: ValidateOptions) -> None:
    """Check a library: open every file, resolve every name, and examine every lesson."""
    names = options.names
    where = find_optional_scenario(options.world) or find_scenario(WORLD)  # a body of one's own has no team
    listings = open_all_libraries(options.library, where, find_kit(options.kit, options.world), learn)
    problems = {
        label: [str(error)] for label, error in find_problems(options.library, listings, where).items()
    }
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
    advice = suggest_other_scenario(options.library, problems) if problems and options.kit is None else None
    if options.as_json:
        result = {"library": str(options.library), "valid": not problems, "checked": checked}
        print_json({**result, "problems": problems, "notes": noted, "advice": advice})
    else:
        _show(options.library, checked, problems, noted)
        if advice is not None:
            make_console().print(advice, soft_wrap=True, markup=False)
    raise typer.Exit(2 if problems else 0)


def _show(
    folder: Path, checked: list[str], problems: dict[str, list[str]], noted: dict[str, list[str]]
) -> None:
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
    worlds = [world for world in list_builtin_scenarios() if not find_misfits(folder, find_scenario(world))]
    if worlds:
        return f"It is all valid in another scenario: give {' or '.join(f'--world {world}' for world in worlds)}."
    if set(problems) <= set(find_broken_documents(folder)):
        return None
    return "If it was taught in another scenario, give --world SCENARIO; with a kit of your own, --kit MODULE:NAME."


def find_warnings(listing: LoadedLibrary, name: str) -> list[str]:
    """Return notes on an automaton: stale trees, contradictions, unused features, states never entered."""
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


def rebuild(options: RebuildOptions) -> None:
    """Relearn and save automata whose stored trees no longer match their examples."""
    named = options.world or (find_fitting_world(options.library) if options.kit is None else WORLD)
    scenario = find_optional_scenario(named)
    where = scenario or find_scenario(WORLD)  # a body of one's own has no team
    called = named if scenario is None else scenario.name
    listings = open_all_libraries(options.library, where, find_kit(options.kit, named), learn)
    report_left_out(listings)
    for listing in listings.values():
        listing.refuse_damaged()
    wanted = ["".join(find_listed(listings, name)) for name in options.names or []]
    rebuilt = {}
    for prefix, listing in listings.items():
        for name, opened in listing.opened.items():
            reason, label = opened.rebuilt, f"{prefix}{name}"
            if reason is not None and (not wanted or label in wanted) and "classifier" not in reason:
                save_automaton(listing.folder, opened.taught)
                rebuilt[label] = reason
    if options.as_json:
        print_json({"library": str(options.library), "world": called, "rebuilt": rebuilt})
        return
    out = make_console()
    for name, reason in rebuilt.items():
        out.print(name, "learned again and saved:", reason, markup=False)
    found = format_count(len(rebuilt), "automaton", "automata")
    out.print(f"{escape(str(options.library))}, in {escape(called)}: {found} rebuilt", soft_wrap=True)
