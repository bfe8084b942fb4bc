"""Command `understudy simplify`: preview an automaton with fewer questions in its trees, or save it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rich.markup import escape
from rich.padding import Padding

from understudy.judging.simplify_preview import (
    BeforeAfter,
    ChangedDecision,
    ChangedMoments,
    SimplifyPreview,
    make_simplify_error,
    preview_simplification,
)
from understudy.learning.fit import learn
from understudy.learning.pruning_suggestions import ENOUGH, PruningSuggestion
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
    result = _make_result(found, kept=options.keep)
    if options.keep:
        save_automaton(options.library, found.after)
    if options.as_json:
        print_json(result)
    else:
        _show(result, chosen=options.pruning is not None)


@dataclass(frozen=True, kw_only=True)
class SimplifyResult:
    """Automaton before and after pruning, and whether the pruned one was saved."""

    name: str
    pruning: float
    suggested: PruningSuggestion | None
    leaves: BeforeAfter[int]
    conditions: Mapping[str, BeforeAfter[list[str]]]
    """Conditions before and after, by state; only states whose conditions would change."""
    decisions: Sequence[ChangedDecision]
    """Examples that would be decided differently."""
    examples: int
    changes_before_presses: Sequence[ChangedMoments]
    moments_before_presses: int
    kept: bool


def _make_result(found: SimplifyPreview, *, kept: bool) -> SimplifyResult:
    return SimplifyResult(
        name=found.before.automaton.name,
        pruning=found.pruning,
        suggested=found.suggested,
        leaves=found.leaves,
        conditions=found.conditions,
        decisions=found.decisions,
        examples=found.replayed.examples,
        changes_before_presses=found.changes_before_presses,
        moments_before_presses=found.replayed.before,
        kept=kept,
    )


def _show(result: SimplifyResult, *, chosen: bool) -> None:
    out, found = make_console(), result.suggested
    head = f"[bold]{escape(result.name)}[/] pruned by {result.pruning:.3g}"
    size = f"{format_count(result.leaves.before, 'answer')} before, {result.leaves.after} after"
    out.print(f"{head}: {size}", soft_wrap=True)
    if found is not None:
        wrong = f"{found.wrong_pruned} of {found.left_out} wrong, {found.wrong} without pruning"
        out.print(
            f"[dim]suggested: {found.pruning:.3g}; examples left out in turn: {wrong}[/]", soft_wrap=True
        )
    elif not chosen:
        few = f"It has fewer than {ENOUGH} examples, too few to prune."
        out.print(f"[dim]{few}[/]", soft_wrap=True)
    for state, both in result.conditions.items():
        out.print(f"\n[cyan]{escape(state)}[/]")
        kept = [line for line in both.before if line in both.after]
        for color, mark, lines in (
            ("default", " ", kept),
            ("red", "-", both.before),
            ("green", "+", both.after),
        ):
            for line in lines:
                if mark == " " or line not in kept:
                    out.print(Padding(f"[{color}]{mark} {escape(line)}[/]", (0, 0, 0, 2), expand=False))
    if not result.conditions:
        out.print("nothing would change" if not result.kept else "nothing changed")
    if result.conditions:
        out.print()
    for line in _decisions(result):
        out.print(Padding(escape(line), (0, 0, 0, 2), expand=False))
    if result.conditions and not result.kept:
        how = "--keep" if found is not None else f"--pruning {result.pruning:g} --keep"
        out.print(f"[dim]Nothing was changed: {how} saves it so.[/]")
    elif result.conditions and result.pruning:
        out.print("Kept; --pruning 0 --keep takes it back")


def _decisions(result: SimplifyResult) -> list[str]:
    """Describe the decisions that would change, one line each."""
    if not result.conditions:
        return []
    rows = result.decisions
    lines = [f"{len(rows)} of {result.examples} examples would be decided otherwise"]
    for row in rows[:MOST_DECISIONS]:
        right = "as shown" if row.after == row.shown else f"shown: {row.shown}"
        lines.append(f"{row.number} in {row.state}: {row.before} → {row.after} ({right})")
    if len(rows) > MOST_DECISIONS:
        lines.append(f"and {len(rows) - MOST_DECISIONS} more")
    if result.moments_before_presses:
        total = sum(row.moments for row in result.changes_before_presses)
        lines.append(f"{total} of {result.moments_before_presses} moments before presses, too")
    return lines
