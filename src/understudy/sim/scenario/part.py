"""What all parts of a scenario, or of a robot's file, have in common."""

from __future__ import annotations

from msgspec import Struct


class Part(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True):
    """What all parts of a scenario, or of a robot's file, have in common: frozen, keys by name, no unknown key."""
