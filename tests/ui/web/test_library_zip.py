"""The library as a zip: what goes out, what is let in, and what is refused without a trace."""

from __future__ import annotations

import json
import tracemalloc
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from threading import Event, Thread
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import pytest
from starlette.testclient import TestClient
from tests.make.studios import GOTO, HOME, Page, make_studio, open_page, serve_studio, teach
from tests.ui.web.test_library import files, names

from understudy.errors import FileError
from understudy.model.library import Kit, Library
from understudy.sim.forage import FORAGE_KIT
from understudy.storage.library_folder import list_versions
from understudy.ui.web import library_zip
from understudy.ui.web.app import make_app
from understudy.ui.web.server import StudioServer
from understudy.ui.web.views.library import save_copy

HERE = "/library.zip"


class Rig:
    """A studio with goto saved, the page that directs it, and its post."""

    def __init__(self, made: StudioServer, client: TestClient, person: Page) -> None:
        self.host, self.client, self.person = made.host, client, person
        self.key = person.hello["key"]

    def out(self) -> bytes:
        answer = self.client.get(HERE)
        assert answer.status_code == 200
        assert answer.headers["content-type"] == "application/zip"
        return bytes(answer.content)

    def give(self, data: bytes, **query: str) -> tuple[int, dict[str, Any]]:
        answer = self.client.post(HERE, content=data, params={"key": self.key, **query})
        return answer.status_code, answer.json()

    def contents(self) -> dict[str, bytes]:
        folder = self.host.library_view.folder
        return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    made = make_studio(tmp_path / "library")
    with serve_studio(made) as client, open_page(client) as person:
        person.done(**GOTO)
        teach(person, "forward")
        person.done("save")
        yield Rig(made, client, person)


def zip_members(*members: tuple[str, bytes | str]) -> bytes:
    made = BytesIO()
    with ZipFile(made, "w", ZIP_DEFLATED) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return made.getvalue()


def test_documents_go_out_and_come_in_elsewhere(rig: Rig, tmp_path: Path) -> None:
    taught = rig.host.library_view.find_automaton("goto")
    save_copy(rig.host.library_view, taught, "a/b")  # as a program may
    teach(rig.person, "rotate_left")
    rig.person.done("save")
    assert len(files(rig.host)) == 3  # one of them a former version
    parcel = rig.out()
    with ZipFile(BytesIO(parcel)) as archive:
        assert sorted(archive.namelist()) == ["a%2Fb.json", "goto.json"]
    other = make_studio(tmp_path / "other")
    with serve_studio(other) as client, open_page(client) as person:
        there = Rig(other, client, person)
        assert there.out()[:2] == b"PK"  # empty, and no folder yet
        assert there.give(parcel) == (200, {"message": "Imported a/b, goto"})
        while not person.news["library"]["trained"]:
            person.hear()
        assert person.news["message"]["text"] == "Imported a/b, goto"
        assert there.give(parcel) == (200, {"message": "The zip contains nothing new"})
    assert files(other.host) == ["a%2Fb.json", "goto.json"]
    for name in files(other.host):
        here, there_ = (each.library_view.folder / name for each in (rig.host, other.host))
        assert here.read_bytes() == there_.read_bytes()


def test_what_is_there_is_replaced_only_when_asked(rig: Rig) -> None:
    rig.person.done("duplicate", name="goto", to="extra")
    parcel = rig.out()
    rig.person.done("remove", name="extra")
    teach(rig.person, "rotate_left")
    rig.person.done("save")
    before = rig.contents()
    status, answer = rig.give(parcel)
    assert (status, answer["conflicts"]) == (409, ["goto"])
    assert "the library already has a different goto" in answer["error"]
    assert "goto is being trained" in rig.give(parcel, conflicts="replace")[1]["error"]
    assert rig.contents() == before
    assert rig.give(parcel, conflicts="keep") == (200, {"message": "Imported extra"})
    assert before.items() <= rig.contents().items()
    rig.person.done("open", name="extra")
    said = "The zip contains nothing new; replaced goto, former versions are kept"
    assert rig.give(parcel, conflicts="replace") == (200, {"message": said})
    assert rig.host.library_view.library.taught["goto"].lesson is not None
    assert [each.number for each in list_versions(rig.host.library_view.folder, "goto")] == [1, 2]


def document(rig: Rig, **automaton: str) -> str:
    found = json.loads((rig.host.library_view.folder / "goto.json").read_text())
    found["automaton"].update(automaton)
    return json.dumps(found)


BAD_NAMES = [
    "../goto2.json", "/goto2.json", "a/goto2.json", "..\\goto2.json", "C:goto2.json", ".goto2.json",
    "goto2.txt", "versions/goto/0001.json", "folder/", ".journals/x.journal", "goto\n2.json",
]  # fmt: skip


@pytest.mark.parametrize("name", BAD_NAMES)
def test_only_plain_file_names(rig: Rig, name: str) -> None:
    before = rig.contents()
    status, answer = rig.give(zip_members(("reach.json", document(rig, name="reach")), (name, "{}")))
    assert status == 400
    assert "plain name" in answer["error"]
    assert rig.contents() == before
    assert names(rig.host) == ["goto"]


