"""Differences between two versions of an automaton, as lines that begin with "+", "-" or a blank."""

from __future__ import annotations

from collections.abc import Mapping

from understudy.model.automaton import Automaton
from understudy.model.describe import convert_to_plain, describe_options, describe_transitions
from understudy.model.lesson import Example
from understudy.model.library import TrainedAutomaton


def diff_automata(before: TrainedAutomaton, after: TrainedAutomaton) -> dict[str, list[str]]:
    """List by topic what was removed (lines with "-") and added (lines with "+") between two versions.

    Topics are parameters, states, features, options, examples and conditions. Those without changes are left out.
    """
    old, new = before.automaton, after.automaton
    found = {
        "parameters": _lines(dict.fromkeys(old.parameters, ""), dict.fromkeys(new.parameters, "")),
        "states": _lines(_states(old), _states(new)),
        "features": _lines(_features(old), _features(new)),
        "options": _lines(_options(before), _options(after)),
        "conditions": _conditions(before, after),
        "examples": _lines(_examples(before), _examples(after)),
    }
    return {topic: lines for topic, lines in found.items() if lines}


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
    said = "stay" if example.next == example.state else f"go to {example.next}"
    values = []
    for bound, value in zip(automaton.features, example.values, strict=True):
        shown = convert_to_plain(value, bound)
        written = "absent" if shown is None else f"{shown:.4g}" if isinstance(shown, float) else shown
        values.append(f"{bound} {written}")
    kept = f" - in quarantine: {example.quarantined}" if example.quarantined else ""
    return f"  in {example.state} {said} ({example.kind}): {', '.join(values)}{kept}"


def _conditions(old: TrainedAutomaton, new: TrainedAutomaton) -> list[str]:
    lines = []
    before, after = (describe_transitions(each.automaton, each.lesson) for each in (old, new))
    for state in dict.fromkeys([*before, *after]):
        gone = [line for line in before.get(state, []) if line not in after.get(state, [])]
        come = [line for line in after.get(state, []) if line not in before.get(state, [])]
        if gone or come:
            lines += [f"  {state}", *(f"- {line}" for line in gone), *(f"+ {line}" for line in come)]
    return lines
