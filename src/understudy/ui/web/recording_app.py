"""The review of a recording as a web application: the page, and the requests that it sends."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from threading import Lock
from typing import NamedTuple, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import HTTPConnection
from starlette.routing import BaseRoute

from understudy.ui.controller.recording_review import RecordingReview
from understudy.ui.controller.status import describe_error
from understudy.ui.web.access import (
    LOOPBACK,
    ListenAddress,
    find_connection_problem,
    make_guarded_route,
)
from understudy.ui.web.app import STATIC, make_file_mount, make_page_route, serve_app
from understudy.ui.web.file_requests import FileReply, FileRequest, RequestRefused, answer_json
from understudy.ui.web.messages.drive import (
    AnyReviewRequest,
    DefineBehavior,
    LearnFromLabels,
    SaveLearned,
    SetLabel,
    SettleContradiction,
    SplitLabel,
    TrustDriver,
)
from understudy.ui.web.views.drive_review import describe_review, describe_series

REVIEW_PATH, SERIES_PATH = "/review", "/series"
MOST_BYTES = 64 * 1024
_read = msgspec.json.Decoder(AnyReviewRequest).decode


class ReviewSource(Protocol):
    """Where the review that a page shows comes from."""

    def find_review(self) -> RecordingReview:
        """Return the review; SessionError if there is none yet."""
        ...

    def list_places(self) -> NDArray[np.float64] | None:
        """List where the robot was at each tick of the review [T, 2], m; None if that is not known."""
        ...

    def check_change(self) -> None:
        """Raise SessionError if the review must not be changed now."""
        ...


class _Recording(NamedTuple):
    """A recording as the source of its review."""

    review: RecordingReview
    places: NDArray[np.float64] | None

    def find_review(self) -> RecordingReview:
        return self.review

    def list_places(self) -> NDArray[np.float64] | None:
        return self.places

    def check_change(self) -> None:
        """Allow every change."""


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

    def refuse(caller: HTTPConnection) -> str | None:
        return find_connection_problem(caller, token, hosts)

    routes = make_review_routes(_Recording(review, places), refuse)
    return Starlette(routes=[make_page_route(static, "recording.html"), *routes, make_file_mount(static)])


def make_review_routes(
    source: ReviewSource, refuse: Callable[[HTTPConnection], str | None], *, lock: Lock | None = None
) -> list[BaseRoute]:
    """Make the routes by which a page shows and changes a review.

    `refuse` returns why a caller may not connect, or None. The lock is held while the review is read or changed.
    """
    lock = lock or Lock()

    async def series(_: FileRequest) -> FileReply:
        return await run_in_threadpool(list_series)

    def list_series() -> FileReply:
        with lock:
            return answer_json(describe_series(source.find_review(), source.list_places()))

    async def show(request: FileRequest) -> FileReply:
        content = await request.read(MOST_BYTES, "the request is too long")
        return await run_in_threadpool(answer, content)

    def answer(content: bytes) -> FileReply:
        """Do what a request asks for, if it has any content, and return the review as it stands then."""
        with lock:
            if content:
                source.check_change()
            review = source.find_review()
            if content:
                try:
                    request = _read(content)
                except msgspec.DecodeError as error:
                    raise RequestRefused(400, describe_error(error)) from None
                carry_out(review, request)
            return answer_json(describe_review(review))

    return [
        make_guarded_route(REVIEW_PATH, show, refuse, methods=["GET", "POST"]),
        make_guarded_route(SERIES_PATH, series, refuse),
    ]


def carry_out(review: RecordingReview, request: AnyReviewRequest) -> None:
    """Carry out a request of the page."""
    match request:
        case SetLabel(first=first, end=end, label=label):
            review.set_label(first, end, label)
        case DefineBehavior(name=name, command=command):
            review.define_behavior(name, command)
        case SplitLabel(state=state, entered_from=entered_from):
            review.split_state(state, entered_from)
        case SettleContradiction(contradiction=index, trust=trust):
            review.settle_contradiction(index, trust)
        case TrustDriver(driver=driver):
            review.trust_driver(driver)
        case LearnFromLabels():
            review.learn()
        case SaveLearned(name=name):
            review.save(name)
        case _:
            review.undo()


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
    app = make_recording_app(review, places=places, token=address.token, hosts=address.hosts)
    serve_app(app, address, ready=ready)
