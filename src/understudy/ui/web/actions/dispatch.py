"""Directing: let each message be handled, and say what came of it."""

from __future__ import annotations

from understudy.ui.controller.status import Said
from understudy.ui.web.actions import camera, coach, lesson, library, session, world
from understudy.ui.web.actions.handlers import handlers
from understudy.ui.web.messages.base import Data, Message
from understudy.ui.web.session_host import Stage
from understudy.ui.web.views import explanation, lesson_test

MODULES = (
    lesson,
    world,
    library,
    library,
    library,
    session,
    coach,
    explanation,
    lesson_test,
    lesson_test,
    camera,
)
"""Those that have handlers of messages."""
ACTIONS = handlers(*MODULES)


def obey(stage: Stage, message: Message) -> Data | None:
    """Do what a message asks for, and return the fields of the answer.

    UnderstudyError where it cannot be done, and nothing is changed.
    """
    came = ACTIONS[type(message)](stage, message)
    if isinstance(came, Said):
        stage.said = came
        return None
    return came
