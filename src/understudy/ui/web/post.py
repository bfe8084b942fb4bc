"""The post: the library as a zip over HTTP, out for whoever may look on, and in for who directs."""

from __future__ import annotations

from collections.abc import Callable
from secrets import compare_digest
from typing import Literal, TypeAlias, get_args

from starlette.concurrency import run_in_threadpool
from starlette.requests import HTTPConnection, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from understudy.errors import SessionError, UnderstudyError
from understudy.model.library import Library, Taught
from understudy.storage.atomic import failing
from understudy.storage.document import encode
from understudy.storage.filenames import stem
from understudy.storage.library_folder import save
from understudy.ui.controller.status import Said
from understudy.ui.web.library_zip import MOST_PACKED, packed, unpacked
from understudy.ui.web.server import Studio
from understudy.ui.web.session_host import Stage, explained
from understudy.ui.web.views.library import Shelf

Taken: TypeAlias = Literal["refuse", "replace", "keep"]
"""What becomes of automata that the library has already, but different."""
PATH = "/library.zip"
HEADERS = {
    "Cache-Control": "no-store",
    "Content-Disposition": 'attachment; filename="library.zip"',
    "X-Content-Type-Options": "nosniff",
}


class AlreadyThere(SessionError):
    """The library has other automata of these names."""

    def __init__(self, names: list[str]) -> None:
        self.names = names
        super().__init__(
            f"the library has {', '.join(names)} already, not the same: replace what is there, or leave it"
        )


def post(studio: Studio, refusal: Callable[[HTTPConnection], str | None]) -> Route:
    """The route of a studio's library; `refusal` says why somebody may not come."""

    def not_directing(request: Request) -> str | None:
        director, key = studio.viewers.director, request.query_params.get("key", "")
        if director is None or not compare_digest(director.key.encode(), key.encode()):
            return "this page only watches: who directs may import a library"
        return None

    async def serve(request: Request) -> Response:
        problem = refusal(request)
        if problem is not None:
            return _error(403, problem)
        try:
            if request.method == "POST":
                return await take(request)
            content = await run_in_threadpool(packed, studio.stage.shelf.folder)
            return Response(content, media_type="application/zip", headers=HEADERS)
        except AlreadyThere as error:
            return JSONResponse({"error": str(error), "taken": error.names}, status_code=409)
        except Exception as error:
            return _error(400 if isinstance(error, UnderstudyError) else 500, explained(error))

    async def take(request: Request) -> Response:
        taken = request.query_params.get("taken", "refuse")
        if taken not in get_args(Taken):
            return _error(400, f"taken is {taken[:20]!r}: give one of {', '.join(get_args(Taken))}")
        problem = not_directing(request)
        if problem is not None:
            return _error(403, problem)
        content = bytearray()
        async for chunk in request.stream():
            content += chunk
            if len(content) > MOST_PACKED:
                return _error(
                    413, f"the zip is larger than {MOST_PACKED // 2**20} MB: give several smaller ones"
                )
        library = await run_in_threadpool(unpacked, bytes(content), studio.stage.kit)
        problem = not_directing(request)  # it took a while
        if problem is not None:
            return _error(403, problem)
        said = take_in(studio.stage, library, taken)
        studio.show()
        return JSONResponse({"said": said})

    return Route(PATH, serve, methods=["GET", "POST"])


def _error(status: int, problem: str) -> Response:
    return JSONResponse({"error": problem}, status_code=status)


def take_in(stage: Stage, given: Library, taken: str) -> str:
    """Save automata into the library, all or none; what came of it in a sentence."""
    stage.look()
    here = stage.shelf
    different = [name for name, taught in given.taught.items() if _taken(here, taught)]
    if different and taken == "refuse":
        raise AlreadyThere(different)
    desk = stage.desk
    if desk is not None and desk.name in different and taken == "replace":
        raise SessionError(f"{desk.name} is being trained: open another before it is replaced")
    wanted = [name for name in given.taught if taken == "replace" or name not in different]
    library = here.library
    for name in wanted:
        library = library.with_taught(given.taught[name])  # refuses one that would contain itself
    new = [name for name in wanted if name not in here.library.taught]
    for name in wanted:
        save(here.folder, given.taught[name])
    stage.look()
    replaced = [name for name in different if name in wanted]
    said = f"Imported {', '.join(new)}" if new else "Nothing new was in it"
    said += f"; replaced {', '.join(replaced)}, former versions are kept" if replaced else ""
    stage.said = Said(said, "recorded")
    return said


def _taken(shelf: Shelf, taught: Taught) -> bool:
    """Whether the library has another automaton of this name; SessionError where it has one of a name like it."""
    name = taught.automaton.name
    if name in shelf.library.taught or name in shelf.problems:
        path = shelf.folder / f"{stem(name)}.json"
        with failing(path, "reading"):
            return path.read_bytes() != encode(taught)
    shelf.refuse_taken(name, remedy="rename one of the two")
    return False
