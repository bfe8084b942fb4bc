"""Exports from the studio's library: a zip to download, or one sentence."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any
from urllib.parse import unquote
from zipfile import ZipFile

import pytest
from starlette.testclient import TestClient
from tests.export.exports import FIXTURE
from tests.export.test_ros2 import FORAGER
from tests.make.studios import HOME, make_studio, open_page, serve_studio

from understudy.ui.web.app import make_app
from understudy.ui.web.views import exports

HERE = "/export.zip"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A library with a forager."""
    (tmp_path / "library").mkdir()
    for name in ("goto", "harvest", "deposit", "forage"):
        shutil.copy(FIXTURE / f"{name}.json", tmp_path / "library")
    return tmp_path / "library"


@pytest.fixture
def client(folder: Path) -> Iterator[TestClient]:
    with serve_studio(make_studio(folder)) as client:
        yield client


def ask(client: TestClient, content: str = "", **query: Any) -> Any:
    return client.post(HERE, params=query, content=content.encode())


def list_files(answer: Any) -> set[str]:
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "application/zip"
    with ZipFile(BytesIO(answer.content)) as archive:
        assert archive.testzip() is None
        return set(archive.namelist())


def test_an_automaton_goes_out_as_a_folder_in_a_zip(client: TestClient, folder: Path) -> None:
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    answer = ask(client, name="forage", to="c99")
    assert {"forage-c99/forage.c", "forage-c99/manifest.json", "forage-c99/Makefile"} <= list_files(answer)
    assert 'filename="forage-c99.zip"' in answer.headers["content-disposition"]
    assert unquote(answer.headers["X-Understudy-Message"]) == "Exported forage for c99"
    single = ask(client, name="forage", to="c99", single="1")
    with ZipFile(BytesIO(single.content)) as archive:
        assert b"typedef float forage_real;" in archive.read("forage-c99/forage.h")
    assert before == {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_parameters_get_their_targets(client: TestClient) -> None:
    answer = ask(client, name="goto", to="python", bind=["A=station"])
    with ZipFile(BytesIO(answer.content)) as archive:
        assert b'"binding": {\n    "A": "station"' in archive.read("goto-python/manifest.json")


def test_a_package_for_ros_is_for_the_robot_of_a_file(client: TestClient) -> None:
    answer = ask(client, FORAGER, name="forage", to="ros2")
    assert "forage-ros2/src/forage_node.cpp" in list_files(answer)
    assert "rover ignores load and unload" in unquote(answer.headers["X-Understudy-Message"])


MISTAKES = [
    ({"name": "nothing", "to": "c99"}, "", "no automaton 'nothing'"),
    ({"name": "forage", "to": "cobol"}, "", "'cobol'"),
    ({"name": "goto", "to": "c99"}, "", "parameter 'A' of 'goto' is bound to nothing"),
    ({"name": "goto", "to": "c99", "bind": "A=moon"}, "", "moon"),
    ({"name": "forage", "to": "json", "single": "1"}, "", "single precision is not offered"),
    ({"name": "forage", "to": "ros2"}, "", "robot's file is missing"),
    ({"name": "forage", "to": "ros2"}, "name = ", "the robot's file at line 1, column 8: is not TOML"),
    (
        {"name": "forage", "to": "ros2"},
        FORAGER.replace('"forage"', '"../secret.toml"'),
        "open that world first",
    ),
    ({"name": "forage", "to": "ros2"}, FORAGER.replace("[limits]", "[limit]"), "limit"),
    ({"name": "forage", "to": "ros2"}, "#" * 300_000, "larger than 256 kB"),
]


@pytest.mark.parametrize(("query", "content", "problem"), MISTAKES)
def test_a_mistake_is_a_sentence(
    client: TestClient, query: dict[str, str], content: str, problem: str
) -> None:
    answer = ask(client, content, **query)
    assert (answer.status_code, problem in answer.json()["error"]) == (400, True), answer.text
    assert "Traceback" not in answer.text


def test_a_file_that_is_no_text_is_refused(client: TestClient) -> None:
    answer = client.post(HERE, params={"name": "forage", "to": "ros2"}, content=b"\xff\xfe\x00")
    assert "is not text in UTF-8" in answer.json()["error"]


def test_pages_know_the_targets(folder: Path) -> None:
    with serve_studio(make_studio(folder)) as client, open_page(client) as person:
        single = {each["name"]: each["single_precision"] for each in person.hello["exports"]}
    assert {"c99": True, "python": False, "json": False, "ros2": False}.items() <= single.items()


def test_a_target_that_cannot_be_loaded_is_among_the_targets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exports, "list_targets", lambda: ["c99", "missing"])
    assert [(each.name, each.single_precision) for each in exports.describe_export_targets()] == [
        ("c99", True),
        ("missing", False),
    ]


def test_a_token_and_the_own_site_are_asked_for(folder: Path) -> None:
    with TestClient(make_app(make_studio(folder), token="secret"), base_url=HOME) as client:
        query = {"name": "forage", "to": "json"}
        assert client.post(HERE, params=query).status_code == 403
        assert client.post(HERE, params={**query, "token": "secret"}).status_code == 200
        foreign = {"origin": "http://evil.example"}
        assert client.post(HERE, params={**query, "token": "secret"}, headers=foreign).status_code == 403
        assert client.get(HERE, params={**query, "token": "secret"}).status_code == 404
