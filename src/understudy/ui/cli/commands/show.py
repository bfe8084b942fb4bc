"""Command `understudy show`: show everything about one automaton."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.ui.cli.options import LIBRARY, Json, KitName, LibraryOption, SomeWorld

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rich.console import Console

    from understudy.model.automaton import Automaton
    from understudy.model.library import Library
    from understudy.ui.cli.library_data import AutomatonDescription, ExampleRow

SHOWN = 20


def show_automaton(
    name: Annotated[
        str, typer.Argument(help="Name of the automaton; SORT/NAME for one of a squad or robot type.")
    ],
    library: LibraryOption = LIBRARY,
    world: SomeWorld = None,
    kit: KitName = None,
    everything: Annotated[
        bool, typer.Option("--all", help="List all examples, including watched ones.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Show an automaton: its states, its features, the conditions it learned, and its examples.

    [dim]understudy show goto --library demo/library[/]
    """
    from understudy.ui.cli.library_data import describe_automaton, find_listed, open_all_libraries
    from understudy.ui.cli.options import find_optional_kit, find_optional_scenario, import_learner
    from understudy.ui.cli.output import make_console, print_json

    where = find_optional_scenario(world)
    listings = open_all_libraries(library, where, find_optional_kit(kit, world), import_learner())
    prefix, name = find_listed(listings, name)
    listing = listings[prefix]
    if name not in listing.opened:
        raise listing.problems[f"{name}.json"]
    automaton = listing.library.automaton(name)
    facts = describe_automaton(listing.folder, listing.library, listing.opened[name])
    if as_json:
        print_json(facts)
        return
    out = make_console()
    _head(facts, out)
    _structure(automaton, listing.library, out)
    _conditions(automaton, facts.conditions, out)
    _examples(facts, out, everything=everything)


def _head(facts: AutomatonDescription, out: Console) -> None:
    from rich.markup import escape

    from understudy.ui.cli.output import format_count, format_saved_time

    called = facts.name + (f"({', '.join(facts.parameters)})" if facts.parameters else "")
    out.print(f"[bold]{escape(called)}[/]" + (" [dim]stateless[/]" if facts.stateless else ""))
    kept = format_count(len(facts.versions), "former version")
    lines = [f"saved {format_saved_time(facts.saved)}, {kept}"]
    if facts.used_by:
        lines.append(f"used by {', '.join(facts.used_by)}")
    chosen = facts.options
    if chosen is None:
        lines.append("written by hand: it has no examples")
    else:
        learns = "decision trees" if chosen["learner"] == "trees" else f"{chosen['learner']} of scikit-learn"
        times = chosen.get("reaction_times_of_drivers_s") or [chosen["reaction_s"]]
        late = f", presses taken {' or '.join(f'{each:g}' for each in times)} s earlier" if any(times) else ""
        silence = ", also from silence" if chosen["watched"] else ""
        unlearns = ", corrections quarantine bad examples" if chosen["unlearning"] else ""
        pruned = f", pruned by {chosen['pruning']:.3g}" if chosen.get("pruning") else ""
        lines.append(f"learns {learns}{pruned}{late}{silence}{unlearns}")
    out.print(f"[dim]{escape('; '.join(lines))}[/]")


def _structure(automaton: Automaton, library: Library, out: Console) -> None:
    from rich.columns import Columns
    from rich.markup import escape

    from understudy.ui.cli.output import make_table

    states = make_table("state", "does")
    for state in automaton.states:
        does = (
            "[dim]idles[/]"
            if state.behavior is None
            else escape(library.format_call(state.behavior, state.binding))
        )
        states.add_row(escape(state.name), does if state.flag is None else f"raises {escape(state.flag)}")
    features = make_table("feature", "kind", "unit")
    for bound in automaton.features:
        features.add_row(escape(str(bound)), escape(_kind(str(bound.kind))), bound.feature.unit)
    out.print(Columns([states, features] if automaton.features else [states], padding=(0, 4)))


def _kind(spelled: str) -> str:
    return {"categorical(no|yes)": "no or yes", "toroidal(6.283185307179586)": "angle"}.get(spelled, spelled)


def _conditions(automaton: Automaton, conditions: Mapping[str, Sequence[str]], out: Console) -> None:
    from rich.markup import escape
    from rich.padding import Padding

    out.print("[bold]When it switches[/]")
    for state in automaton.states:
        if state.flag is None:
            out.print(f"  [cyan]{escape(state.name)}[/]")
            for line in conditions.get(state.name) or ["[dim]stays: there are no examples here[/]"]:
                out.print(
                    Padding(line if line.startswith("[dim]") else escape(line), (0, 0, 0, 4), expand=False)
                )


def _examples(facts: AutomatonDescription, out: Console, *, everything: bool) -> None:
    from rich.markup import escape

    from understudy.ui.cli.output import format_count, make_table

    rows = [row for row in facts.examples if everything or row.kind != "watched"]
    if not facts.examples:
        return
    beside = f" [dim]beside {format_count(facts.watched, 'watched example')}[/]" if facts.watched else ""
    out.print(f"\n[bold]What was shown[/]{'' if everything else beside}")
    recorded = ["from"] if any(row.source is not None for row in rows) else []
    labels = (f"#{feature.name}" for feature in facts.features)
    made = make_table("#", "state", "next", "kind", *recorded, *labels)
    made.columns[0].justify = "right"
    for row in rows if everything else rows[:SHOWN]:
        kind = row.kind + "*" * row.correction + "†" * row.edited + "‡" * bool(row.quarantined)
        following = "[dim]stay[/]" if row.next == row.state else escape(row.next)
        values = zip(row.values.values(), facts.features, strict=True)
        told = (_value(value, feature.unit) for value, feature in values)
        places = ["" if row.source is None else escape(str(row.source))] * len(recorded)
        made.add_row(str(row.number), escape(row.state), following, kind, *places, *told)
    for column in made.columns[4:]:
        column.no_wrap, column.overflow = False, "fold"
    out.print(made)
    for mark, key, what in (
        ("*", "correction", "a correction"),
        ("†", "edited", "edited by hand"),
        ("‡", "quarantined", "in quarantine: it teaches nothing"),
    ):
        if any(getattr(row, key) for row in rows):
            out.print(f"[dim]{mark} {what}[/]")
    _reasons(rows, out)
    if not everything and len(rows) > SHOWN:
        out.print(f"[dim]{len(rows) - SHOWN} more: --all[/]")


def _reasons(rows: list[ExampleRow], out: Console) -> None:
    """Print why examples are in quarantine, one line per reason."""
    from rich.markup import escape
    from rich.padding import Padding

    why: dict[str, list[str]] = {}
    for row in rows:
        if row.quarantined:
            why.setdefault(row.quarantined, []).append(str(row.number))
    for reason, numbers in why.items():
        out.print(Padding(f"[dim]{', '.join(numbers)}: {escape(reason)}[/]", (0, 0, 0, 2), expand=False))


def _value(value: float | str | None, unit: str) -> str:
    """Format a value as conditions do: angles in degrees, other numbers with three digits."""
    if value is None:
        return "[dim]absent[/]"
    if isinstance(value, str):
        return value
    from understudy.model.describe import around_zero

    return f"{around_zero(round(degrees(value)))}°".replace("-", "−") if unit == "rad" else f"{value:.3g}"
