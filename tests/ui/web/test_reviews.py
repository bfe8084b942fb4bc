"""Looking back through messages: why on all levels, what lessons promise, what saving would break, simplifying."""

from __future__ import annotations

from typing import Any

from tests.make.studios import GOTO, Page, open_page, serve_studio, teach, to_json

from understudy.addons.robots.twin import find_drawn_world
from understudy.ui.web.server import StudioServer

FETCH: dict[str, Any] = {
    "do": "new",
    "live": False,
    "name": "fetch",
    "states": ["goto(station)"],
    "features": ["done"],
    "flags": ["done"],
}


def begin(person: Page) -> None:
    """A goto that drives off, whatever it sees, and is done at once."""
    person.done(**GOTO)
    teach(person, "forward", "done")
    person.done("save")


def session_data(made: StudioServer) -> dict[str, Any]:
    shown: dict[str, Any] = to_json(made.host.session_data())
    return shown


def test_why_names_every_level_and_who_showed_it(server: StudioServer, person: Page) -> None:
    begin(person)
    person.done(**FETCH)
    teach(person, "goto")
    person.done("step")  # goto is done
    teach(person, "done")
    person.done("toggle_mode")
    first = person.done("why")
    (level,) = first["levels"]
    assert (level["automaton"], level["state"], level["since_s"]) == (
        "fetch",
        "start",
        server.host.world.time_s,
    )
    assert level["decision"] == "It goes from start to goto, always."
    assert [each["number"] for each in level["examples"]] == [1]
    assert level["examples"][0]["time_s"] is not None
    assert (level["in_lesson"], level["in_training"]) == (True, False)
    assert first["last"]["automaton"] == "goto(station)"  # before it was let go
    person.done("step")
    both = person.done("why")
    assert [(each["automaton"], each["in_lesson"]) for each in both["levels"]] == [
        ("fetch", True), ("goto(station)", False),
    ]  # fmt: skip
    inner = both["levels"][1]
    assert inner["state"] == "forward"
    assert inner["decision"].startswith("It goes from forward to done because distance_to(A) is at least ")
    assert inner["readings"].startswith("distance_to(A) = ")
    last = both["last"]
    assert (last["automaton"], last["decision"]) == ("fetch", "It went from start to goto, always.")
    person.done("step")
    assert person.done("why")["last"]["automaton"] == "goto(station)"


def test_why_goes_back_with_time(server: StudioServer, person: Page) -> None:
    """A switch that has not happened yet is no reason; the one before is one again."""
    begin(person)
    person.done("toggle_mode")
    for _ in range(7):
        person.done("step")
    assert person.done("why")["levels"][0]["decision"] == "done is raised; a flag state is never left"
    assert person.done("why")["last"]["decision"].startswith("It went from forward to done")
    person.done("rewind", time_s=server.host.world.time_s - 0.1)
    now = server.host.world.time_s
    assert person.done("why")["last"]["time_s"] < now, "what happened before then has happened"
    began = server.host.rewind_buffer.find_before_time(0.0).time_s
    person.done("rewind", time_s=began)
    back = person.done("why")
    assert back["levels"][0]["decision"] == "It goes from start to forward, always."
    assert back["last"] is None


def test_in_training_somebody_else_decides(person: Page) -> None:
    begin(person)
    person.done("restart")
    (level,) = person.done("why")["levels"]
    assert level["in_training"]
    assert level["decision"] == "It goes from start to forward, always."


def test_a_promise_is_listed_withdrawn_and_undone(server: StudioServer, person: Page) -> None:
    begin(person)
    assert (session_data(server)["flags"], session_data(server)["properties"]) == (["done"], [])
    edition = session_data(server)["edition"]
    person.done("add_property", flag="done", within_s=5)
    assert session_data(server)["properties"] == ["done is raised within 5 s in forage, A = station"]
    assert session_data(server)["edition"] > edition
    assert session_data(server)["unsaved"]
    person.done("remove_property", property=0)
    assert session_data(server)["properties"] == []
    person.done("undo")
    assert session_data(server)["properties"] == ["done is raised within 5 s in forage, A = station"]
    assert "has no property 2: it has 1" in person.say("remove_property", property=1)["error"]
    assert "its flags are done" in person.say("add_property", flag="failed", within_s=5)["error"]


