"""The review of a recording as the page asks for it: labels, undo, learning, saving, and what is refused."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from starlette.testclient import TestClient
from tests.segmentation.driven import ANNA, FAR, MAP
from tests.segmentation.drives import follow
from tests.segmentation.drives import make_drive as make_stick_drive
from tests.segmentation.test_drive import make_drive
from tests.segmentation.test_split_states import drive_along_walls

from understudy.addons.recordings.drive_kit import make_candidates, make_drive_kit
from understudy.addons.recordings.segment import segment
from understudy.model.library import Library
from understudy.storage.library_folder import open_each_automaton
from understudy.ui.cli.commands.learn_from_drive import SegmentedDrive
from understudy.ui.cli.commands.learn_from_drivers import segment_drivers
from understudy.ui.cli.lesson_options import DriveOptions
from understudy.ui.controller.recording_review import RecordingReview
from understudy.ui.web.recording_app import make_recording_app

HERE = "http://127.0.0.1"


@cache
def segment_tables(*tables: tuple[str, str]) -> Mapping[str, SegmentedDrive]:
    """Segment tables of drivers before a ball, each with the driver's name."""
    with TemporaryDirectory() as folder:
        mapping = Path(folder, "map.toml")
        mapping.write_text(MAP)
        paths = {name: [Path(folder, f"{name or 'drive'}.csv")] for name, _ in tables}
        for name, table in tables:
            paths[name][0].write_text(table)
        options = DriveOptions(mapping=mapping, features="range(ball)")
        return segment_drivers(paths, options)


def make_review(folder: Path) -> RecordingReview:
    """The review of a drive to and fro of 300 ticks, with a map."""
    drive = segment_tables(("", "\n".join(make_drive()) + "\n"))[""]
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


def make_arcs(folder: Path) -> RecordingReview:
    """The review of two drives forward, in an arc, which nothing explains, and back, with a name for nothing yet."""
    spans = [((0.8, 0.0), 40), ((0.3, 0.6), 30), ((-0.5, 0.0), 40)] * 4
    drive = make_stick_drive(
        follow([aim for aim, ticks in spans for _ in range(ticks)]),
        {("x", None): np.zeros(440)},
        lengths=(220, 220),
    )
    library = Library(make_drive_kit(drive, {"forward": {"drive": 0.8}, "back": {"drive": -0.5}}))
    found = segment(drive, make_candidates(library, drive))
    return RecordingReview(found, library, features=None, folder=folder / "library", name="driven")


def test_a_proposed_behavior_is_added_and_undone(tmp_path: Path) -> None:
    review = make_arcs(tmp_path)
    with TestClient(make_recording_app(review), base_url=HERE) as client:
        before = ask(client, do="label", first=100, end=105, label="forward")
        (proposal,) = before["proposals"]
        assert proposal["command"] == pytest.approx({"drive": 0.3, "turn": 0.6}, abs=0.02)
        assert (proposal["spans"], proposal["description"].startswith("drive 0.3")) == (4, True)
        after = ask(client, do="define", name="arc", command=proposal["command"])
        assert after["labels"] == ["forward", "back", "arc", "unexplained"]
        assert after["proposals"] == []
        assert sum(name == "arc" for name, *_ in list_spans(after)) == 4
        assert ("forward", 100, 105, True) in list_spans(after), "what was set by hand stays"
        learned = ask(client, do="learn")["learned"]
        assert {each["name"] for each in learned["states"]} == {"start", "forward", "back", "arc"}
        again = ask(client, do="undo")
        assert (again["spans"], again["labels"]) == (before["spans"], before["labels"])
        for name, command, said in (
            ("forward", {"drive": 1.0}, "there is a behavior of that name already"),
            ("two words", {"drive": 1.0}, "choose a name of letters"),
            ("up", {"lift": 1.0}, "no command channel 'lift'"),
        ):
            answer = client.post("/review", json={"do": "define", "name": name, "command": command})
            assert (answer.status_code, said in answer.json()["error"]) == (400, True), answer.text


