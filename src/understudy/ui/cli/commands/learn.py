"""Learn from a lesson for any command that does: predict, save, and print what was learned."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from rich.markup import escape
from rich.padding import Padding

from understudy.learning.csv_table import QueryRow, read_query_rows
from understudy.learning.fit import predict_next_states
from understudy.learning.lesson_change import summarize_lesson_change
from understudy.learning.report import Report, learn_and_report
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.storage.json_text import select_facts
from understudy.storage.library_folder import open_each_automaton, save_automaton
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.lesson_options import LearnOptions
from understudy.ui.cli.output import format_count, make_console, make_table

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.model.change_summary import ChangeSummary
    from understudy.model.lesson import Lesson

MOST_CONTRADICTED = 5
"""The largest number of examples decided otherwise that are printed."""


def learn_lesson(
    lesson: Lesson,
    options: LearnOptions,
    facts: Mapping[str, Any] | None = None,
    print_facts: Callable[[], None] = lambda: None,
    lines: Mapping[int, str] = MappingProxyType({}),
) -> None:
    """Learn from a lesson, save and print the result.

    `lines` are the places of examples in the table that they are from, by their numbers. Before the result come the
    facts about the recordings that the lesson was made of, with `--json` as further keys.
    """
    rows = None if options.predict is None else read_query_rows(options.predict, lesson)
    result = learn_and_report(lesson, lines=lines)
    automaton = replace(lesson.automaton, transitions=result.transitions)
    saved = None if options.library is None else _save(options.library, TrainedAutomaton(automaton, lesson))
    following = None if rows is None else predict_next_states(result.transitions, automaton.state_names, rows)
    if options.as_json:
        names = ("states", "repeated", "examples", "contradicted")
        learned = {**select_facts(result, *names), "predictions": following or [], **(facts or {})}
        print_json({**learned, **_name_saved(saved)})
        return
    print_facts()
    _show(result, rows, following)
    if saved is not None:
        _print_saved(*saved)


def _name_saved(saved: tuple[Path, ChangeSummary | None] | None) -> dict[str, object]:
    """Return where the automaton was saved and what changed, as `--json` prints it."""
    if saved is None:
        return {}
    path, changed = saved
    return {"saved": str(path), "changed": () if changed is None else changed.changes}


def _save(folder: Path, taught: TrainedAutomaton) -> tuple[Path, ChangeSummary | None]:
    """Save the automaton; refuse if automata of the folder would then contain themselves.

    Return its path, and what it decides otherwise than the version that it replaces, if that has the same states.
    """
    beside = (
        open_each_automaton(folder, None, lambda _: {}).library
        if folder.is_dir()
        else Library(Kit.from_parts())
    )
    beside.with_automaton(taught)
    former = beside.taught.get(taught.automaton.name)
    changed = None
    if former is not None and former.automaton.state_names == taught.automaton.state_names:
        changed = summarize_lesson_change(former, taught)
    return save_automaton(folder, taught), changed


def _print_saved(path: Path, changed: ChangeSummary | None) -> None:
    out = make_console()
    out.print(f"Saved to [bold]{escape(str(path))}[/]", soft_wrap=True)
    if changed is not None:
        out.print("What it decides otherwise than the version before, beyond what new rows say:")
        for each in changed.changes:
            out.print(Padding(f"[yellow]{escape(each.said)}[/]", (0, 0, 0, 2), expand=False))


def _show(result: Report, rows: tuple[QueryRow, ...] | None, following: list[str] | None) -> None:
    out = make_console()
    if not result.states:
        out.print("[yellow]Nothing was learned: no example was made by a press.[/]")
    for name, state in result.states.items():
        size = f"{format_count(state.nodes, 'node')}, depth {state.depth}, {state.fit_ms:.2g} ms"
        out.print(f"[cyan]{escape(name)}[/] [dim]{size}[/]")
        for line in state.conditions:
            out.print(Padding(escape(line), (0, 0, 0, 2), expand=False))
        for number, what in ((state.contradictions, "contradiction"), (state.disagreements, "disagreement")):
            if number:
                out.print(Padding(f"[yellow]{format_count(number, what)}[/]", (0, 0, 0, 2), expand=False))
        if state.overruled:
            said = f"{state.overruled} of {format_count(state.watched, 'watched example')} decided otherwise"
            out.print(Padding(f"[yellow]{said}[/]", (0, 0, 0, 2), expand=False))
    _print_repeated(out, result)
    if rows is not None and following is not None:
        made = make_table("#row", "state", "next")
        for index, (row, next_state) in enumerate(zip(rows, following, strict=True), 1):
            made.add_row(
                str(index), escape(row.state), "[dim]stay[/]" if next_state == row.state else next_state
            )
        out.print(made)


def _print_repeated(out: Console, result: Report) -> None:
    """Print how many examples are decided as shown, and the first of the others."""
    if not result.states:
        return
    if not result.contradicted:
        which = "The only example is" if result.examples == 1 else f"All {result.examples} examples are"
        out.print(f"{which} decided as shown.")
        return
    out.print(
        f"[yellow]{result.repeated} of {format_count(result.examples, 'example')}[/] are decided as shown. Others:"
    )
    for each in result.contradicted[:MOST_CONTRADICTED]:
        out.print(Padding(escape(str(each)), (0, 0, 0, 2), expand=False))
    more = len(result.contradicted) - MOST_CONTRADICTED
    if more > 0:
        out.print(f"  [dim]and {more} more; --json lists all[/]")
