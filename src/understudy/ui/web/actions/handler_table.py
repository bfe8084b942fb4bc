"""Find the function that handles a message of the page, by the type of the message."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import MappingProxyType, ModuleType
from typing import Any, TypeAlias, get_args, get_type_hints

from msgspec import structs

from understudy.ui.controller import coach as coach_actions
from understudy.ui.controller import lesson_actions
from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web.actions import camera, coach, library, places, property_edits, session, world
from understudy.ui.web.background import SlowAction
from understudy.ui.web.messages import review as r
from understudy.ui.web.messages import session as m
from understudy.ui.web.messages.base import Data, Message
from understudy.ui.web.session_host import SessionHost
from understudy.ui.web.views import explanation, grid_view, lesson_test

Handler: TypeAlias = Callable[[SessionHost, Any], Data | StatusMessage | SlowAction | None]
"""Do what a message asks for; return the fields of the answer, what the studio says of it, or what is left to do."""


def find_handlers(*modules: ModuleType) -> Mapping[type[Message], Handler]:
    """Return the handlers that modules define, by the type of the message they take.

    A handler is a public function with two annotated parameters: the host and a message.
    """
    handlers: dict[type[Message], Handler] = {}
    for function, (_, message, _) in _annotated(modules):
        if message in handlers:
            raise TypeError(f"two functions handle {message.__name__}: the second is {function.__qualname__}")
        handlers[message] = function
    return MappingProxyType(handlers)


def list_reply_types(*modules: ModuleType) -> list[type[Data]]:
    """Return the types that the handlers of modules return as the fields of an answer."""
    returned = [each for _, (*_, result) in _annotated(modules) for each in get_args(result) or [result]]
    return [each for each in returned if isinstance(each, type) and issubclass(each, Data)]


def _annotated(modules: Iterable[ModuleType]) -> Iterator[tuple[Callable[..., Any], list[Any]]]:
    """Yield the handlers that modules define, each with the types of its host, its message and its result."""
    for module in modules:
        for name, function in vars(module).items():
            if inspect.isfunction(function) and function.__module__ == module.__name__ and name[0] != "_":
                types = [*get_type_hints(function).values()]
                if len(types) == 3 and isinstance(types[1], type) and issubclass(types[1], Message):
                    yield function, types


def make_trainer_handler(action: Callable[..., object]) -> Handler:
    """Return a handler that calls an action with the trainer and the message's fields, in their order.

    The handler raises SessionError if no session is open.
    """

    def handle(host: SessionHost, message: Message) -> None:
        _, *fields = structs.astuple(message)  # without its number
        action(host.active_trainer, *fields)
        host.frame_version += 1

    return handle


TRAINER_ACTIONS: Mapping[type[Message], Callable[..., object]] = MappingProxyType(
    {
        m.ToggleMode: Trainer.toggle_mode,
        m.RestartAutomaton: Trainer.restart,
        m.BindTargets: Trainer.bind_targets,
        m.ToggleWatching: Trainer.toggle_watching,
        m.ToggleScore: Trainer.toggle_score,
        m.ChooseGoal: lesson_actions.choose_goal,
        m.Undo: Trainer.undo,
        m.Redo: Trainer.redo,
        m.DeleteExample: Trainer.delete,
        m.QuarantineExamples: lesson_actions.quarantine_examples,
        m.ReleaseExamples: lesson_actions.release_examples,
        r.AddProperty: lesson_actions.add_property_here,
        r.RemoveProperty: lesson_actions.remove_property,
        r.ApplyPruning: lesson_actions.change_pruning,
        r.SetQueryPolicy: coach_actions.change_query_policy,
        r.SetReactionTime: coach_actions.change_reaction_time,
        r.CorrectSlip: coach_actions.correct_slip,
        r.ConfirmPress: coach_actions.confirm_doubted_press,
    }
)
"""By message, the action on the trainer that does what it asks for, where that needs nothing but its fields."""
MODULES = (
    session,
    world,
    places,
    library,
    coach,
    explanation,
    lesson_test,
    grid_view,
    camera,
    property_edits,
)
"""The modules that define the handlers of the other messages."""
HANDLERS: Mapping[type[Message], Handler] = MappingProxyType(
    {
        **{message: make_trainer_handler(action) for message, action in TRAINER_ACTIONS.items()},
        **find_handlers(*MODULES),
    }
)
"""The handler of each type of message."""
