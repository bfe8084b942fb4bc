"""Actions of the page that take longer than a tick may: they are done in other threads, and answered afterwards."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

from understudy.ui.controller.status import StatusMessage
from understudy.ui.web.clients import Client

MOST = 32
"""The number of actions that are done at the same time."""


@dataclass(frozen=True, slots=True)
class SlowAction:
    """An action that takes longer than a tick may.

    Attributes
    ----------
    status
        What the studio says while it lasts.
    work
        What is done in another thread.
    finish
        What is done in the thread of the ticks when `work` has succeeded; it returns what the studio then says.
    """

    status: StatusMessage
    work: Callable[[], None]
    finish: Callable[[], StatusMessage]


@dataclass(frozen=True, slots=True)
class BegunAction:
    """A slow action that was begun, and the message (its page and number) that is answered at its end."""

    action: SlowAction
    work: Future[None]
    viewer: Client
    number: int | None

    def finish(self) -> StatusMessage:
        """Finish the action, and return what the studio says; raise what it raised in its thread."""
        self.work.result()
        return self.action.finish()


class SlowActions:
    """The slow actions that are under way."""

    def __init__(self) -> None:
        self._threads = ThreadPoolExecutor(MOST, thread_name_prefix="action")
        self._begun: list[BegunAction] = []

    def begin(self, action: SlowAction, viewer: Client, number: int | None) -> None:
        """Begin an action in another thread, for a page's message of this number."""
        self._begun.append(BegunAction(action, self._threads.submit(action.work), viewer, number))

    def take_done(self) -> list[BegunAction]:
        """Remove and return the actions whose threads have done their work."""
        done = [each for each in self._begun if each.work.done()]
        self._begun = [each for each in self._begun if each not in done]
        return done
