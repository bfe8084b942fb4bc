"""What the trainer says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Concatenate, Literal, ParamSpec, Protocol, TypeAlias, TypeVar

Tone: TypeAlias = Literal["", "recorded", "correction", "error"]


@dataclass(frozen=True, slots=True)
class StatusMessage:
    """The last thing the trainer said."""

    text: str
    tone: Tone = ""


class Speaker(Protocol):
    """Has what was said last."""

    status: StatusMessage


S = TypeVar("S", bound=Speaker)
P = ParamSpec("P")


def keep_status(
    action: Callable[Concatenate[S, P], StatusMessage],
) -> Callable[Concatenate[S, P], StatusMessage]:
    """Let the sentence that an action returns be what its first argument said last."""

    @wraps(action)
    def act(speaker: S, /, *args: P.args, **named: P.kwargs) -> StatusMessage:
        said = action(speaker, *args, **named)
        speaker.status = said
        return said

    return act
