"""Directing: which function does what a message asks for."""

from __future__ import annotations

from understudy.ui.web.actions import camera, coach, lesson, library, session, world
from understudy.ui.web.actions.handlers import find_handlers
from understudy.ui.web.views import explanation, lesson_test

MODULES = (lesson, world, library, session, coach, explanation, lesson_test, camera)
"""Those that have handlers of messages."""
ACTIONS = find_handlers(*MODULES)
"""What does what a message asks for, by the type of the message."""
