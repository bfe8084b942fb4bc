"""Who directs: one page at a time, and what becomes of it when that page leaves, hands over or comes back."""

from __future__ import annotations

from pathlib import Path

import pytest
from starlette.testclient import TestClient
from tests.make.studios import GOTO, HOME, Wall, make_studio, open_page, serve_studio

from understudy.ui.web.app import make_app


def test_the_first_page_directs_and_the_second_watches(tmp_path: Path) -> None:
    with (
        serve_studio(make_studio(tmp_path)) as client,
        open_page(client) as first,
        open_page(client) as second,
    ):
        assert (first.hello["has_control"], second.hello["has_control"]) == (True, False)
        first.done(**GOTO)
        assert "not in control" in second.say("press", state="forward")["error"]
        assert "another page is in control" in second.say("take_control")["error"]
        assert second.done("why")["levels"]
        while not second.news["session"]:
            second.hear()
        assert second.news["session"]["pending"] is None
        assert (second.news["has_control"], second.news["viewers"]) == (False, 2)


def test_handing_over_pauses_and_lets_another_take(tmp_path: Path) -> None:
    made = make_studio(tmp_path)
    with serve_studio(made) as client, open_page(client) as first, open_page(client) as second:
        first.done(**GOTO)
        assert not made.host.paused
        first.done("release_control")
        assert made.host.paused
        assert "take over first" in first.say("press", state="forward")["error"]
        second.done("take_control")
        second.done("press", state="forward")
        assert "not in control" in first.say("undo")["error"]


def test_the_director_leaving_pauses_and_its_key_brings_it_back(tmp_path: Path) -> None:
    made = make_studio(tmp_path)
    with serve_studio(made) as client, open_page(client) as watcher:
        watcher.done("release_control")
        with open_page(client) as person:
            assert person.hello["has_control"]
            person.done(**GOTO)
            person.done("press", state="forward")
            key = person.hello["key"]
        while not watcher.news["paused"] or watcher.news["viewers"] != 1:
            watcher.hear()
        assert made.host.paused
        with open_page(client, f"?key={key}") as again:
            assert again.hello["has_control"]
            assert again.hello["key"] == key
            assert again.news["session"]["pending"] == "forward"  # what was acknowledged is there


def test_a_run_goes_on_when_the_page_that_left_comes_back(tmp_path: Path) -> None:
    """A page that was loaded anew, or lost its connection, goes on; what a person paused stays paused."""
    wall = Wall()
    made = make_studio(tmp_path, wall=wall)
    with serve_studio(made) as client:
        with open_page(client) as person:
            person.done(**GOTO)
            key = person.hello["key"]
        assert made.host.paused
        with open_page(client, f"?key={key}") as again:
            assert not made.host.paused
            again.done("pause", paused=True)
        with open_page(client, f"?key={key}"):
            assert made.host.paused


@pytest.mark.parametrize("how", ["another page came", "too late", "handed over"])
def test_a_run_stays_paused(tmp_path: Path, how: str) -> None:
    """Nothing moves again where somebody else was in control, after a long time, or after handing over."""
    wall = Wall()
    made = make_studio(tmp_path, wall=wall)
    with serve_studio(made) as client:
        with open_page(client) as person:
            person.done(**GOTO)
            key = person.hello["key"]
            if how == "handed over":
                person.done("release_control")
        if how == "another page came":
            with open_page(client):
                pass
        wall.now += 31 if how == "too late" else 0
        with open_page(client, f"?key={key}") as again:
            assert again.hello["has_control"]
            assert made.host.paused


def test_control_is_offered_only_where_it_can_be_taken(tmp_path: Path) -> None:
    wall = Wall()
    made = make_studio(tmp_path, wall=wall)
    with serve_studio(made) as client, open_page(client) as first, open_page(client) as second:
        assert (second.news["is_controlled"], second.news["can_take_control"]) == (True, False)
        wall.now += 31
        while not second.news["can_take_control"]:
            second.hear()
        first.done("pause", paused=True)  # it speaks again
        while second.news["can_take_control"]:
            second.hear()
        first.done("release_control")
        while second.news["is_controlled"]:
            second.hear()
        assert second.news["can_take_control"]


