"""Handlers of messages are found by their annotations, and what they return is what answers hold."""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature
from types import ModuleType
from typing import Any

import pytest

from understudy.ui.controller.status import StatusMessage
from understudy.ui.web.actions.handler_table import (
    MODULES,
    TRAINER_ACTIONS,
    find_handlers,
    list_reply_types,
    make_trainer_handler,
)
from understudy.ui.web.messages.base import Data, Message
from understudy.ui.web.messages.review import CorrectSlip
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


def redo(host: SessionHost, message: Redo) -> StatusMessage:
    """Do something again."""
    return StatusMessage(f"{host.seed} {message.id}")


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
    active_trainer = "goto"


def test_they_are_found_by_the_message_they_take() -> None:
    found = find_handlers(module(undo, helper, _redo), module(redo))
    assert found == {Undo: undo, Redo: redo}


def test_an_action_on_the_trainer_is_given_the_fields_and_shows_it_anew() -> None:
    host: Any = Trained()
    done: list[tuple[Any, ...]] = []
    handle = make_trainer_handler(lambda *given: done.append(given))
    assert handle(host, CorrectSlip(id=1, number=3, next="fly")) is None
    assert done == [("goto", 3, "fly")]
    assert host.frame_version == 1


@pytest.mark.parametrize("message", TRAINER_ACTIONS)
def test_an_action_on_the_trainer_takes_the_fields_of_its_message(message: type[Message]) -> None:
    _, *fields = message.__struct_fields__
    signature(TRAINER_ACTIONS[message]).bind("trainer", *fields)
    assert message not in find_handlers(*MODULES)


def test_two_for_one_message() -> None:
    with pytest.raises(TypeError, match="two functions handle Undo: the second is undo_too"):
        find_handlers(module(undo, undo_too))


def test_what_they_reply() -> None:
    assert list_reply_types(module(undo, redo, helper)) == [Reply]
