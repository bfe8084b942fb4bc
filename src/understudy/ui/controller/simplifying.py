"""Simplifying at the desk: fewer questions, chosen by somebody who has seen what that comes to."""

from __future__ import annotations

from understudy.analysis.simplify_preview import Simpler, simpler, simplifiable
from understudy.learning.pruning_suggestions import with_pruning
from understudy.ui.controller.status import Said
from understudy.ui.controller.trainer import Desk


def seen(desk: Desk, pruning: float | None = None) -> Simpler:
    """What pruning the lesson as it stands would come to; nothing is changed."""
    return simpler(desk.session.taught(), pruning)


def prune(desk: Desk, pruning: float) -> None:
    """Learn the lesson with a pruning from now on; 0 takes it back."""
    lesson = simplifiable(desk.session.taught())
    desk.session.choose(options=with_pruning(lesson, pruning).options)
    desk.said = Said(
        "It is as simple as you saw; undo takes that back" if pruning else "Nothing is pruned now"
    )
    desk.changed()
