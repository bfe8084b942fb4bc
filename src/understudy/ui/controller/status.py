"""The status line of a user interface, and errors as its sentences."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Concatenate, Literal, ParamSpec, Protocol, TypeAlias, TypeVar

from understudy.errors import UnderstudyError

_log = logging.getLogger(__name__)

Tone: TypeAlias = Literal["", "recorded", "correction", "error"]


@dataclass(frozen=True, slots=True)
class StatusMessage:
    """A sentence for the status line."""

    text: str
    tone: Tone = ""


class Speaker(Protocol):
    """An object that holds the current status."""

    status: StatusMessage


S = TypeVar("S", bound=Speaker)
P = ParamSpec("P")


def keep_status(
    action: Callable[Concatenate[S, P], StatusMessage],
) -> Callable[Concatenate[S, P], StatusMessage]:
    """Make an action store the message that it returns as the status of its first argument."""

    @wraps(action)
    def act(speaker: S, /, *args: P.args, **named: P.kwargs) -> StatusMessage:
        result = action(speaker, *args, **named)
        speaker.status = result
        return result

    return act


def describe_error(error: Exception) -> str:
    """Return a sentence that describes an error; internal errors are also logged."""
    if isinstance(error, UnderstudyError):
        return str(error)
    _log.error("an internal error", exc_info=error)
    return f"internal error: {type(error).__name__}: {error}"
