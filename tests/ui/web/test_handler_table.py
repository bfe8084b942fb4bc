"""Handlers of messages are found by their annotations, and what they return is what answers hold."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import pytest

from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web.actions.handler_table import find_handlers, list_reply_types
from understudy.ui.web.messages.base import Data
from understudy.ui.web.messages.session import Redo, Undo
from understudy.ui.web.session_host import SessionHost


class Reply(Data, frozen=True):
    """The fields of an answer."""

    number: int


def undo(host: SessionHost, message: Undo) -> Reply | StatusMessage:
    """Take something back."""
    return Reply(message.id)


def undo_too(host: SessionHost, message: Undo) -> None:
    """Take back the same."""


def redo(trainer: Trainer, message: Redo) -> StatusMessage:
    """Do something again."""
    return StatusMessage(f"{trainer.name} {message.id}")


def helper(host: SessionHost, name: str) -> None:
    """Take no message."""


def _redo(host: SessionHost, message: Redo) -> None:
    """Be private."""


def module(*functions: Callable[..., Any]) -> ModuleType:
    made = ModuleType(__name__)
    vars(made).update({each.__name__: each for each in functions})
    return made


class Trained:
    """As much of a host as a handler on the trainer needs."""

    frame_version = 0

    class active_trainer:
        """As much of a trainer."""

        name = "goto"


def test_they_are_found_by_the_message_they_take() -> None:
    found = find_handlers(module(undo, helper, _redo), module(redo))
    assert set(found) == {Undo, Redo}
    assert found[Undo] is undo


def test_one_that_acts_on_the_desk_is_given_what_is_trained_and_shows_it_anew() -> None:
    host: Any = Trained()
    assert find_handlers(module(redo))[Redo](host, Redo(id=3)) == StatusMessage("goto 3")
    assert host.frame_version == 1


def test_two_for_one_message() -> None:
    with pytest.raises(TypeError, match="two functions handle Undo: the second is undo_too"):
        find_handlers(module(undo, undo_too))


def test_what_they_reply() -> None:
    assert list_reply_types(module(undo, redo, helper)) == [Reply]
