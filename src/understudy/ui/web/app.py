"""The studio as a web application: page, WebSocket, and the address it listens on."""

from __future__ import annotations

import asyncio
import ipaddress
import socket
from collections.abc import AsyncIterator, Callable, Collection
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from secrets import token_urlsafe

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket

from understudy.errors import SettingError
from understudy.ui.web.actions.camera import make_camera_route
from understudy.ui.web.library_zip import make_library_route
from understudy.ui.web.server import StudioServer, find_connection_problem

STATIC = Path(__file__).parent / "static"
NOT_BUILT = "The studio's page is not built: run make page, then load this again.\n"
REFUSED = 4403
"""The code a socket is closed with that may not connect."""
MOST_PAGES = 100
LOOPBACK = ("127.0.0.1", "localhost", "::1")
HEADERS = {
    "Cache-Control": "no-cache",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}


def make_app(
    studio: StudioServer,
    *,
    token: str | None = None,
    hosts: Collection[str] | None = LOOPBACK,
    static: Path = STATIC,
) -> Starlette:
    """The application of a studio. `hosts` are the names it may be called by (None: any), `token` what it asks for."""

    async def page(_: Request) -> Response:
        index = static / "index.html"
        if not index.is_file():
            return PlainTextResponse(NOT_BUILT, status_code=503)
        return FileResponse(index, headers=HEADERS)

    async def socket(websocket: WebSocket) -> None:
        await websocket.accept()
        problem = find_connection_problem(websocket, token, hosts)
        if problem is None and len(studio.viewers) >= MOST_PAGES:
            problem = f"{MOST_PAGES} pages look on already: close one of them"
        if problem is not None:
            await websocket.close(REFUSED, problem)
            return
        await studio.serve(websocket)

    @asynccontextmanager
    async def life(_: Starlette) -> AsyncIterator[None]:
        clockwork = asyncio.create_task(studio.run())
        try:
            yield
        finally:
            clockwork.cancel()
            with suppress(asyncio.CancelledError):
                await clockwork

    files = StaticFiles(directory=static, check_dir=False)
    library = make_library_route(studio, lambda request: find_connection_problem(request, token, hosts))
    camera = make_camera_route(studio.host, lambda request: find_connection_problem(request, token, hosts))
    routes = [Route("/", page), WebSocketRoute("/ws", socket), library, camera, Mount("/", files)]
    return Starlette(routes=routes, lifespan=life)


PORT = 8437
TRIES = 100
EVERYWHERE = ("0.0.0.0", "::")
"""All addresses of this machine; a link to it says its name."""
MOST_FRAME = 256 * 1024
"""Bytes of one message of a page after which the line is cut; what is only too long is answered."""


@dataclass(frozen=True)
class ListenAddress:
    """Where the studio listens; `token` is what it asks for, None on this machine's own address."""

    listener: socket.socket
    host: str
    token: str | None

    @property
    def port(self) -> int:
        """The port, which may be another than was asked for."""
        port: int = self.listener.getsockname()[1]
        return port

    @property
    def link(self) -> str:
        """What to open in a browser."""
        host = socket.gethostname() if self.host in EVERYWHERE else self.host
        host = f"[{host}]" if ":" in host else host
        return f"http://{host}:{self.port}/" + (f"?token={self.token}" if self.token else "")


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach an address."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def listen(host: str, port: int, token: str | None) -> ListenAddress:
    """Take the port, or the next free one; other machines need a token."""
    if not token:
        token = None if is_loopback(host) else token_urlsafe(18)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for each in range(port, min(port + TRIES, 65536)) if port else [0]:
        # That it is TCP has to be said for asyncio to send at once: otherwise answers wait for the page to
        # acknowledge what was sent before, which it may put off for 40 ms.
        listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, each))
            listener.listen(128)
        except OSError as error:
            listener.close()
            if not _taken(error):
                raise _wrong(
                    "--host", f"is {host!r}: {error.strerror or error}", "give an address"
                ) from error
        else:
            return ListenAddress(listener, host, token)
    raise _wrong("--port", f"and the {TRIES} after it are taken from {port} on", "give another")


def _taken(error: OSError) -> bool:
    import errno

    return error.errno in (errno.EADDRINUSE, errno.EACCES)


def _wrong(setting: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where="understudy studio", setting=setting, problem=problem, remedy=remedy)


def serve(studio: StudioServer, address: ListenAddress, *, ready: Callable[[], None] = lambda: None) -> None:
    """Serve until a signal ends it; then the journal is complete."""
    hosts = LOOPBACK if is_loopback(address.host) else None
    config = uvicorn.Config(
        make_app(studio, token=address.token, hosts=hosts),
        log_level="warning",
        access_log=False,
        ws_max_size=MOST_FRAME,
        ws_per_message_deflate=False,
        ws_ping_interval=5.0,
        ws_ping_timeout=10.0,
        timeout_graceful_shutdown=2,
    )
    server = uvicorn.Server(config)
    ready()
    server.run(sockets=[address.listener])