def test_a_page_cut_off_unnoticed_is_replaced_by_itself(tmp_path: Path) -> None:
    with (
        serve_studio(make_studio(tmp_path)) as client,
        open_page(client) as lost,
        open_page(client, f"?key={lost.hello['key']}") as back,
    ):
        assert back.hello["has_control"]
        back.done(**GOTO)
        with pytest.raises(ConnectionError):
            lost.answer(1)
        with open_page(
            client, f"?key={lost.hello['key']}"
        ) as again:  # it does not throw out the one that came after
            assert not again.hello["has_control"]
        back.done("confirm")


def test_a_key_does_not_take_the_place_of_another(tmp_path: Path) -> None:
    with serve_studio(make_studio(tmp_path)) as client:
        with open_page(client) as first:
            key = first.hello["key"]
        with (
            open_page(client),
            open_page(client, f"?key={key}") as late,
            open_page(client, "?key=made-up") as stranger,
        ):
            assert not late.hello["has_control"]
            assert stranger.hello["key"] != "made-up"


def test_a_silent_director_can_be_replaced(tmp_path: Path) -> None:
    wall = Wall()
    made = make_studio(tmp_path, wall=wall)
    with serve_studio(made) as client, open_page(client), open_page(client) as second:
        wall.now += 29
        assert "29 s so far" in second.say("take_control")["error"]
        wall.now += 1
        second.done("take_control")


REFUSED = [  # query, headers, what it says
    ("?token=secret", {"origin": "http://elsewhere.example"}, "another site"),
    ("?token=secret", {"host": "elsewhere.example"}, "not a host name of the studio"),
    ("", {}, "token"),
    ("?token=secre", {}, "token"),
    ("?token=s%C3%A9cret", {}, "token"),
]


@pytest.mark.parametrize(("query", "headers", "said"), REFUSED)
def test_who_may_not_connect(tmp_path: Path, query: str, headers: dict[str, str], said: str) -> None:
    made = make_studio(tmp_path)
    with TestClient(make_app(made, token="secret"), base_url=HOME) as client:
        with client.websocket_connect(f"ws://127.0.0.1/ws{query}", headers=headers) as socket:
            closed = socket.receive()
        assert closed["type"] == "websocket.close"
        assert said in closed["reason"]
        assert len(made.viewers) == 0
        with open_page(client, "?token=secret") as person:
            assert person.hello["has_control"]


def test_too_many_pages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("understudy.ui.web.app.MOST_PAGES", 2)
    with (
        serve_studio(make_studio(tmp_path)) as client,
        open_page(client),
        open_page(client),
        client.websocket_connect("ws://127.0.0.1/ws") as third,
    ):
        assert "2 pages are open already" in third.receive()["reason"]


def test_too_many_messages_are_refused_and_undone_by_waiting(tmp_path: Path) -> None:
    wall = Wall()
    made = make_studio(tmp_path, wall=wall)
    with serve_studio(made) as client, open_page(client) as person:
        answers = [person.say("pause", paused=False) for _ in range(210)]
        assert [answer.get("ok", False) for answer in answers] == [True] * 200 + [False] * 10
        assert "200 per second" in answers[-1]["error"]
        wall.now += 0.1
        person.done("pause", paused=True)


def test_the_page_and_nothing_outside_of_it(tmp_path: Path) -> None:
    static = tmp_path / "static"
    made = make_studio(tmp_path / "library")
    with TestClient(make_app(made, static=static), base_url=HOME) as client:
        answer = client.get("/")
        assert answer.status_code == 503
        assert "not built" in answer.text
    static.mkdir()
    (static / "index.html").write_text("<title>Studio</title>")
    (tmp_path / "secret").write_text("secret")
    with TestClient(make_app(made, static=static), base_url=HOME) as client:
        assert "Studio" in client.get("/").text
        for path in ("/../secret", "/%2e%2e/secret", "/..%2fsecret", "/static/../../secret"):
            assert client.get(path).status_code in (400, 404)
