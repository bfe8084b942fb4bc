"""The studio in its page: what is acknowledged is kept, it is found again, and a second page only reads."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Coroutine, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest
from tests.make.studios import GOTO, Wall

from understudy.ui.web.page_studio import PageStudio
from understudy.ui.web.session_host import SessionHost

CLOSED = "the studio is open in another tab"


class Kept:
    """A page whose files are kept as they are when asked for, unless there is a problem."""

    def __init__(self, root: Path, *, closed: str = "") -> None:
        self.root, self.files, self.problem = root, dict[str, bytes](), ""
        self.events: list[str] = []
        self.texts: list[dict[str, Any]] = []
        self.presses: list[str] = []
        self.studio = PageStudio(root, self.post, self.keep, closed=closed, wall=Wall(glance=0.01))

    def post(self, content: str | bytes) -> None:
        if isinstance(content, str):
            self.texts.append(json.loads(content))
            if "re" in self.texts[-1]:
                self.events.append("answer")

    async def keep(self) -> str:
        await asyncio.sleep(0)
        self.events.append("kept")
        if not self.problem:
            self.files = {
                str(path.relative_to(self.root)): path.read_bytes()
                for path in self.root.rglob("*")
                if path.is_file()
            }
        return self.problem

    async def ask(self, number: int, **message: Any) -> dict[str, Any]:
        self.studio.hear(json.dumps({"id": number, **message}))
        while True:
            for each in self.texts:
                if each.get("re") == number:
                    return each
            await asyncio.sleep(0)

    async def run(self, work: Coroutine[Any, Any, None]) -> None:
        running = asyncio.ensure_future(self.studio.run())
        await work
        self.presses = list_presses(self)
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)


def list_presses(page: Kept) -> list[str]:
    trainer = page.studio.studio.host.trainer
    return [] if trainer is None else [each.next for each in trainer.session.examples if each.is_from_press]


@pytest.fixture(autouse=True)
def close_studios(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Close the studios whose pages are not run."""
    begun = list[SessionHost]()
    enter = SessionHost.replace_session

    def note(host: SessionHost, *args: Any) -> None:
        begun.append(host)
        enter(host, *args)

    monkeypatch.setattr(SessionHost, "replace_session", note)
    yield
    for host in begun:
        host.close()


async def teach(page: Kept) -> None:
    assert "error" not in await page.ask(1, **{**GOTO, "live": True})
    for number, state in enumerate(("forward", "rotate_left", "forward"), 2):
        page.events.clear()
        assert "error" not in await page.ask(number, do="press", state=state)
        assert page.events[:2] == ["kept", "answer"]
        journals = [content for name, content in page.files.items() if name.endswith(".journal")]
        assert len(journals) == 1
        assert journals == [path.read_bytes() for path in page.root.rglob("*.journal")]


def restore(files: dict[str, bytes], root: Path) -> Path:
    for name, content in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_bytes(content)
    return root


def test_a_press_is_kept_before_it_is_acknowledged_and_found_again(tmp_path: Path) -> None:
    first = Kept(tmp_path / "first")
    asyncio.run(first.run(teach(first)))
    again = Kept(restore(first.files, tmp_path / "again"))
    trainer = again.studio.studio.host.active_trainer
    assert trainer.name == "goto"
    assert list_presses(again) == first.presses != []
    assert not again.studio.studio.host.paused


def test_world_seed_and_library_are_found_again(tmp_path: Path) -> None:
    async def go(page: Kept) -> None:
        messages: list[dict[str, Any]] = [
            {"do": "open_world", "name": "arena"},
            {"do": "reset", "seed": 7},
            {"do": "open_library", "name": "two"},
        ]
        for number, message in enumerate(messages):
            assert "error" not in await page.ask(number, **message)

    first = Kept(tmp_path / "first")
    asyncio.run(first.run(go(first)))
    host = Kept(restore(first.files, tmp_path / "again")).studio.studio.host
    assert (host.scenario.name, host.seed, host.folder.name) == ("arena", 7, "two")


@pytest.mark.parametrize("content", [b"", b"[]", b"{", b'{"world": "nowhere", "seed": 3, "library": "../x"}'])
def test_a_place_that_is_none_is_not_taken_up(content: bytes, tmp_path: Path) -> None:
    host = Kept(restore({".place.json": content}, tmp_path)).studio.studio.host
    assert (host.scenario.name, host.folder.name, host.trainer) == ("forage", "library", None)


def test_what_cannot_be_kept_is_not_acknowledged(tmp_path: Path) -> None:
    async def fill(page: Kept) -> None:
        await page.ask(1, **GOTO)
        page.problem = "the browser's storage is full"
        assert await page.ask(2, do="press", state="forward") == {"re": 2, "error": page.problem}
        reply = await page.studio.fetch("/library.zip", sends=True, query=[], content=b"")
        assert (reply.status, json.loads(reply.content)) == (507, {"error": page.problem})
        page.problem = ""
        assert "error" not in await page.ask(3, do="press", state="forward")

    page = Kept(tmp_path)
    asyncio.run(page.run(fill(page)))


def test_a_second_page_only_reads(tmp_path: Path) -> None:
    async def look(page: Kept) -> None:
        assert await page.ask(1, **GOTO) == {"re": 1, "error": CLOSED}
        assert await page.ask(2, do="take_control") == {"re": 2, "error": CLOSED}
        assert page.texts[0]["closed"] == CLOSED
        assert not page.texts[0]["has_control"]

    first = Kept(tmp_path / "first")
    asyncio.run(first.run(teach(first)))
    second = Kept(restore(first.files, tmp_path / "second"), closed=CLOSED)
    before = {path: path.read_bytes() for path in second.root.rglob("*") if path.is_file()}
    asyncio.run(second.run(look(second)))
    assert second.events == ["answer", "answer"]
    assert {path: path.read_bytes() for path in second.root.rglob("*") if path.is_file()} == before


def test_files_come_and_go_without_routes(tmp_path: Path) -> None:
    async def carry(page: Kept) -> None:
        await teach(page)
        assert "error" not in await page.ask(9, do="save")
        library = await page.studio.fetch("/library.zip", sends=False, query=[])
        assert library.headers["Content-Type"] == "application/zip"
        with ZipFile(BytesIO(library.content)) as archive:
            assert archive.namelist() == ["goto.json"]
        query = [("name", "goto"), ("to", "python"), ("bind", "A=station")]
        export = await page.studio.fetch("/export.zip", sends=True, query=query)
        assert export.status == 200
        assert (await page.studio.fetch("/camera/0.jpg", sends=False, query=[])).status == 404
        other = Kept(tmp_path / "other")
        reply = await other.studio.fetch("/library.zip", sends=True, query=[], content=library.content)
        assert json.loads(reply.content) == {"message": "Imported goto"}
        assert "library/goto.json" in other.files

    page = Kept(tmp_path / "first")
    asyncio.run(page.run(carry(page)))
