"""Call a step of a server once per frame, until it is cancelled."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TypeAlias

Wait: TypeAlias = Callable[[float], Awaitable[None]]
"""A function that lets other tasks run for some seconds, such as `asyncio.sleep`."""

FRAME_S = 1 / 60
REST_S = 0.002
"""The least pause (s) between two steps, in which messages are received."""


async def repeat_each_frame(step: Callable[[], None], *, clock: Callable[[], float], wait: Wait) -> None:
    """Call a step at most once per frame, and let other tasks run in between."""
    while True:
        began_s = clock()
        step()
        await wait(max(REST_S, FRAME_S - (clock() - began_s)))
