"""The studio in a worker of its own page, without a server: the same messages, posted instead of sent.

Files are those of the worker, which are gone with it. So whoever made the studio keeps them, and an answer is posted
only when what it acknowledges is kept.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import msgspec
from msgspec import Struct

from understudy.clock import REAL_TIME
from understudy.errors import UnderstudyError
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.storage.json_text import encode_json
from understudy.ui.controller.beside import make_immediate
from understudy.ui.controller.status import StatusMessage, describe_error
from understudy.ui.web import export_zip, library_zip
from understudy.ui.web.actions.handler_table import HANDLERS
from understudy.ui.web.file_requests import FileReply, FileRequest, RequestRefused, answer_safely
from understudy.ui.web.messages import session as m
from understudy.ui.web.messages.base import Message
from understudy.ui.web.server import AnswerData, StudioServer
from understudy.ui.web.session_host import SessionHost

LIBRARY, PLACE = "library", ".place.json"
ANSWER = b'{"re"'
"""How the text of an answer begins."""
KEEP_S = 1.0
"""How often files are kept that changed without a request, s."""

Keep = Callable[[], Awaitable[str]]
"""A function that keeps all files, and returns why it could not; else empty."""


class TeachingPlace(Struct, frozen=True, omit_defaults=True):
    """Where a person teaches: it is taken up when the page is opened again."""

    world: str
    seed: int
    library: str
    automaton: str = ""
    """The automaton in training; empty without one."""
    paused: bool = False


class Reply(NamedTuple):
    """The reply to a request for a file: its status, headers and content."""

    status: int
    headers: dict[str, str]
    content: bytes


class PageStudio:
    """A studio and the one page that it is part of.

    Parameters
    ----------
    root
        The folder of all files that are kept: libraries, saved worlds, and where a person teaches.
    post
        Posts a message to the page: a text, or the bytes of a frame.
    keep
        Keeps the files in `root`.
    world
        The scenario at the first time.
    storage_note
        Says where the files are kept.
    closed
        Says why this page must not change anything; empty if it may.
    wall
        The clock, s.
    """

    def __init__(
        self,
        root: Path,
        post: Callable[[str | bytes], None],
        keep: Keep,
        *,
        world: str = "forage",
        storage_note: str = "",
        closed: str = "",
        wall: Callable[[], float] = REAL_TIME,
    ) -> None:
        scenario = find_scenario(world)
        host = SessionHost(
            scenario, root / LIBRARY, make_scenario_kit(scenario), wall=wall, beside=make_immediate()
        )
        self.studio = StudioServer(host, wall=wall, storage_note=storage_note, closed=closed)
        self._root, self._post, self._keep, self._closed = root, post, keep, closed
        self._place: TeachingPlace | None = None
        self._take_up()
        self.page = self.studio.connect(None)

    def hear(self, text: str) -> None:
        """Carry out a message of the page."""
        self.studio.handle_text(self.page, text)

    async def run(self) -> None:
        """Run the studio until cancelled."""
        async with asyncio.TaskGroup() as tasks:
            for each in (self.studio.run(), self._post_queued(), self._keep_often()):
                tasks.create_task(each)

    async def fetch(
        self, path: str, *, sends: bool, query: list[tuple[str, str]], content: bytes = b""
    ) -> Reply:
        """Answer a request for a file, or with one, such as for the library as a zip."""
        key = ("key", self.page.key)
        request = FileRequest(sends, [*query, key], _yield_once(content))

        async def serve() -> FileReply:
            if path == library_zip.PATH:
                return await library_zip.transfer_library(self.studio, request)
            if path == export_zip.PATH:
                return await export_zip.export_as_zip(self.studio.host, request)
            raise RequestRefused(404, f"there is no {path} here")

        reply = await answer_safely(serve)
        problem = await self._keep_all() if sends else ""
        if problem:
            reply = FileReply(encode_json({"error": problem}), status=507)
        headers = {"Content-Type": reply.media_type, **reply.headers}
        return Reply(reply.status, headers, reply.content)

    async def _post_queued(self) -> None:
        """Post what is queued for the page; answers when what they acknowledge is kept."""
        while True:
            await self.page.waits.wait()
            self.page.waits.clear()
            queued = list(self._take_queued())
            answers = any(not binary and content.startswith(ANSWER) for content, binary in queued)
            problem = await self._keep_all() if answers else ""
            for content, binary in queued:
                if binary:
                    self._post(content)
                else:
                    self._post((_refuse(content, problem) if problem else content).decode())

    def _take_queued(self) -> Iterator[tuple[bytes, bool]]:
        while (queued := self.page.next()) is not None:
            yield queued

    async def _keep_often(self) -> None:
        while True:
            await asyncio.sleep(KEEP_S)
            if problem := await self._keep_all():
                self.studio.host.status = StatusMessage(problem, "error")

    async def _keep_all(self) -> str:
        """Keep all files, and where the person teaches; return why that is not possible, else an empty text."""
        if self._closed:
            return ""
        self._note_place()
        return await self._keep()

    def _note_place(self) -> None:
        host = self.studio.host
        place = TeachingPlace(
            world=host.scenario.name,
            seed=host.seed,
            library=host.folder.name,
            automaton="" if host.trainer is None else host.trainer.name,
            paused=host.paused,
        )
        if place != self._place:
            self._place = place
            self._root.mkdir(parents=True, exist_ok=True)
            (self._root / PLACE).write_bytes(msgspec.json.encode(place))

    def _take_up(self) -> None:
        """Go where the person taught when the page was closed, and open what was in training, as far as it is there."""
        path = self._root / PLACE
        if not path.is_file():
            return
        try:
            place = msgspec.json.decode(path.read_bytes(), type=TeachingPlace)
        except msgspec.DecodeError:
            return
        messages: list[Message] = [
            m.OpenWorld(id=0, name=place.world),
            m.ResetWorld(id=0, seed=place.seed),
            m.OpenLibrary(id=0, name=place.library),
        ]
        if place.automaton and not self._closed:
            messages += [m.OpenAutomaton(id=0, name=place.automaton), m.Pause(id=0, paused=place.paused)]
        host = self.studio.host
        for each in messages:
            try:
                result = HANDLERS[type(each)](host, each)
            except UnderstudyError as error:
                host.status = StatusMessage(describe_error(error), "error")
            else:
                if isinstance(result, StatusMessage):
                    host.status = result


async def _yield_once(content: bytes) -> AsyncIterator[bytes]:
    yield content


def _refuse(answer: bytes, problem: str) -> bytes:
    """Return an answer that says why what was asked for is not kept; messages that are no answers stay as they are."""
    number = None
    if not answer.startswith(ANSWER):
        return answer
    with suppress(msgspec.DecodeError):
        number = msgspec.json.decode(answer, type=AnswerData).re
    return encode_json(AnswerData(re=number, error=problem))
