"""The route by which pages get the images of real robots' cameras."""

from __future__ import annotations

from collections.abc import Callable

from starlette.concurrency import run_in_threadpool
from starlette.requests import HTTPConnection, Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route

from understudy.errors import SessionError, SettingError
from understudy.ui.web.actions.camera import find_live_camera
from understudy.ui.web.session_host import SessionHost

PATH = "/camera/{robot:int}.jpg"
NUMBER = "X-Image"
"""The header that says which image it is, so that clicks can say into which they were."""


def make_camera_route(host: SessionHost, refusal: Callable[[HTTPConnection], str | None]) -> Route:
    """Return the route of the latest camera images; `refusal` returns why a connection is refused, or None."""

    async def serve(request: Request) -> Response:
        problem = refusal(request)
        if problem is not None:
            return PlainTextResponse(problem, status_code=403)
        try:
            _, camera = find_live_camera(host, request.path_params["robot"])
        except (SessionError, SettingError) as error:
            return PlainTextResponse(str(error), status_code=404)
        image = await run_in_threadpool(camera.encode_annotated_image)
        if image is None:
            return Response(status_code=204)
        number, jpeg = image
        return Response(
            jpeg, media_type="image/jpeg", headers={NUMBER: str(number), "Cache-Control": "no-store"}
        )

    return Route(PATH, serve)
