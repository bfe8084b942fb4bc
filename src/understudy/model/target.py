"""Targets: things in the world that a feature or behavior can refer to (paper section 3.1)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Target:
    """A thing the body can find by this name: station, nearest_food."""

    name: str
    doc: str = ""
