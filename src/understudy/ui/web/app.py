"""The studio as a web application: the page, its files, and the WebSocket."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Collection, Coroutine
from contextlib import AbstractAsyncContextManager, asynccontextmanager, suppress
from functools import partial
from pathlib import Path

import uvicorn
from starlette.applications import Starlette
from starlette.requests import HTTPConnection, Request
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket

from understudy.ui.web import export_zip, library_zip
from understudy.ui.web.access import LOOPBACK, ListenAddress, find_connection_problem, make_guarded_route
from understudy.ui.web.camera_route import make_camera_route
from understudy.ui.web.server import StudioServer
from understudy.ui.web.sockets import serve_studio

STATIC = Path(__file__).parent / "static"
NOT_BUILT = "The studio's page is not built: run make page, then load this again.\n"
REFUSED = 4403
"""The code with which a refused WebSocket is closed."""
MOST_PAGES = 100
MOST_FRAME = 256 * 1024
"""Bytes of one message of a page after which the connection is closed; one that is only too long gets an answer."""
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
    """Return the web application of a studio.

    `hosts` are the accepted host names (None: any); `token` is the required token (None: none is required).
    """

    async def socket(websocket: WebSocket) -> None:
        await websocket.accept()
        problem = find_connection_problem(websocket, token, hosts)
        if problem is None and len(studio.viewers) >= MOST_PAGES:
            problem = f"{MOST_PAGES} pages are open already: close one of them"
        if problem is not None:
            await websocket.close(REFUSED, problem)
            return
        await serve_studio(studio, websocket)

    def refusal(request: HTTPConnection) -> str | None:
        return find_connection_problem(request, token, hosts)

    library = make_guarded_route(
        library_zip.PATH, partial(library_zip.transfer_library, studio), refusal, methods=["GET", "POST"]
    )
    export = make_guarded_route(
        export_zip.PATH, partial(export_zip.export_as_zip, studio.host), refusal, methods=["POST"]
    )
    camera = make_camera_route(studio.host, refusal)
    page = make_page_route(static, "index.html")
    routes = [page, WebSocketRoute("/ws", socket), library, export, camera, make_file_mount(static)]
    return Starlette(routes=routes, lifespan=run_clockwork(studio.run))


def make_page_route(static: Path, name: str) -> Route:
    """Make the route of a page, which is a file in the folder of the built pages."""

    async def page(_: Request) -> Response:
        index = static / name
        if not index.is_file():
            return PlainTextResponse(NOT_BUILT, status_code=503)
        return FileResponse(index, headers=HEADERS)

    return Route("/", page)


def make_file_mount(static: Path) -> Mount:
    """Make the route of the files that pages load; it must come last."""
    return Mount("/", StaticFiles(directory=static, check_dir=False))


def run_clockwork(
    run: Callable[[], Coroutine[None, None, None]],
) -> Callable[[Starlette], AbstractAsyncContextManager[None]]:
    """Return the lifespan of an application during which a server runs; it is cancelled at the end."""

    @asynccontextmanager
    async def life(_: Starlette) -> AsyncIterator[None]:
        clockwork = asyncio.create_task(run())
        try:
            yield
        finally:
            clockwork.cancel()
            with suppress(asyncio.CancelledError):
                await clockwork

    return life


def serve_app(app: Starlette, address: ListenAddress, *, ready: Callable[[], None]) -> None:
    """Serve an application until a signal ends it; `ready` is called when pages are served."""
    config = uvicorn.Config(
        app,
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


def serve(studio: StudioServer, address: ListenAddress, *, ready: Callable[[], None] = lambda: None) -> None:
    """Serve the studio until a signal ends it; the journal is complete then."""
    app = make_app(studio, token=address.token, hosts=address.hosts)
    serve_app(app, address, ready=ready)
