"""The review of a recording as a web application: the page, and the requests that it sends."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from threading import Lock

import msgspec
import numpy as np
import uvicorn
from numpy.typing import NDArray
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from understudy.errors import UnderstudyError
from understudy.ui.controller.recording_review import RecordingReview
from understudy.ui.controller.status import describe_error
from understudy.ui.web.access import LOOPBACK, ListenAddress, find_connection_problem, is_loopback
from understudy.ui.web.app import HEADERS, NOT_BUILT, STATIC
from understudy.ui.web.messages.drive_review import AnyReviewRequest, LearnFromLabels, SaveLearned, SetLabel
from understudy.ui.web.views.drive_review import describe_review, describe_series

REVIEW_PATH, SERIES_PATH = "/review", "/series"
MOST_BYTES = 64 * 1024
_encode = msgspec.json.Encoder().encode
_read = msgspec.json.Decoder(AnyReviewRequest).decode


def make_recording_app(
    review: RecordingReview,
    *,
    places: NDArray[np.float64] | None = None,
    token: str | None = None,
    hosts: Collection[str] | None = LOOPBACK,
    static: Path = STATIC,
) -> Starlette:
    """Return the web application in which a recording is reviewed.

    Parameters
    ----------
    review
        The drive.
    places
        Where the robot was at each tick [T, 2], m, if that is known.
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
    lock = Lock()

    async def page(_: Request) -> Response:
        index = static / "recording.html"
        if not index.is_file():
            return PlainTextResponse(NOT_BUILT, status_code=503)
        return FileResponse(index, headers=HEADERS)

    async def series(request: Request) -> Response:
        problem = find_connection_problem(request, token, hosts)
        if problem is not None:
            return _answer({"error": problem}, 403)
        return _answer(describe_series(review, places))

    async def show(request: Request) -> Response:
        problem = find_connection_problem(request, token, hosts)
        if problem is not None:
            return _answer({"error": problem}, 403)
        content = b""
        if request.method == "POST":
            async for chunk in request.stream():
                content += chunk
                if len(content) > MOST_BYTES:
                    return _answer({"error": "the request is too long"}, 413)
        return await run_in_threadpool(answer, content)

    def answer(content: bytes) -> Response:
        """Do what a request asks for, if it has any content, and return the review as it stands then."""
        with lock:
            try:
                if content:
                    carry_out(review, _read(content))
                return _answer(describe_review(review))
            except (UnderstudyError, msgspec.DecodeError) as error:
                return _answer({"error": describe_error(error)}, 400)

    routes = [
        Route("/", page),
        Route(REVIEW_PATH, show, methods=["GET", "POST"]),
        Route(SERIES_PATH, series),
        Mount("/", StaticFiles(directory=static, check_dir=False)),
    ]
    return Starlette(routes=routes)


def carry_out(review: RecordingReview, request: AnyReviewRequest) -> None:
    """Carry out a request of the page."""
    match request:
        case SetLabel(first=first, end=end, label=label):
            review.set_label(first, end, label)
        case LearnFromLabels():
            review.learn()
        case SaveLearned(name=name):
            review.save(name)
        case _:
            review.undo()


def _answer(data: object, status: int = 200) -> Response:
    headers = {"Cache-Control": "no-store", "X-Content-Type-Options": "nosniff"}
    return Response(_encode(data), status_code=status, media_type="application/json", headers=headers)


def serve_recording(
    review: RecordingReview,
    address: ListenAddress,
    *,
    places: NDArray[np.float64] | None = None,
    ready: Callable[[], None] = lambda: None,
) -> None:
    """Serve the review until a signal ends it.

    Parameters
    ----------
    review
        The drive.
    address
        The address to listen on.
    places
        Where the robot was at each tick [T, 2], m, if that is known.
    ready
        Called when pages are served.
    """
    hosts = LOOPBACK if is_loopback(address.host) else None
    app = make_recording_app(review, places=places, token=address.token, hosts=hosts)
    config = uvicorn.Config(app, log_level="warning", access_log=False, timeout_graceful_shutdown=2)
    ready()
    uvicorn.Server(config).run(sockets=[address.listener])
