"""Differences between two versions of an automaton, as lines that begin with "+", "-" or a blank."""

from __future__ import annotations

from collections.abc import Mapping

from understudy.errors import join_names
from understudy.model.automaton import Automaton
from understudy.model.describe import convert_to_plain, describe_options, describe_transitions
from understudy.model.drawing import Axes, call_markup, call_plot, format_repr
from understudy.model.lesson import Example
from understudy.model.library import TrainedAutomaton


class AutomatonDiff(dict[str, list[str]]):
    """The differences between two versions of an automaton: by topic, the lines removed ("-") and added ("+").

    Parameters
    ----------
    before
        The former version.
    after
        The later version.
    lines
        The lines by topic: parameters, states, features, options, examples and conditions. Topics without changes
        are left out.
    """

    def __init__(
        self, before: TrainedAutomaton, after: TrainedAutomaton, lines: Mapping[str, list[str]]
    ) -> None:
        super().__init__(lines)
        self.before, self.after = before, after

    def __repr__(self) -> str:
        topics = join_names(self) if self else "nothing"
        return format_repr(self, f"{self.after.automaton.name!r}", f"{topics} changed")

    def plot(self, ax: Axes | None = None) -> Axes:
        """Plot both versions as one graph in which added parts have a +, removed ones a − and changed ones a ±.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw into. None: in a new figure.

        Returns
        -------
        Axes
            The axes.
        """
        return call_plot("diff_plot:plot_diff", self, ax)

    def _repr_svg_(self) -> str:
        return call_markup("diff_plot:draw_diff_svg", self)


def diff_automata(before: TrainedAutomaton, after: TrainedAutomaton) -> AutomatonDiff:
    """List what was removed and added between two versions of an automaton.

    Parameters
    ----------
    before
        The former version.
    after
        The later version.

    Returns
    -------
    AutomatonDiff
        Lines that begin with "-" (removed), "+" (added) or a blank, by topic: parameters, states, features, options,
        conditions and examples. Topics without changes are left out.
    """
    old, new = before.automaton, after.automaton
    lines_by_topic = {
        "parameters": _lines(dict.fromkeys(old.parameters, ""), dict.fromkeys(new.parameters, "")),
        "states": _lines(_states(old), _states(new)),
        "features": _lines(_features(old), _features(new)),
        "options": _lines(_options(before), _options(after)),
        "conditions": _conditions(before, after),
        "examples": _lines(_examples(before), _examples(after)),
    }
    return AutomatonDiff(before, after, {topic: lines for topic, lines in lines_by_topic.items() if lines})


def _lines(old: Mapping[str, str], new: Mapping[str, str]) -> list[str]:
    """List the entries that were removed, added or changed, in the order of `old` and then of new entries."""
    lines = []
    for key in dict.fromkeys([*old, *new]):
        if old.get(key) != new.get(key):
            lines += [f"- {key}{old[key]}"] if key in old else []
            lines += [f"+ {key}{new[key]}"] if key in new else []
    return lines


def _states(automaton: Automaton) -> dict[str, str]:
    return {state.name: f"  ({state})" for state in automaton.states}


def _features(automaton: Automaton) -> dict[str, str]:
    return {str(bound): f"  {bound.kind} {bound.feature.unit}".rstrip() for bound in automaton.features}


def _options(taught: TrainedAutomaton) -> dict[str, str]:
    chosen = {} if taught.lesson is None else describe_options(taught.lesson)
    return {
        "stateless": f": {taught.automaton.stateless}",
        **{key: f": {value}" for key, value in chosen.items()},
    }


def _examples(taught: TrainedAutomaton) -> dict[str, str]:
    if taught.lesson is None:
        return {}
    pressed = [example for example in taught.lesson.examples if example.is_from_press]
    watched = len(taught.lesson.examples) - len(pressed)
    rows = {f"{example.number}": _example(example, taught.automaton) for example in pressed}
    return {**rows, **({"watched": f": {watched}"} if watched else {})}


def _example(example: Example, automaton: Automaton) -> str:
    answer = "stay" if example.next == example.state else f"go to {example.next}"
    values = []
    for bound, value in zip(automaton.features, example.values, strict=True):
        plain = convert_to_plain(value, bound)
        written = "absent" if plain is None else f"{plain:.4g}" if isinstance(plain, float) else plain
        values.append(f"{bound} {written}")
    quarantine = f" - in quarantine: {example.quarantined}" if example.quarantined else ""
    source = "" if example.source is None else f" - from {example.source}"
    return f"  in {example.state} {answer} ({example.kind}): {', '.join(values)}{source}{quarantine}"


def _conditions(old: TrainedAutomaton, new: TrainedAutomaton) -> list[str]:
    lines = []
    before, after = (describe_transitions(each.automaton, each.lesson) for each in (old, new))
    for state in dict.fromkeys([*before, *after]):
        gone = [line for line in before.get(state, []) if line not in after.get(state, [])]
        come = [line for line in after.get(state, []) if line not in before.get(state, [])]
        if gone or come:
            lines += [f"  {state}", *(f"- {line}" for line in gone), *(f"+ {line}" for line in come)]
    return lines
