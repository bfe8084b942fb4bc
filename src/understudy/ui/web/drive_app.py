"""The drive under way as a web application: the page, its WebSocket, and the review of what was driven."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path

from starlette.applications import Starlette
from starlette.requests import HTTPConnection
from starlette.routing import WebSocketRoute
from starlette.websockets import WebSocket

from understudy.ui.web.access import LOOPBACK, ListenAddress, find_connection_problem
from understudy.ui.web.app import (
    REFUSED,
    STATIC,
    make_file_mount,
    make_page_route,
    run_clockwork,
    serve_app,
)
from understudy.ui.web.drive_server import DriveServer
from understudy.ui.web.recording_app import make_review_routes
from understudy.ui.web.sockets import serve_driver

DRIVE_PATH = "/drive"


def make_drive_app(
    server: DriveServer,
    *,
    token: str | None = None,
    hosts: Collection[str] | None = LOOPBACK,
    static: Path = STATIC,
) -> Starlette:
    """Return the web application in which a person drives a robot.

    Parameters
    ----------
    server
        The server of the drive.
    token
        The token that pages need; None: none.
    hosts
        The accepted host names; None: any.
    static
        Folder of the built page.

    Returns
    -------
    Starlette
        The application.
    """

    def refuse(caller: HTTPConnection) -> str | None:
        return find_connection_problem(caller, token, hosts)

    async def socket(websocket: WebSocket) -> None:
        await websocket.accept()
        problem = refuse(websocket)
        if problem is not None:
            await websocket.close(REFUSED, problem)
            return
        await serve_driver(server, websocket)

    routes = [
        make_page_route(static, "driving.html"),
        *make_review_routes(server.live, refuse, lock=server.live.lock),
        WebSocketRoute(DRIVE_PATH, socket),
        make_file_mount(static),
    ]
    return Starlette(routes=routes, lifespan=run_clockwork(server.run))


def serve_drive(
    server: DriveServer, address: ListenAddress, *, ready: Callable[[], None] = lambda: None
) -> None:
    """Serve the drive until a signal ends it; it is kept then.

    Parameters
    ----------
    server
        The server of the drive.
    address
        The address to listen on.
    ready
        Called when pages are served.
    """
    app = make_drive_app(server, token=address.token, hosts=address.hosts)
    serve_app(app, address, ready=ready)
