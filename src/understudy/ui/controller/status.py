"""What the trainer says."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Said:
    """The last thing the trainer said; `tone` is "", "recorded", "correction" or "error"."""

    text: str
    tone: str = ""
