"""The library as a zip: what goes out, what is let in, and what is refused without a trace."""

from __future__ import annotations

import json
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import pytest
from starlette.testclient import TestClient
from tests.ui.web.pages import GOTO, HOME, Page, page, served, studio
from tests.ui.web.test_library import files, names, teach

from understudy.storage.library_folder import list_versions
from understudy.ui.web.app import make_app
from understudy.ui.web.server import StudioServer

HERE = "/library.zip"


class Desk:
    """A studio with goto saved, the page that directs it, and its post."""

    def __init__(self, made: StudioServer, client: TestClient, person: Page) -> None:
        self.stage, self.client, self.person = made.host, client, person
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
        folder = self.stage.library_view.folder
        return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    made = studio(tmp_path / "library")
    with served(made) as client, page(client) as person:
        person.done(**GOTO)
        teach(person, "forward")
        person.done("save")
        yield Desk(made, client, person)


def zipped(*members: tuple[str, bytes | str]) -> bytes:
    made = BytesIO()
    with ZipFile(made, "w", ZIP_DEFLATED) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return made.getvalue()


def test_documents_go_out_and_come_in_elsewhere(desk: Desk, tmp_path: Path) -> None:
    desk.person.done("duplicate", name="goto", to="a/b")
    teach(desk.person, "rotate_left")
    desk.person.done("save")
    assert len(files(desk.stage)) == 3  # one of them a former version
    parcel = desk.out()
    with ZipFile(BytesIO(parcel)) as archive:
        assert sorted(archive.namelist()) == ["a%2Fb.json", "goto.json"]
    other = studio(tmp_path / "other")
    with served(other) as client, page(client) as person:
        there = Desk(other, client, person)
        assert there.out()[:2] == b"PK"  # empty, and no folder yet
        assert there.give(parcel) == (200, {"said": "Imported a/b, goto"})
        while not person.desk["library"]["trained"]:
            person.hear()
        assert person.desk["said"]["text"] == "Imported a/b, goto"
        assert there.give(parcel) == (200, {"said": "Nothing new was in it"})
    assert files(other.host) == ["a%2Fb.json", "goto.json"]
    for name in files(other.host):
        here, there_ = (each.library_view.folder / name for each in (desk.stage, other.host))
        assert here.read_bytes() == there_.read_bytes()


def test_what_is_there_is_replaced_only_when_asked(desk: Desk) -> None:
    desk.person.done("duplicate", name="goto", to="extra")
    parcel = desk.out()
    desk.person.done("remove", name="extra")
    teach(desk.person, "rotate_left")
    desk.person.done("save")
    before = desk.contents()
    status, answer = desk.give(parcel)
    assert (status, answer["taken"]) == (409, ["goto"])
    assert "the library has goto already" in answer["error"]
    assert "goto is being trained" in desk.give(parcel, taken="replace")[1]["error"]
    assert desk.contents() == before
    assert desk.give(parcel, taken="keep") == (200, {"said": "Imported extra"})
    assert before.items() <= desk.contents().items()
    desk.person.done("open", name="extra")
    said = "Nothing new was in it; replaced goto, former versions are kept"
    assert desk.give(parcel, taken="replace") == (200, {"said": said})
    assert desk.stage.library_view.library.taught["goto"].lesson is not None
    assert [each.number for each in list_versions(desk.stage.library_view.folder, "goto")] == [1, 2]


def document(desk: Desk, **automaton: str) -> str:
    found = json.loads((desk.stage.library_view.folder / "goto.json").read_text())
    found["automaton"].update(automaton)
    return json.dumps(found)


BAD_NAMES = [
    "../goto2.json", "/goto2.json", "a/goto2.json", "..\\goto2.json", "C:goto2.json", ".goto2.json",
    "goto2.txt", "versions/goto/0001.json", "folder/", ".journals/x.journal", "goto\n2.json",
]  # fmt: skip


@pytest.mark.parametrize("name", BAD_NAMES)
def test_only_plain_file_names(desk: Desk, name: str) -> None:
    before = desk.contents()
    status, answer = desk.give(zipped(("reach.json", document(desk, name="reach")), (name, "{}")))
    assert status == 400
    assert "plain name" in answer["error"]
    assert desk.contents() == before
    assert names(desk.stage) == ["goto"]


def test_only_documents_that_open(desk: Desk) -> None:
    fine = ("reach.json", document(desk, name="reach"))
    flight = document(desk, name="flight").replace("distance_to", "height_of")
    huge = json.loads(document(desk, name="huge"))
    huge["lesson"]["record"]["moments"] = 10**9
    bad = [
        ([("goto2.json", "{")], "cut short"),
        ([("goto2.json", document(desk, name="goto3"))], "call it goto3.json"),
        ([("forward.json", document(desk, name="forward"))], "basic behavior"),
        ([("Goto.json", document(desk, name="Goto"))], "the library has goto already"),
        ([("flight.json", flight)], "has no feature 'height_of'"),
        ([("huge.json", json.dumps(huge))], "longer than 64 MB"),
        ([fine, fine], "twice"),
        ([], "it is empty"),
    ]
    before = desk.contents()
    for members, said in bad:
        with pytest.warns(UserWarning, match="Duplicate") if len(members) == 2 else _quiet():
            parcel = zipped(*members)
        status, answer = desk.give(parcel)
        assert (status, said in answer["error"]) == (400, True), answer
    assert desk.contents() == before


def _quiet() -> Any:
    from contextlib import nullcontext

    return nullcontext()


def test_broken_and_boundless_zips(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    before = desk.contents()
    parcel = desk.out()
    damaged = bytearray(parcel)
    damaged[60:90] = bytes(30)
    encrypted = bytearray(parcel)
    encrypted[6] |= 1
    encrypted[parcel.index(b"PK\x01\x02") + 8] |= 1
    for data in (b"", b"PK", b"no zip", parcel[:-30], bytes(damaged), bytes(encrypted)):
        status, answer = desk.give(data)
        assert (status, "cannot be read as a zip" in answer["error"]) == (400, True), answer
    bomb = zipped(("bomb.json", b" " * (65 * 2**20)))
    assert len(bomb) < 2**17
    assert "more than 64 MB" in desk.give(bomb)[1]["error"]
    assert (
        "more than 1000 files" in desk.give(zipped(*((f"a{n}.json", "") for n in range(1_001))))[1]["error"]
    )
    monkeypatch.setattr("understudy.ui.web.library_zip.MOST_PACKED", 100)
    status, answer = desk.give(parcel)
    assert status == 413
    assert desk.contents() == before


def test_only_who_directs_imports(desk: Desk) -> None:
    parcel = desk.out()
    for key in ("", "guess", "é"):
        status, answer = desk.give(parcel, key=key)
        assert (status, "only watches" in answer["error"]) == (403, True)
    assert desk.give(parcel, taken="all")[0] == 400
    desk.person.done("hand_over")
    assert desk.give(parcel)[0] == 403


def test_a_token_and_the_own_site_are_asked_for(tmp_path: Path) -> None:
    made = studio(tmp_path)
    with TestClient(make_app(made, token="secret"), base_url=HOME) as client:
        assert client.get(HERE).status_code == 403
        assert client.get(HERE, params={"token": "secret"}).status_code == 200
        assert (
            client.get(HERE, params={"token": "secret"}, headers={"host": "evil.example"}).status_code == 403
        )
        with page(client, "?token=secret") as person:
            query = {"token": "secret", "key": person.hello["key"]}
            foreign = {"origin": "http://evil.example"}
            assert client.post(HERE, params=query, headers=foreign).status_code == 403
            assert client.post(HERE, params=query).status_code == 400
