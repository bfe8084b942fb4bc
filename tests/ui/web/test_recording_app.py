"""The review of a recording as the page asks for it: labels, undo, learning, saving, and what is refused."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient
from tests.segmentation.test_drive import MAP, make_drive, write

from understudy.storage.library_folder import open_each_automaton
from understudy.ui.cli.commands.learn_from_drive import DriveOptions, segment_drive
from understudy.ui.controller.recording_review import RecordingReview
from understudy.ui.web.recording_app import make_recording_app

HERE = "http://127.0.0.1"


def make_review(folder: Path) -> RecordingReview:
    """The review of a drive to and fro of 300 ticks, with a map."""
    mapping = folder / "map.toml"
    mapping.write_text(MAP)
    recording = write(folder / "drive.csv", make_drive())
    options = DriveOptions("driven", folder / "library", mapping, None, "range(ball)", None, None, 0)
    drive = segment_drive(recording, options)
    return RecordingReview(
        drive.found, drive.library, features=drive.features, folder=folder / "library", name="driven"
    )


@pytest.fixture
def client(tmp_path: Path) -> Iterator[TestClient]:
    with TestClient(make_recording_app(make_review(tmp_path)), base_url=HERE) as client:
        yield client


def ask(client: TestClient, **request: Any) -> dict[str, Any]:
    answer = client.post("/review", json=request)
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def list_spans(review: dict[str, Any]) -> list[tuple[str, int, int, bool]]:
    names = review["labels"]
    return [(names[each["label"]], each["first"], each["end"], each["by_hand"]) for each in review["spans"]]


def test_what_was_recorded(client: TestClient) -> None:
    found = client.get("/series").json()
    drive, distance = found["series"]
    assert (drive["label"], drive["is_command"], drive["kind"]) == ("drive", True, "continuous")
    assert (distance["label"], distance["unit"], distance["is_command"]) == ("range(ball)", "m", False)
    assert distance["ticks"] == list(range(300))
    assert distance["values"][:2] == [3.0, 2.92]
    assert found["path"] == []


def test_labels_are_set_and_undone(client: TestClient) -> None:
    before = client.get("/review").json()
    assert before["labels"] == ["forward", "back", "unexplained"]
    assert list_spans(before)[:2] == [("forward", 0, 25, False), ("back", 25, 66, False)]
    assert not before["can_undo"]
    after = ask(client, do="label", first=20, end=25, label="back")
    assert list_spans(after)[:3] == [
        ("forward", 0, 20, False), ("back", 20, 25, True), ("back", 25, 66, False),
    ]  # fmt: skip
    assert after["can_undo"]
    again = ask(client, do="undo")
    assert (again["spans"], again["can_undo"]) == (before["spans"], False)


def test_learned_compared_and_saved(client: TestClient, tmp_path: Path) -> None:
    learned = ask(client, do="learn")["learned"]
    assert learned["agreement"] > 0.97
    ways = {(each["from"], each["to"]): each["when"] for each in learned["edges"]}
    assert ways["start", "forward"] == ["always"]
    assert ways["forward", "back"][0].startswith("range(ball) is below 1")
    spans = [(each["first"], each["end"]) for each in learned["spans"]]
    assert (spans[0][0], spans[-1][1]) == (0, 300)
    assert all(end == first for (_, end), (first, _) in itertools.pairwise(spans))
    saved = ask(client, do="save", name="to_and_fro")
    assert Path(saved["saved"]) == tmp_path / "library" / "to_and_fro.json"
    kept = open_each_automaton(tmp_path / "library", None, lambda _: {}).library
    assert list(kept.taught) == ["to_and_fro"]
    changed = ask(client, do="label", first=20, end=26, label="back")
    assert (changed["learned"], changed["saved"]) == (None, None), "it was learned from other labels"


def test_a_wrong_label_spoils_the_agreement(client: TestClient) -> None:
    """Half of a span is called the other thing: no threshold on the distance does both."""
    right = ask(client, do="learn")["learned"]["agreement"]
    ask(client, do="label", first=30, end=50, label="forward")
    wrong = ask(client, do="learn")["learned"]["agreement"]
    assert wrong < right


REFUSED = [  # request, status, what is said
    ({"do": "label", "first": 5, "end": 5, "label": "back"}, 400, "no part of an episode"),
    ({"do": "label", "first": 5, "end": 9, "label": "up"}, 400, "has no behavior 'up'"),
    ({"do": "save", "name": "x"}, 400, "learn first"),
    ({"do": "undo"}, 400, "nothing to undo"),
    ({"do": "dance"}, 400, "dance"),
    ({"do": "label", "first": -1, "end": 9, "label": "up"}, 400, ">= 0"),
]


@pytest.mark.parametrize(("request_", "status", "said"), REFUSED)
def test_refused(client: TestClient, request_: dict[str, Any], status: int, said: str) -> None:
    before = client.get("/review").json()
    answer = client.post("/review", json=request_)
    assert (answer.status_code, said in answer.json()["error"]) == (status, True), answer.text
    assert client.get("/review").json() == before


def test_the_page_and_its_files(client: TestClient) -> None:
    assert "Understudy: a recording" in client.get("/").text
    assert client.get("/icon.svg").status_code == 200


def test_who_may_ask(tmp_path: Path) -> None:
    app = make_recording_app(make_review(tmp_path), token="secret", hosts=None)
    with TestClient(app, base_url=HERE) as client:
        assert client.get("/review").status_code == 403
        assert client.post("/review", json={"do": "learn"}).status_code == 403
        assert client.get("/series").status_code == 403
        assert client.get("/review?token=secret").status_code == 200
    other = make_recording_app(make_review(tmp_path))
    with TestClient(other, base_url="http://elsewhere.example") as client:
        assert client.get("/review").status_code == 403


def test_a_request_that_is_too_long(client: TestClient) -> None:
    answer = client.post("/review", content=b"x" * 100_000)
    assert (answer.status_code, answer.json()) == (413, {"error": "the request is too long"})
