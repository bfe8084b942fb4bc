"""Quarantine at the desk: examples that teach nothing for now, and those that may teach again."""

from __future__ import annotations

from collections.abc import Sequence

from understudy.errors import listed
from understudy.ui.controller.status import Said
from understudy.ui.controller.trainer import Desk

BY_HAND = "Somebody put it there."


def hold(desk: Desk, numbers: Sequence[int]) -> None:
    """Let examples teach nothing for now: for what speaks against them, or because somebody wants it."""
    judgement = desk.session.judgement
    reasons = {} if judgement is None else judgement.reasons
    desk.session.quarantine({number: reasons.get(number, BY_HAND) for number in numbers})
    desk.said = Said(f"{_examples(numbers)} in quarantine; undo takes that back")
    desk.changed()


def release(desk: Desk, numbers: Sequence[int]) -> None:
    """Let examples teach again."""
    desk.session.quarantine(dict.fromkeys(numbers, ""))
    desk.said = Said(f"{_examples(numbers)} out of quarantine; undo takes that back")
    desk.changed()


def _examples(numbers: Sequence[int]) -> str:
    """Examples by number, with the verb: "Example 3 is", "Examples 3 and 5 are"."""
    return f"Example {numbers[0]} is" if len(numbers) == 1 else f"Examples {listed(map(str, numbers))} are"
