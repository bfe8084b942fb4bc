"""What the trainer says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Concatenate, Literal, ParamSpec, Protocol, TypeAlias, TypeVar

Tone: TypeAlias = Literal["", "recorded", "correction", "error"]


@dataclass(frozen=True, slots=True)
class Said:
    """The last thing the trainer said."""

    text: str
    tone: Tone = ""


class Speaker(Protocol):
    """Has what was said last."""

    said: Said


S = TypeVar("S", bound=Speaker)
P = ParamSpec("P")


def says(action: Callable[Concatenate[S, P], Said]) -> Callable[Concatenate[S, P], Said]:
    """Let the sentence that an action returns be what its first argument said last."""

    @wraps(action)
    def act(speaker: S, /, *args: P.args, **named: P.kwargs) -> Said:
        said = action(speaker, *args, **named)
        speaker.said = said
        return said

    return act
