"""What the trainer says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

Tone: TypeAlias = Literal["", "recorded", "correction", "error"]


@dataclass(frozen=True, slots=True)
class Said:
    """The last thing the trainer said."""

    text: str
    tone: Tone = ""
