"""Pages of a studio that runs in simulated time: one event loop, no sockets, and every run is the same."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Generator
from contextlib import asynccontextmanager
from itertools import count
from typing import Any

from starlette.websockets import WebSocketState

from understudy.ui.web.server import StudioServer
from understudy.ui.web.sockets import serve_studio

LONGEST_S = 60.0
"""How long a test may take, which fails if a page is never answered."""


class Turn:
    """Awaited, it lets the other tasks of the event loop run once."""

    def __await__(self) -> Generator[None, None, None]:
        yield


class SimulatedTime:
    """The clock of a server: time passes while it waits for its next frame, and a little at each look."""

    def __init__(self, glance: float = 0.0) -> None:
        self.now, self.frames, self._glance = 0.0, 0, glance

    def __call__(self) -> float:
        self.now += self._glance
        return self.now

    async def wait(self, seconds: float) -> None:
        """Let time pass, and the other tasks run."""
        self.now += seconds
        self.frames += 1
        await Turn()


class PageSocket:
    """The WebSocket of a page as a server sees it, with queues in place of a network; it may stop reading."""

    def __init__(self) -> None:
        self.query_params: dict[str, str] = {}
        self.application_state = WebSocketState.CONNECTED
        self.said: asyncio.Queue[dict[str, str]] = asyncio.Queue()
        self.heard: asyncio.Queue[str | bytes] = asyncio.Queue()
        self.reads = asyncio.Event()
        self.reads.set()

    async def receive(self) -> dict[str, str]:
        return await self.said.get()

    async def send_text(self, text: str) -> None:
        await self._send(text)

    async def send_bytes(self, data: bytes) -> None:
        await self._send(data)

    async def _send(self, content: str | bytes) -> None:
        await self.reads.wait()
        self.heard.put_nowait(content)

    async def close(self, code: int = 1000) -> None:
        self.application_state = WebSocketState.DISCONNECTED


class SimulatedPage:
    """A page that says things to a server, and counts the frames that it hears."""

    def __init__(self, time: SimulatedTime) -> None:
        self.socket, self.frames, self._time = PageSocket(), 0, time
        self._numbers = count(1)

    async def say(self, do: str, **fields: Any) -> tuple[dict[str, Any], int]:
        """Say something that must work; return the answer, and in how many frames of the server it came."""
        number, before = next(self._numbers), self._time.frames
        self.socket.said.put_nowait(
            {"type": "websocket.receive", "text": json.dumps({"id": number, "do": do, **fields})}
        )
        while True:
            answer = await self.hear()
            if answer.get("re") == number:
                assert answer.get("ok"), answer
                return answer, self._time.frames - before

    async def hear(self) -> dict[str, Any]:
        """Hear the next message; it is empty for a frame."""
        heard = await self.socket.heard.get()
        if isinstance(heard, bytes):
            self.frames += 1
            return {}
        message: dict[str, Any] = json.loads(heard)
        return message

    async def hear_frame(self) -> None:
        """Hear messages up to the next frame."""
        before = self.frames
        while self.frames == before:
            await self.hear()


@asynccontextmanager
async def connect_pages(server: StudioServer, *pages: SimulatedPage) -> AsyncIterator[None]:
    """Run a server, and connect pages, of which the first gets control."""
    tasks = [asyncio.ensure_future(server.run())]
    for each in pages:
        socket: Any = each.socket
        tasks.append(asyncio.ensure_future(serve_studio(server, socket)))
        await Turn()
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
