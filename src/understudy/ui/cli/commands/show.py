"""Commands `understudy show` and `understudy draw`: show everything about one automaton, or draw it as a picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees
from typing import TYPE_CHECKING, Any

from rich.columns import Columns
from rich.markup import escape
from rich.padding import Padding

from understudy.errors import FileError
from understudy.learning.fit import learn
from understudy.model.describe import around_zero
from understudy.storage.atomic_write import convert_os_errors, write_atomically
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.library_data import (
    describe_automaton,
    find_automaton,
    list_plain_values,
    open_listings,
)
from understudy.ui.cli.library_options import DrawOptions, ShowOptions
from understudy.ui.cli.output import format_count, format_saved_time, make_console, make_table, print_table
from understudy.viz.automaton_file import check_picture_name, render_automata

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.model.automaton import Automaton
    from understudy.model.lesson import Example
    from understudy.model.library import Library


SHOWN = 20


def show_automaton(options: ShowOptions) -> None:
    """Show an automaton: its states, its features, the conditions it learned, and its examples."""
    listing, name = find_automaton(open_listings(options, learn), options.name)
    automaton = listing.library.automaton(name)
    facts = describe_automaton(listing.folder, listing.library, listing.opened[name])
    if options.as_json:
        print_json(facts)
        return
    out = make_console()
    _head(automaton, facts, out)
    _structure(automaton, listing.library, out)
    _conditions(automaton, facts["conditions"], out)
    lesson = listing.opened[name].taught.lesson
    if lesson is not None and lesson.examples:
        _examples(automaton, lesson.examples, out, everything=options.everything)


def _head(automaton: Automaton, facts: Mapping[str, Any], out: Console) -> None:
    called = automaton.name + (f"({', '.join(automaton.parameters)})" if automaton.parameters else "")
    out.print(f"[bold]{escape(called)}[/]" + (" [dim]stateless[/]" if automaton.stateless else ""))
    kept = format_count(len(facts["versions"]), "former version")
    lines = [f"saved {format_saved_time(facts['saved'])}, {kept}"]
    if facts["used_by"]:
        lines.append(f"used by {', '.join(facts['used_by'])}")
    chosen = facts["options"]
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
    tables = [states, features] if automaton.features else [states]
    beside = Columns(tables, padding=(0, 4))
    if all(out.measure(each).maximum < out.width for each in tables):
        out.print(beside)
    else:
        for each in tables:
            print_table(out, each)


def _kind(spelled: str) -> str:
    return {"categorical(no|yes)": "no or yes", "toroidal(6.283185307179586)": "angle"}.get(spelled, spelled)


def _conditions(automaton: Automaton, conditions: Mapping[str, Sequence[str]], out: Console) -> None:
    out.print("[bold]When it switches[/]")
    for state in automaton.states:
        if state.flag is None:
            out.print(f"  [cyan]{escape(state.name)}[/]")
            for line in conditions.get(state.name) or ["[dim]stays: there are no examples here[/]"]:
                out.print(
                    Padding(line if line.startswith("[dim]") else escape(line), (0, 0, 0, 4), expand=False)
                )


def _examples(automaton: Automaton, examples: Sequence[Example], out: Console, *, everything: bool) -> None:
    rows = [row for row in examples if everything or row.is_from_press]
    watched = sum(not row.is_from_press for row in examples)
    beside = f" [dim]beside {format_count(watched, 'watched example')}[/]" if watched else ""
    out.print(f"\n[bold]What was shown[/]{'' if everything else beside}")
    recorded = ["from"] if any(row.source is not None for row in rows) else []
    labels = (f"#{feature}" for feature in automaton.features)
    made = make_table("#", "state", "next", "kind", *recorded, *labels)
    made.columns[0].justify = "right"
    for row in rows if everything else rows[:SHOWN]:
        kind = row.kind + "*" * row.correction + "†" * row.edited + "‡" * bool(row.quarantined)
        following = "[dim]stay[/]" if row.next == row.state else escape(row.next)
        told = (_value(value, bound.feature.unit) for bound, value in list_plain_values(row, automaton))
        places = ["" if row.source is None else escape(str(row.source))] * len(recorded)
        made.add_row(str(row.number), escape(row.state), following, kind, *places, *told)
    print_table(out, made, lead=4)
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


def _reasons(rows: Sequence[Example], out: Console) -> None:
    """Print why examples are in quarantine, one line per reason."""
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
    return f"{around_zero(round(degrees(value)))}°".replace("-", "−") if unit == "rad" else f"{value:.3g}"


def draw_automata(options: DrawOptions) -> None:
    """Draw an automaton: its states as a graph, and in words when it switches between them."""
    ending = check_picture_name(options.out, where="--out")
    if options.out.exists() and not options.force:
        problem, remedy = "this file exists already", "name another file, or give --force to overwrite it"
        raise FileError(path=options.out, place="", problem=problem, remedy=remedy)
    listing, name = find_automaton(open_listings(options, learn), options.name)
    names = list_automata_below(listing.library, name) if options.children else [name]
    data = render_automata([listing.library.taught[each] for each in names], ending)
    with convert_os_errors(options.out, "writing the picture"):
        write_atomically(options.out, data)
    if options.as_json:
        print_json({"name": name, "file": options.out, "automata": names, "bytes": len(data)})
    else:
        make_console().print(f"Drawn in {options.out}", markup=False, soft_wrap=True)


def list_automata_below(library: Library, name: str) -> list[str]:
    """List an automaton and all below it that the library has, level by level, each once."""
    found = [name]
    for each in found:  # it grows meanwhile
        runs = dict.fromkeys(state.behavior for state in library.automaton(each).states)
        found += [
            child for child in runs if child in library.taught and child is not None and child not in found
        ]
    return found
