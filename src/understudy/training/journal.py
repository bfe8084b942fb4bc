"""The journal of a session (thin for now: the protocol)."""

from __future__ import annotations

from typing import Any, Protocol


class Journal(Protocol):
    def write(self, what: str, **fields: Any) -> None: ...
