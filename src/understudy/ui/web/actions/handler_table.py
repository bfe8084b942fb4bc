"""Find the function that handles a message of the page, by the type of the message."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import MappingProxyType, ModuleType
from typing import Any, TypeAlias, get_args, get_type_hints

from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web.actions import camera, coach, library, session, world
from understudy.ui.web.messages.base import Data, Message
from understudy.ui.web.session_host import SessionHost
from understudy.ui.web.views import explanation, lesson_test

Handler: TypeAlias = Callable[[SessionHost, Any], Data | StatusMessage | None]
"""Do what a message asks for; return the fields of the answer, or what the studio says of it."""


def find_handlers(*modules: ModuleType) -> Mapping[type[Message], Handler]:
    """Find the handlers that modules define, by the message they take.

    A handler is a public function of two parameters whose second is annotated with a message. The first is the host,
    or the trainer: then something has to be in training, and pages are shown how it looks afterwards.
    """
    found: dict[type[Message], Handler] = {}
    for function, (first, message, _) in _annotated(modules):
        if message in found:
            raise TypeError(f"two functions handle {message.__name__}: the second is {function.__qualname__}")
        found[message] = _on_desk(function) if first is Trainer else function
    return MappingProxyType(found)


def list_reply_types(*modules: ModuleType) -> list[type[Data]]:
    """List what the handlers of modules return as the fields of an answer."""
    returned = [each for _, (*_, result) in _annotated(modules) for each in get_args(result) or [result]]
    return [each for each in returned if isinstance(each, type) and issubclass(each, Data)]


def _annotated(modules: Iterable[ModuleType]) -> Iterator[tuple[Callable[..., Any], list[Any]]]:
    """The handlers that modules define, each with the types of its first parameter, its message and its result."""
    for module in modules:
        for name, function in vars(module).items():
            if inspect.isfunction(function) and function.__module__ == module.__name__ and name[0] != "_":
                types = [*get_type_hints(function).values()]
                if len(types) == 3 and isinstance(types[1], type) and issubclass(types[1], Message):
                    yield function, types


def _on_desk(function: Callable[[Trainer, Any], Data | StatusMessage | None]) -> Handler:
    def act(host: SessionHost, message: Message) -> Data | StatusMessage | None:
        came = function(host.active_trainer, message)
        host.frame_version += 1
        return came

    return act


MODULES = (session, world, library, coach, explanation, lesson_test, camera)
"""Those that have handlers of messages."""
HANDLERS = find_handlers(*MODULES)
"""What does what a message asks for, by the type of the message."""
