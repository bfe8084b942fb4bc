"""Requests: what the widget's page asks for when a person presses something, and what a session does then."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Literal, TypeAlias

import msgspec
from msgspec import Meta, Struct

from understudy.coaching.queries import QueryPolicy
from understudy.errors import SessionError
from understudy.ui.controller import coach
from understudy.ui.controller.trainer import Trainer

Action: TypeAlias = Literal[
    "press", "confirm", "toggle_mode", "pause", "step", "restart", "new_world", "undo", "redo", "ask", "save",
    "toggle_score", "show", "hide",
]  # fmt: skip


class WidgetRequest(Struct, frozen=True, forbid_unknown_fields=True):
    """A request of a view. `state` is the state that was pressed, `view` the view that is shown or hidden."""

    action: Action
    state: Annotated[str, Meta(max_length=150)] = ""
    view: Annotated[str, Meta(max_length=50)] = ""


def parse_request(content: object) -> WidgetRequest:
    """Parse a request; SessionError if it is not one, as from a page of another version."""
    try:
        return msgspec.convert(content, WidgetRequest)
    except msgspec.ValidationError as error:
        raise SessionError(
            f"the notebook's page sent a request that cannot be understood ({error}): restart the kernel and reload "
            "the page, so that both have the same version"
        ) from None


def press_state(trainer: Trainer, state: str | None) -> None:
    """Direct the robot to a state (None: confirm the present one), which also answers an open question."""
    if trainer.coach.question is not None:
        coach.answer_question(trainer, state)
    elif state is None:
        trainer.confirm()
    else:
        trainer.press(state)


def toggle_questions(trainer: Trainer) -> None:
    """Let the robot pause and ask where it is unsure, or no longer."""
    asks = trainer.coach.asking.when is QueryPolicy.PAUSE
    coach.change_query_policy(trainer, QueryPolicy.NEVER if asks else QueryPolicy.PAUSE)


ACTIONS: Mapping[str, Callable[[Trainer], object]] = {
    "confirm": lambda trainer: press_state(trainer, None),
    "toggle_mode": Trainer.toggle_mode,
    "pause": Trainer.pause,
    "step": Trainer.step,
    "restart": Trainer.restart,
    "new_world": Trainer.new_world,
    "undo": Trainer.undo,
    "redo": Trainer.redo,
    "ask": toggle_questions,
    "save": Trainer.save,
    "toggle_score": Trainer.toggle_score,
}
"""What the trainer does on a request that has neither state nor view."""
