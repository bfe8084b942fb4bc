"""Write values as small HTML cards, which notebooks show: a heading, facts, and tables.

Colors are those of the page around, so that cards are readable in light and in dark notebooks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from html import escape
from statistics import median
from typing import TYPE_CHECKING, Any

from understudy.model.automaton import Automaton
from understudy.model.describe import describe_options, format_value
from understudy.model.lesson import ExampleKind, Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.viz.automaton_graph import format_automaton_title, lay_out_taught
from understudy.viz.automaton_svg import draw_graphs_svg
from understudy.viz.evaluation_plot import Interval

if TYPE_CHECKING:
    from understudy.runtime.run_loop import Run
    from understudy.training.session import Session

MOST_ROWS = 8
"""The largest number of rows of a table; further ones are counted."""
LINE = "rgba(128,128,128,.35)"
CARD = f"display:inline-block;max-width:60em;padding:.5em .8em;border:1px solid {LINE};border-radius:6px"
CELL = f"padding:.15em .7em .15em 0;border-bottom:1px solid {LINE};text-align:left;vertical-align:top"
_PRESSED = (ExampleKind.DIRECTIVE, ExampleKind.CONFIRMATION, ExampleKind.DEFAULT)


def write_card(title: str, facts: Sequence[str], *parts: str) -> str:
    """Write a card of a heading, facts in small type, and parts that are HTML already."""
    small = (
        f'<div style="opacity:.75;font-size:90%">{escape(" · ".join(filter(None, facts)))}</div>'
        if facts
        else ""
    )
    return f'<div style="{CARD}"><b>{escape(title)}</b>{small}{"".join(parts)}</div>'


def format_html_table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a table of texts; of many rows the first ones, and how many there are more."""
    rows = list(rows)
    if not rows:
        return ""
    head = "".join(f'<th style="{CELL};font-weight:600">{escape(each)}</th>' for each in heads)
    lines = [[f'<td style="{CELL}">{escape(each)}</td>' for each in row] for row in rows[:MOST_ROWS]]
    body = "".join(f"<tr>{''.join(cells)}</tr>" for cells in lines)
    more = len(rows) - MOST_ROWS
    rest = f'<div style="opacity:.75;font-size:90%">and {more} more</div>' if more > 0 else ""
    style = "border-collapse:collapse;font-size:90%;margin-top:.4em;background:none;color:inherit"
    return f'<table style="{style}"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{rest}'


def draw_automaton(automaton: Automaton | TrainedAutomaton) -> str:
    """Draw an automaton as an SVG document with the conditions of its transitions."""
    taught = TrainedAutomaton(automaton) if isinstance(automaton, Automaton) else automaton
    return draw_graphs_svg([lay_out_taught(taught)])


def write_lesson_html(lesson: Lesson) -> str:
    """Write a lesson: its options, and its examples from presses."""
    automaton, counts = lesson.automaton, Counter(example.kind for example in lesson.examples)
    number = [f"{counts[kind]} {kind}{'s' if counts[kind] != 1 else ''}" for kind in _PRESSED if counts[kind]]
    watched = [f"{counts[ExampleKind.WATCHED]} watched"] if counts[ExampleKind.WATCHED] else []
    options = [f"{name} {value}" for name, value in describe_options(lesson).items() if value]
    heads = ["#", "state", "next", "kind", *(str(bound) for bound in automaton.features)]
    rows = [
        (
            str(example.number),
            example.state,
            "stay" if example.next == example.state else example.next,
            f"{example.kind}, in quarantine" if example.quarantined else str(example.kind),
            *(
                format_value(bound, value)
                for bound, value in zip(automaton.features, example.values, strict=True)
            ),
        )
        for example in lesson.examples
        if example.is_from_press
    ]
    states = f"states {', '.join(automaton.state_names)}"
    facts = [", ".join([*number, *watched]) or "no examples", states, ", ".join(options)]
    return write_card(f"Lesson {format_automaton_title(automaton)}", facts, format_html_table(heads, rows))


def write_library_html(library: Library) -> str:
    """Write a library: its automata, and the numbers of the kit's parts."""
    kit = library.kit
    rows = [
        (
            format_automaton_title(taught.automaton),
            ", ".join(taught.automaton.state_names),
            ", ".join(str(bound) for bound in taught.automaton.features),
            "written by hand" if taught.lesson is None else str(len(taught.lesson.examples)),
        )
        for taught in library.taught.values()
    ]
    facts = [
        f"{len(kit.behaviors)} basic behaviors",
        f"{len(kit.features)} features",
        f"{len(kit.targets)} targets",
    ]
    title = f"Library of {len(rows)} {'automaton' if len(rows) == 1 else 'automata'}"
    return write_card(title, facts, format_html_table(("automaton", "states", "features", "examples"), rows))


def write_run_html(run: Run) -> str:
    """Write a run: its time, and what each agent is doing."""
    agents = run.body.agents
    rows = [
        (str(agent), " > ".join(run.path(agent)) or "basic behavior")
        for agent in range(min(agents, MOST_ROWS + 1))
    ]
    rows += [("", "")] * (agents - len(rows))
    facts = [f"{type(run.body).__name__}", f"{agents} agent{'s' * (agents != 1)}", f"{run.body.time_s:.1f} s"]
    return write_card("Run", facts, format_html_table(("agent", "states, outermost first"), rows))


def write_session_html(session: Session) -> str:
    """Write a session: mode, states, targets, and the present values of the features."""
    view, bounds = session.view(), session.automaton.features
    values = [
        (str(bound), format_value(bound, value))
        for bound, value in zip(bounds, view.features.values(), strict=True)
    ]
    states = [f"{'▸ ' if name == view.state else ''}{name}" for name in view.states]
    facts = [
        str(view.mode),
        f"{view.time_s:.1f} s",
        f"{view.examples} examples from presses",
        *(f"{parameter} = {target}" for parameter, target in view.targets.items()),
    ]
    states_line = f'<div style="margin-top:.4em">{escape(" | ".join(states))}</div>'
    title = f"Session of {format_automaton_title(session.automaton)}"
    return write_card(title, facts, states_line, format_html_table(("feature", "now"), values))


def write_evaluation_html(evaluation: Any, interval: Interval) -> str:
    """Write an evaluation: success with its 95 % interval, medians of metrics, and times, beside the baseline's."""
    rows = [_outcome_row(evaluation.behavior, evaluation.taught)]
    if evaluation.expert is not None:
        rows.append(_outcome_row("baseline", evaluation.expert))
    finished = evaluation.taught.finished
    low, high = interval(int(finished.sum()), len(finished))
    flag = None if evaluation.flag is None else f"flag {evaluation.flag}"
    facts = [
        f"success {100 * evaluation.success:.0f} % (95 % interval {100 * low:.0f} to {100 * high:.0f} %)",
        f"judged by {flag or evaluation.goal or 'the goal of the scenario'}",
        *([] if evaluation.raised is None else [evaluation.raised.describe()]),
        *(f"{name} {evaluation.medians[name].median:.3g} in the median" for name in evaluation.metrics),
    ]
    heads = ("", "finished", "median of those", "longest")
    return write_card(
        f"Evaluation of {evaluation.behavior} in {evaluation.world}", facts, format_html_table(heads, rows)
    )


def _outcome_row(name: str, outcomes: Any) -> tuple[str, ...]:
    times = sorted(outcomes.seconds[outcomes.finished].tolist())
    spread = (f"{median(times):.1f} s", f"{times[-1]:.1f} s") if times else ("–", "–")
    return (name, f"{len(times)} of {len(outcomes.seconds)} worlds", *spread)