def test_only_documents_that_open(rig: Rig) -> None:
    fine = ("reach.json", document(rig, name="reach"))
    flight = document(rig, name="flight").replace("distance_to", "height_of")
    huge = json.loads(document(rig, name="huge"))
    huge["lesson"]["record"]["moments"] = 10**9
    bad = [
        ([("goto2.json", "{")], "cut short"),
        ([("goto2.json", document(rig, name="goto3"))], "call it goto3.json"),
        ([("forward.json", document(rig, name="forward"))], "basic behavior"),
        ([("Goto.json", document(rig, name="Goto"))], "the library has goto already"),
        ([("flight.json", flight)], "has no feature 'height_of'"),
        ([("huge.json", json.dumps(huge))], "longer than 64 MB"),
        ([fine, fine], "twice"),
        ([], "it is empty"),
    ]
    before = rig.contents()
    for members, said in bad:
        with pytest.warns(UserWarning, match="Duplicate") if len(members) == 2 else _quiet():
            parcel = zip_members(*members)
        status, answer = rig.give(parcel)
        assert (status, said in answer["error"]) == (400, True), answer
    assert rig.contents() == before


def _quiet() -> Any:
    from contextlib import nullcontext

    return nullcontext()


def test_broken_and_boundless_zips(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    before = rig.contents()
    parcel = rig.out()
    damaged = bytearray(parcel)
    damaged[60:90] = bytes(30)
    encrypted = bytearray(parcel)
    encrypted[6] |= 1
    encrypted[parcel.index(b"PK\x01\x02") + 8] |= 1
    for data in (b"", b"PK", b"no zip", parcel[:-30], bytes(damaged), bytes(encrypted)):
        status, answer = rig.give(data)
        assert (status, "cannot be read as a zip" in answer["error"]) == (400, True), answer
    bomb = zip_members(("bomb.json", b" " * (65 * 2**20)))
    assert len(bomb) < 2**17
    assert "bomb.json in the zip: it is longer than 16 MB" in rig.give(bomb)[1]["error"]
    bombs = zip_members(*((f"bomb{number}.json", b" " * (15 * 2**20)) for number in range(5)))
    assert "more than 64 MB" in rig.give(bombs)[1]["error"]
    assert (
        "more than 1000 files"
        in rig.give(zip_members(*((f"a{n}.json", "") for n in range(1_001))))[1]["error"]
    )
    monkeypatch.setattr("understudy.ui.web.library_zip.MOST_PACKED", 100)
    status, answer = rig.give(parcel)
    assert status == 413
    assert rig.contents() == before


def test_an_upload_holds_up_nobody_while_it_is_read(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page in control is answered while a zip is being read."""
    begun, answered = Event(), Event()
    unzip = library_zip.unzip_library

    def wait_and_unzip(data: bytes, kit: Kit, check: library_zip.Check) -> Library:
        begun.set()
        assert answered.wait(60)
        return unzip(data, kit, check)

    monkeypatch.setattr(library_zip, "unzip_library", wait_and_unzip)
    parcel, given = rig.out(), list[tuple[int, dict[str, Any]]]()
    giving = Thread(target=lambda: given.append(rig.give(parcel)))
    giving.start()
    assert begun.wait(60)
    rig.person.done("step")
    answered.set()
    giving.join(60)
    assert [status for status, _ in given] == [200]


@pytest.mark.parametrize(("mb", "said"), [(1.1, "longer than 1 MB"), (0.9, "expected `object`, got `array`")])
def test_what_is_in_an_upload_is_judged_before_it_is_built(
    mb: float, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Building these lists would take 20 times their text, and the interpreter from all other threads."""
    monkeypatch.setattr(library_zip, "MOST_DOCUMENT", 2**20)
    parcel = zip_members(("reach.json", b"[" + b"[]," * int(mb * 2**20 / 3) + b"1]"))
    tracemalloc.start()
    try:
        with pytest.raises(FileError) as refusal:
            library_zip.unzip_library(parcel, FORAGE_KIT)
        _, most_bytes = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert "reach.json in the zip" in str(refusal.value)
    assert said in str(refusal.value)
    assert most_bytes < 5 * library_zip.MOST_DOCUMENT


def test_only_who_directs_imports(rig: Rig) -> None:
    parcel = rig.out()
    for key in ("", "guess", "é"):
        status, answer = rig.give(parcel, key=key)
        assert (status, "not in control" in answer["error"]) == (403, True)
    assert rig.give(parcel, conflicts="all")[0] == 400
    rig.person.done("release_control")
    assert rig.give(parcel)[0] == 403


def test_a_token_and_the_own_site_are_asked_for(tmp_path: Path) -> None:
    made = make_studio(tmp_path)
    with TestClient(make_app(made, token="secret"), base_url=HOME) as client:
        assert client.get(HERE).status_code == 403
        assert client.get(HERE, params={"token": "secret"}).status_code == 200
        assert (
            client.get(HERE, params={"token": "secret"}, headers={"host": "evil.example"}).status_code == 403
        )
        with open_page(client, "?token=secret") as person:
            query = {"token": "secret", "key": person.hello["key"]}
            foreign = {"origin": "http://evil.example"}
            assert client.post(HERE, params=query, headers=foreign).status_code == 403
            assert client.post(HERE, params=query).status_code == 400
