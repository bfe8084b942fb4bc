"""Access to the studio: the address it listens on, which connections it accepts, and routes that refuse others."""

from __future__ import annotations

import errno
import ipaddress
import socket
from collections.abc import Awaitable, Callable, Collection, Sequence
from dataclasses import dataclass
from secrets import compare_digest, token_urlsafe
from urllib.parse import urlsplit

from starlette.requests import HTTPConnection, Request
from starlette.responses import Response
from starlette.routing import Route

from understudy.errors import SettingError
from understudy.ui.web.file_requests import FRESH, FileReply, FileRequest, RequestRefused, answer_safely

LOOPBACK = ("127.0.0.1", "localhost", "::1")
PORT = 8437
TRIES = 100
EVERYWHERE = ("0.0.0.0", "::")
"""All addresses of this machine; a link to it says its name."""


@dataclass(frozen=True)
class ListenAddress:
    """The address the studio listens on; `token` is required of browsers, None on the loopback address."""

    listener: socket.socket
    host: str
    token: str | None

    @property
    def port(self) -> int:
        """The port in use, which may differ from the requested one."""
        port: int = self.listener.getsockname()[1]
        return port

    @property
    def link(self) -> str:
        """The link to open in a browser."""
        host = socket.gethostname() if self.host in EVERYWHERE else self.host
        host = f"[{host}]" if ":" in host else host
        return f"http://{host}:{self.port}/" + (f"?token={self.token}" if self.token else "")

    @property
    def hosts(self) -> Collection[str] | None:
        """The host names by which browsers may connect; None: any, where a token is required."""
        return LOOPBACK if is_loopback(self.host) else None


def is_loopback(host: str) -> bool:
    """Return whether only this machine can reach an address."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def listen(host: str, port: int, token: str | None) -> ListenAddress:
    """Listen on a port or the next free one; an address that other machines can reach gets a token if none is given."""
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
    return error.errno in (errno.EADDRINUSE, errno.EACCES)


def _wrong(setting: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where="understudy studio", setting=setting, problem=problem, remedy=remedy)


def find_connection_problem(
    caller: HTTPConnection, token: str | None, hosts: Collection[str] | None
) -> str | None:
    """Return why a caller may not connect, or None.

    Refused are pages of another site, calls by a name that is not in `hosts` (None: any name will do), and calls
    without `token` (None: none is asked for).
    """
    host = caller.headers.get("host", "")
    if hosts is not None and (urlsplit(f"//{host}").hostname or "") not in hosts:
        return "this is not a host name of the studio"
    origin = caller.headers.get("origin")
    if origin is not None and urlsplit(origin).netloc != host:
        return "a page of another site may not connect"
    sent_token = caller.query_params.get("token", "")
    if token is not None and not compare_digest(sent_token.encode(), token.encode()):
        return "the token is missing or wrong: open the link that the studio printed"
    return None


def make_guarded_route(
    path: str,
    serve: Callable[[FileRequest], Awaitable[FileReply]],
    find_problem: Callable[[HTTPConnection], str | None],
    *,
    methods: Sequence[str] = ("GET",),
) -> Route:
    """Make a route whose errors are answered as `{"error": sentence}`.

    `find_problem` returns why a caller may not connect, or None.
    """

    async def answer(request: Request) -> Response:
        async def guarded() -> FileReply:
            problem = find_problem(request)
            if problem is not None:
                raise RequestRefused(403, problem)
            sends = request.method == "POST"
            return await serve(FileRequest(sends, request.query_params.multi_items(), request.stream()))

        reply = await answer_safely(guarded)
        headers = FRESH | dict(reply.headers)
        return Response(reply.content, status_code=reply.status, media_type=reply.media_type, headers=headers)

    return Route(path, answer, methods=list(methods))
