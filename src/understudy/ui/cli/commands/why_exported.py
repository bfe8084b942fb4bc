"""Mode `--exported` of `understudy why`: explain the trace that exported code wrote."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from understudy.errors import SettingError

if TYPE_CHECKING:
    from understudy.export.exported_trace import ExportedDecision, ExportedTick
    from understudy.export.hierarchy import Hierarchy
    from understudy.learning.explain import Explanation
    from understudy.model.library import Library


@dataclass(frozen=True, kw_only=True)
class ExportedReason:
    """A decision of exported code, with its conditions and the numbers of the examples behind it."""

    time: float
    automaton: str
    before: str
    after: str
    why: str
    conditions: Sequence[str]
    shown: bool
    examples: Sequence[int]


@dataclass(frozen=True, kw_only=True)
class ExportedReasons:
    """The reasons of a tick of exported code, or of all switches."""

    automaton: str
    ticks: int
    decisions: Sequence[ExportedReason]


def explain_exported(
    trace: Path, folder: Path, *, time: float | None, world: str | None, kit: str | None, as_json: bool
) -> None:
    """Explain every switch in a trace of exported code, or all decisions of the tick at a time."""
    from understudy.export.export_automaton import combine_fingerprints, fingerprint_automata, link_ground
    from understudy.export.exported_trace import check_trace, find_tick, read_exported_trace
    from understudy.ui.cli.commands.export import open_library_to_export
    from understudy.ui.cli.output import make_console, print_json

    read = read_exported_trace(trace)
    library, name, body = open_library_to_export(folder, read.name, world, kit)
    _, hierarchy = link_ground(library, name, read.binding, body)
    check_trace(read, hierarchy, combine_fingerprints(fingerprint_automata(library, name)))
    ticks = list(read.ticks)
    if time is not None:
        found = find_tick(ticks, time)
        if found is None:
            raise SettingError(
                where=str(trace),
                setting="--time",
                problem=f"is {time:.15g}, before the trace begins",
                remedy="give more",
            )
        ticks = [found]
    reasons = [
        _explain(tick, decision, hierarchy, library)
        for tick in ticks
        for decision in tick.decisions
        if time is not None or decision.before != decision.after
    ]
    if as_json:
        print_json(ExportedReasons(automaton=name, ticks=len(read.ticks), decisions=reasons))
        return
    from rich.markup import escape

    out = make_console()
    for reason in reasons:
        out.print(
            f"{reason.time:.15g} [cyan]{escape(reason.automaton)}[/] {escape(reason.why)}", soft_wrap=True
        )
    if not reasons:
        out.print(f"no automaton changed its state in {len(read.ticks)} ticks")


def _explain(
    tick: ExportedTick, decision: ExportedDecision, hierarchy: Hierarchy, library: Library
) -> ExportedReason:
    from understudy.analysis.explanation_text import MOST_EXAMPLES, describe_decision
    from understudy.errors import join_names

    automaton = hierarchy.automata[decision.automaton]
    before, after = automaton.states[decision.before], automaton.states[decision.after]
    found = _find_explanation(decision, hierarchy, library)
    numbers = [each.number for each in found.examples if each.is_from_press] if found else []
    why = f"stays in {before.name}: it has no tree there" if found is None else describe_decision(found)
    if before.flag is not None:
        why = f"stays in {before.name}: a flag state is never left"
    if numbers:
        more = [f"{len(numbers) - MOST_EXAMPLES} more"] if len(numbers) > MOST_EXAMPLES else []
        why += f"; shown by {join_names([*map(str, numbers[:MOST_EXAMPLES]), *more])}"
    return ExportedReason(
        time=tick.time,
        automaton=automaton.name,
        before=before.name,
        after=after.name,
        why=why,
        conditions=() if found is None else found.conditions,
        shown=found is not None and found.shown,
        examples=numbers,
    )


def _find_explanation(
    decision: ExportedDecision, hierarchy: Hierarchy, library: Library
) -> Explanation | None:
    from dataclasses import replace

    from understudy.learning.explain import explain_leaf
    from understudy.model.lesson import Lesson

    automaton = hierarchy.automata[decision.automaton]
    state = automaton.states[decision.before]
    if state.tree is None:
        return None
    taught = library.taught[automaton.automaton]
    lesson = taught.lesson or Lesson(replace(taught.automaton, transitions={}))
    return explain_leaf(lesson, state.name, state.tree, decision.leaf)
