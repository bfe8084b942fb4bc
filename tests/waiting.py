"""Waiting for a state, in tests of what other threads and processes do."""

from __future__ import annotations

import time
from collections.abc import Callable

BOUND_S = 60.0
"""The time after which a state counts as never reached, s: longer than the busiest machine takes."""


def wait_until(
    reached: Callable[[], object], *, meanwhile: Callable[[], object] = lambda: None, bound_s: float = BOUND_S
) -> None:
    """Return once a state is reached, which is looked at again and again; `meanwhile` is called before each look."""
    until = time.monotonic() + bound_s
    meanwhile()
    while not reached():
        if time.monotonic() > until:
            raise TimeoutError(f"a state was not reached within {bound_s:g} s")
        time.sleep(0.005)
        meanwhile()
