"""The WebSockets of pages: messages are heard for a server, and what it has queued for a page is sent."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from contextlib import suppress

from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from understudy.ui.web.clients import Client
from understudy.ui.web.drive_server import DriveServer
from understudy.ui.web.server import StudioServer

TAKEN = 4409
"""The code with which the connection of a page is closed when another page drives."""


async def serve_studio(studio: StudioServer, websocket: WebSocket) -> None:
    """Exchange messages with a page of the studio until it disconnects."""
    viewer = studio.connect(websocket.query_params.get("key"))

    def hear(received: str | bytes) -> None:
        studio.handle_text(viewer, received)

    hearing = _hear_all(viewer, websocket, hear)
    try:
        await exchange_messages(viewer, websocket, hearing, leave=lambda: studio.disconnect(viewer))
    finally:
        await close_socket(websocket)


async def serve_driver(server: DriveServer, websocket: WebSocket) -> None:
    """Exchange messages with a page that drives until it disconnects, or until another page comes."""
    page = server.connect()

    def hear(received: str | bytes) -> None:
        server.hear(page, received)

    hearing = _hear_all(page, websocket, hear)
    try:
        await exchange_messages(page, websocket, hearing, leave=lambda: server.disconnect(page))
    finally:
        await close_socket(websocket, TAKEN if server.is_driven else 1000)


async def _hear_all(client: Client, websocket: WebSocket, hear: Callable[[str | bytes], None]) -> None:
    while not client.closing:
        received = await websocket.receive()
        if received["type"] == "websocket.disconnect":
            return
        text = received.get("text")
        hear(text if text is not None else received.get("bytes") or b"")
        await asyncio.sleep(0)  # a page that sends without pause keeps nobody else waiting


async def exchange_messages(
    client: Client,
    websocket: WebSocket,
    hearing: Coroutine[None, None, None],
    *,
    leave: Callable[[], None],
) -> None:
    """Send a page what is queued for it while its messages are heard, until either ends; then call `leave`."""
    tasks = [asyncio.create_task(send_queued(client, websocket)), asyncio.create_task(hearing)]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        leave()
        for task in tasks:
            task.cancel()
            with suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError, OSError):
                await task


async def close_socket(websocket: WebSocket, code: int = 1000) -> None:
    """Close the connection of a page, if it is still there."""
    if websocket.application_state is WebSocketState.CONNECTED:
        with suppress(RuntimeError, WebSocketDisconnect, OSError):
            await websocket.close(code)


async def send_queued(viewer: Client, websocket: WebSocket) -> None:
    """Send a page what is queued for it, until it is closed."""
    while not viewer.closing:
        await viewer.waits.wait()
        viewer.waits.clear()
        while (waiting := viewer.next()) is not None:
            sent, binary = waiting
            if binary:
                await websocket.send_bytes(sent)
            else:
                await websocket.send_text(sent.decode())
