"""Simplifying: what the automaton under training would be with fewer questions, as plain data."""

from __future__ import annotations

from understudy.analysis.simplify_preview import Simpler
from understudy.learning.pruning_suggestions import ENOUGH, Suggestion
from understudy.ui.controller import formatting
from understudy.ui.controller.simplifying import seen
from understudy.ui.web.session_host import Stage
from understudy.ui.web.views.scene import Plain


def describe_simplification(stage: Stage, pruning: float | None) -> Plain:
    """Conditions before and after, and the decisions that would change; nothing is changed yet."""
    found = seen(stage.trained, pruning)
    before, after = found.leaves
    return {
        "simpler": {
            "pruning": found.pruning,
            "suggested": _suggested(found.suggested),
            "enough": ENOUGH,
            "leaves": {"before": before, "after": after},
            "states": [
                {"state": state, "before": _signed(old), "after": _signed(new)}
                for state, (old, new) in found.conditions.items()
            ],
            "decisions": [
                {
                    "number": each.number,
                    "state": each.state,
                    "shown": each.shown,
                    "before": each.formerly,
                    "after": each.now,
                }
                for each in found.decisions
            ],
            **_moments(found),
        }
    }


def _suggested(found: Suggestion | None) -> Plain | None:
    if found is None:
        return None
    return {
        "pruning": found.pruning,
        "left_out": found.examples,
        "wrong": found.wrong,
        "wrong_pruned": found.wrong_pruned,
    }


def _moments(found: Simpler) -> Plain:
    """How many examples, and how many moments before presses, were replayed; at how many of these it changes."""
    changed = sum(each.moments for each in found.replayed.changes)
    return {
        "examples": found.replayed.examples,
        "moments": {"all": found.replayed.before, "changed": changed},
    }


def _signed(lines: list[str]) -> list[str]:
    return list(map(formatting.signed, lines))