def test_one_can_go_to_where_it_was_promised(server: StudioServer, person: Page) -> None:
    begin(person)
    person.done("reset", seed=3)
    person.done("add_property", flag="done", within_s=5)
    promised = find_drawn_world(server.host.world).snapshot()
    person.done("reset", seed=4)
    person.done("bind_targets", targets={"A": "nearest_food"})
    teach(person, "forward")
    person.done("go_to_property", property=0)
    assert find_drawn_world(server.host.world).snapshot() == promised
    view = server.host.active_trainer.session_view
    assert (view.state, dict(view.targets)) == ("start", {"A": "station"})
    assert server.host.paused


def test_what_a_test_finds(server: StudioServer, person: Page) -> None:
    """Whoever changes goto is told of fetch, which runs it and promised something."""
    begin(person)
    person.done(**FETCH)
    teach(person, "goto")
    person.done("step")
    person.done("step")
    teach(person, "done")
    person.done("restart")
    person.done("add_property", flag="done", within_s=3)
    person.done("save")
    fetch = person.done("test", name="fetch")["test"]
    assert (fetch["works"], fetch["regressions"]) == (True, [])
    assert fetch["properties"][0]["description"] == "done is raised within 3 s in forage"
    assert fetch["properties"][0]["took_s"] > 0
    person.done("open", name="goto")
    person.done("delete", number=3)  # it is never done
    goto = person.done("test", name="goto")["test"]
    assert goto["works"]
    assert goto["differences"] == ["changed since it was saved; fetch runs it"]
    fetch = person.done("test", name="fetch")["test"]
    assert fetch["regressions"] == [
        "property fails: done is raised within 3 s in forage; it holds with the former version of goto"
    ]
    answer = person.done("save")
    assert answer["regressions"] == ["fetch no longer has the property: done is raised within 3 s in forage"]
    assert session_data(server)["unsaved"]
    assert "not saved yet" in server.host.status.text
    assert "worse" not in person.done("save", anyway=True)
    assert not session_data(server)["unsaved"]
    assert person.done("test", name="goto")["test"]["differences"] == [
        "changed since version 1; fetch runs it"
    ]


def test_nothing_is_simpler_before_it_is_kept(server: StudioServer, person: Page) -> None:
    begin(person)
    shown = person.done("simplify")["preview"]
    assert (shown["suggested"], shown["examples_needed"], shown["pruning"]) == (None, 30, 1.0)
    assert shown["leaves"] == {"before": 3, "after": 2}
    (state,) = shown["states"]
    assert state["state"] == "forward"
    assert any(line.startswith("done when") for line in state["before"])
    assert state["after"] == ["stays always"]
    assert [(each["number"], each["before"], each["after"]) for each in shown["decisions"]] == [
        (3, "done", "forward")
    ]
    assert not session_data(server)["unsaved"]
    assert session_data(server)["pruning"] == 0
    person.done("prune", pruning=1)
    assert session_data(server)["pruning"] == 1
    assert [edge["to"] for edge in session_data(server)["edges"]] == ["forward"]
    person.done("undo")
    assert session_data(server)["pruning"] == 0
    assert [edge["to"] for edge in session_data(server)["edges"]] == ["forward", "done"]


def test_those_who_look_on_may_ask_but_not_change(server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as first, open_page(client) as second:
        begin(first)
        looking: list[tuple[str, dict[str, Any]]] = [
            ("why", {}),
            ("test", {"name": "goto"}),
            ("simplify", {}),
        ]
        for do, fields in looking:
            second.done(do, **fields)
        changing: list[tuple[str, dict[str, Any]]] = [
            ("add_property", {"flag": "done", "within_s": 1}),
            ("prune", {"pruning": 1}),
        ]
        for do, fields in changing:
            assert "not in control" in second.say(do, **fields)["error"]


def test_what_changed_is_said_and_shown_before_it_is_saved(server: StudioServer, person: Page) -> None:
    begin(person)
    assert session_data(server)["changed"] is None
    person.done("delete", number=3)  # it is never done
    said = "forward no longer raises done"
    changed = session_data(server)["changed"]
    assert changed["line"] == said
    (change,) = changed["changes"]
    assert (change["state"], change["next"], change["said"]) == ("forward", "done", said)
    assert (len(change["was"]), len(change["now"])) == (1, 0)
    answer = person.done("save")
    assert (answer["regressions"], answer["changed"]["line"]) == ([], said)
    assert server.host.status.text == f"goto is not saved yet: {said}"
    person.done("undo")
    assert session_data(server)["changed"] is None
    person.done("redo")
    assert "changed" not in person.done("save", anyway=True)
    assert not session_data(server)["unsaved"]