def test_a_state_is_split_and_stays_so_while_the_drive_goes_on(tmp_path: Path) -> None:
    review = make_arcs(tmp_path)
    with TestClient(make_recording_app(review), base_url=HERE) as client:
        changed = ask(client, do="split", state="forward", entered_from=["start"])
        assert changed["labels"] == ["forward", "back", "forward_2", "unexplained"]
        firsts = [name for name, first, _, _ in list_spans(changed) if first in (0, 220)]
        assert firsts == ["forward_2", "forward_2"]
        ask(client, do="define", name="arc", command={"drive": 0.3, "turn": 0.6})
        found = client.get("/review").json()
        assert found["labels"] == ["forward", "back", "arc", "forward_2", "unexplained"]
        assert [name for name, first, _, _ in list_spans(found) if first in (0, 220)] == firsts
        drive = review.segmentation.drive
        review.extend(segment(drive, [*review.segmentation.candidates[:2], *review.new_candidates]))
        assert client.get("/review").json()["labels"] == found["labels"]
        assert not review.can_undo


def test_a_split_is_proposed_with_what_was_learned(tmp_path: Path) -> None:
    found, made = drive_along_walls(1)
    review = RecordingReview(found, made.library, features=None, folder=tmp_path / "library", name="walls")
    with TestClient(make_recording_app(review), base_url=HERE) as client:
        (split,) = ask(client, do="learn")["learned"]["splits"]
        assert split["state"] == "back"
        assert "no feature tells why" in split["evidence"]
        ask(client, do="split", state=split["state"], entered_from=split["entered_from"])
        assert ask(client, do="learn")["learned"]["splits"] == []


def make_drivers_review(
    folder: Path, trust: str | None = None, targets: Mapping[str, str] = MappingProxyType({})
) -> RecordingReview:
    """The review of Anna, who goes back at 1 m from the ball, and Ben, who goes back at 2 m, 90 s each."""
    drivers = (("anna", ANNA), ("ben", FAR))
    drives = segment_tables(*((name, "\n".join(each.drive()) + "\n") for name, each in drivers))
    found = {name: each.found for name, each in drives.items()}
    first = drives["anna"]
    return RecordingReview(
        found,
        first.library,
        features=first.features,
        folder=folder / "library",
        name="driven",
        trust=trust,
        targets=targets,
    )


def test_a_target_becomes_a_parameter(tmp_path: Path) -> None:
    learned, plain = (make_drivers_review(tmp_path, targets=each).learn() for each in ({"A": "ball"}, {}))
    assert learned.taught.automaton.parameters == ("A",)
    assert plain.taught.automaton.parameters == ()
    assert learned.agreement == plain.agreement


def list_left_out(folder: Path, name: str) -> list[tuple[str, str]]:
    """Who showed each example of a saved automaton that contradicts another, and whom it contradicts."""
    lesson = open_each_automaton(folder / "library", None, lambda _: {}).library.taught[name].lesson
    assert lesson is not None
    return [
        (each.source.driver, each.quarantined.split()[1])
        for each in lesson.examples
        if each.source is not None and each.quarantined.startswith("contradicts")
    ]


@pytest.mark.long
def test_contradictions_between_drivers_are_settled_and_saved(tmp_path: Path) -> None:
    review = make_drivers_review(tmp_path)
    with TestClient(make_recording_app(review), base_url=HERE) as client:
        opened = client.get("/review").json()
        assert [(each["driver"], each["source"], each["first"]) for each in opened["episodes"]] == [
            ("anna", "anna.csv", 0),
            ("ben", "ben.csv", 1800),
        ]
        assert (opened["drivers"], opened["trust"]) == (["anna", "ben"], None)
        learned = ask(client, do="learn")["learned"]
        (first,) = [each for each in learned["contradictions"] if each["state"] == "forward"]
        anna, ben = first["choices"]
        assert anna["description"].startswith("anna stays in forward at range(ball) = ")
        assert ben["description"].startswith("ben switches from forward to back at range(ball) = ")
        distance = review.segmentation.drive.values["range", "ball"]
        for choice, begins in ((anna, 0), (ben, 1800)):
            said = float(choice["description"].split(" = ")[1].split(" m")[0])
            assert begins <= choice["tick"] < begins + 1800
            near = distance[
                choice["tick"] - 12 : choice["tick"] + 1
            ]  # a press is as late as the driver reacts
            assert np.abs(near - said).min() < 0.01
        assert any(each.startswith("Reaction time of ben 0.") for each in learned["reactions"])
        index = learned["contradictions"].index(first)
        settled = ask(client, do="settle", contradiction=index, trust="anna")["learned"]
        assert settled["quarantined"] > learned["quarantined"]
        assert {"state": "forward", "trust": "anna"} in [
            {"state": each["state"], "trust": each["trust"]} for each in settled["contradictions"]
        ]
        ask(client, do="save", name="after_anna")
        assert set(list_left_out(tmp_path, "after_anna")) == {("ben", "anna")}
        again = ask(client, do="undo")
        assert again["learned"] == learned, "only the decision is undone"
        ask(client, do="trust", driver="ben")
        ask(client, do="save", name="after_ben")
        assert set(list_left_out(tmp_path, "after_ben")) == {("anna", "ben")}


