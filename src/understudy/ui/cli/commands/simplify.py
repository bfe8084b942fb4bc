"""Command `understudy simplify`: preview an automaton with fewer questions in its trees, or save it."""

from __future__ import annotations

from typing import Any

from rich.markup import escape
from rich.padding import Padding

from understudy.judging.simplify_preview import (
    SimplifyPreview,
    make_simplify_error,
    preview_simplification,
)
from understudy.learning.fit import learn
from understudy.learning.pruning_suggestions import ENOUGH
from understudy.storage.json_text import select_facts
from understudy.storage.library_folder import make_file_stem, read_document, save_automaton
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.library_data import find_optional_kit
from understudy.ui.cli.library_options import SimplifyOptions
from understudy.ui.cli.output import format_count, make_console

MOST_DECISIONS = 12


def simplify(options: SimplifyOptions) -> None:
    """Show an automaton with fewer questions: its conditions before and after, and the decisions that change."""
    path = options.library / f"{make_file_stem(options.name)}.json"
    taught = read_document(path, find_optional_kit(options.kit, options.world), learn).taught
    found = preview_simplification(taught, options.pruning)
    if options.pruning is None and found.suggested is None and options.keep:
        problem, remedy = "has too few examples to tell what could go", "say how much with --pruning"
        raise make_simplify_error(options.name, problem, remedy)
    if options.keep:
        save_automaton(options.library, found.after)
    if options.as_json:
        print_json(_describe(found, kept=options.keep))
    else:
        _show(found, chosen=options.pruning is not None, kept=options.keep)


def _describe(found: SimplifyPreview, *, kept: bool) -> dict[str, Any]:
    """Describe an automaton before and after pruning for `--json`; with conditions only of states where they change."""
    return {
        "name": found.before.automaton.name,
        **select_facts(found, "pruning", "suggested", "leaves", "conditions", "decisions"),
        "examples": found.replayed.examples,
        "changes_before_presses": found.changes_before_presses,
        "moments_before_presses": found.replayed.before,
        "kept": kept,
    }


def _show(found: SimplifyPreview, *, chosen: bool, kept: bool) -> None:
    out, suggested, leaves = make_console(), found.suggested, found.leaves
    head = f"[bold]{escape(found.before.automaton.name)}[/] pruned by {found.pruning:.3g}"
    size = f"{format_count(leaves.before, 'answer')} before, {leaves.after} after"
    out.print(f"{head}: {size}", soft_wrap=True)
    if suggested is not None:
        wrong = f"{suggested.wrong_pruned} of {suggested.left_out} wrong, {suggested.wrong} without pruning"
        out.print(
            f"[dim]suggested: {suggested.pruning:.3g}; examples left out in turn: {wrong}[/]", soft_wrap=True
        )
    elif not chosen:
        few = f"It has fewer than {ENOUGH} examples, too few to prune."
        out.print(f"[dim]{few}[/]", soft_wrap=True)
    conditions = found.conditions
    for state, both in conditions.items():
        out.print(f"\n[cyan]{escape(state)}[/]")
        same = [line for line in both.before if line in both.after]
        for color, mark, lines in (
            ("default", " ", same),
            ("red", "-", both.before),
            ("green", "+", both.after),
        ):
            for line in lines:
                if mark == " " or line not in same:
                    out.print(Padding(f"[{color}]{mark} {escape(line)}[/]", (0, 0, 0, 2), expand=False))
    if not conditions:
        out.print("nothing would change" if not kept else "nothing changed")
        return
    out.print()
    for line in _describe_decisions(found):
        out.print(Padding(escape(line), (0, 0, 0, 2), expand=False))
    if not kept:
        how = "--keep" if suggested is not None else f"--pruning {found.pruning:g} --keep"
        out.print(f"[dim]Nothing was changed: {how} saves it so.[/]")
    elif found.pruning:
        out.print("Kept; --pruning 0 --keep takes it back")


def _describe_decisions(found: SimplifyPreview) -> list[str]:
    """Describe the decisions that would change, one line each."""
    rows = found.decisions
    lines = [f"{len(rows)} of {found.replayed.examples} examples would be decided otherwise"]
    for row in rows[:MOST_DECISIONS]:
        right = "as shown" if row.after == row.shown else f"shown: {row.shown}"
        lines.append(f"{row.number} in {row.state}: {row.before} → {row.after} ({right})")
    if len(rows) > MOST_DECISIONS:
        lines.append(f"and {len(rows) - MOST_DECISIONS} more")
    if found.replayed.before:
        total = sum(row.moments for row in found.changes_before_presses)
        lines.append(f"{total} of {found.replayed.before} moments before presses, too")
    return lines