def test_a_decision_outlasts_other_labels(tmp_path: Path) -> None:
    with TestClient(make_recording_app(make_drivers_review(tmp_path, trust="ben")), base_url=HERE) as client:
        assert client.get("/review").json()["trust"] == "ben"
        trusted = ask(client, do="learn")["learned"]["contradictions"]
        assert {each["trust"] for each in trusted} == {"ben"}
        changed = ask(client, do="label", first=1900, end=1910, label="back")
        assert ("back", 1900, 1910, True) in list_spans(changed)
        assert changed["learned"] is None
        ask(client, do="trust", driver=None)
        open_ = ask(client, do="learn")["learned"]["contradictions"]
        index = next(index for index, each in enumerate(open_) if each["state"] == "forward")
        ask(client, do="settle", contradiction=index, trust="anna")
        ask(client, do="label", first=1900, end=1910, label="forward")
        later = ask(client, do="trust", driver="ben")
        assert later["learned"] is None
        found = ask(client, do="learn")["learned"]["contradictions"]
        assert {each["trust"] for each in found if each["state"] == "forward"} == {"anna"}, (
            "one by one comes first"
        )


def test_a_decision_that_cannot_be_made(tmp_path: Path) -> None:
    with TestClient(make_recording_app(make_drivers_review(tmp_path)), base_url=HERE) as client:

        def refuse(**request: Any) -> str:
            answer = client.post("/review", json=request)
            assert answer.status_code == 400, answer.text
            return str(answer.json()["error"])

        assert "learn first" in refuse(do="settle", contradiction=0, trust="anna")
        ask(client, do="learn")
        assert "no such contradiction" in refuse(do="settle", contradiction=99, trust="anna")
        assert "'carl'" in refuse(do="settle", contradiction=0, trust="carl")
        assert "anna" in refuse(do="trust", driver="carl")


def test_a_behavior_is_added_for_all_drivers(tmp_path: Path) -> None:
    review = make_drivers_review(tmp_path)
    with TestClient(make_recording_app(review), base_url=HERE) as client:
        ask(client, do="label", first=1900, end=1910, label="unexplained")
        after = ask(client, do="define", name="creep", command={"drive": 0.1})
        assert after["labels"] == ["forward", "back", "creep", "unexplained"]
        assert ("unexplained", 1900, 1910, True) in list_spans(after), "what was set by hand stays"
        split = ask(client, do="split", state="forward", entered_from=["start"])
        firsts = [name for name, first, _, _ in list_spans(split) if first in (0, 1800)]
        assert firsts == ["forward_2", "forward_2"]


REFUSED = [  # request, status, what is said
    ({"do": "label", "first": 5, "end": 5, "label": "back"}, 400, "no part of an episode"),
    ({"do": "label", "first": 5, "end": 9, "label": "up"}, 400, "has no behavior 'up'"),
    ({"do": "save", "name": "x"}, 400, "learn first"),
    ({"do": "undo"}, 400, "nothing to undo"),
    ({"do": "split", "state": "back", "entered_from": ["back"]}, 400, "never entered from back"),
    ({"do": "split", "state": "up", "entered_from": []}, 400, "no state 'up'"),
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
