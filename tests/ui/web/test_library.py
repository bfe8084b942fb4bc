"""The library through messages: saving, copies, the trash, opening again, which robot, and what stays in the folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from tests.make.studios import GOTO, Page, make_studio, open_page, serve_studio, teach, to_json
from tests.ui.cli.commands import run

from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost
from understudy.ui.web.views.library import save_copy

CARRY: dict[str, Any] = {
    "do": "new",
    "name": "carry",
    "states": ["goto(station)", "unload_food"],
    "features": ["done", "food_stored"],
}


@pytest.fixture
def server(tmp_path: Path) -> StudioServer:
    return make_studio(tmp_path / "library", world="forage-team")


def names(host: SessionHost) -> list[str]:
    return [row["name"] for row in to_json(host.library())["trained"]]


def files(host: SessionHost) -> list[str]:
    folder = host.library_view.folder
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*.json"))


def test_unsaved_work_is_not_left_by_accident(server: StudioServer, person: Page) -> None:
    person.done(**GOTO)
    teach(person, "forward")
    assert "unsaved changes" in person.send({**GOTO, "name": "other"})["error"]
    assert server.host.active_trainer.name == "goto"
    person.done("save")
    person.done(**{**GOTO, "name": "other"})
    teach(person, "rotate_left")
    assert "unsaved changes" in person.say("open", name="goto")["error"]
    person.done("open", name="goto", discard=True)
    assert server.host.active_trainer.session_view.examples == 2
    assert "Opened goto" in server.host.status.text


def test_a_copy_under_another_name(server: StudioServer, person: Page) -> None:
    person.done(**GOTO)
    teach(person, "forward")
    person.done("save", name="goto 2")
    assert names(server.host) == ["goto 2"]
    assert server.host.active_trainer.name == "goto"
    assert server.host.active_trainer.has_unsaved_changes
    assert "already" in person.say("save", name="Goto 2")["error"]
    person.done("save")
    person.done("open", name="goto 2")
    assert server.host.active_trainer.name == "goto 2"
    assert server.host.active_trainer.session_view.examples == 2


def test_nothing_leaves_the_folder(server: StudioServer, person: Page) -> None:
    person.done(**GOTO)
    teach(person, "forward")
    for name in ("../../escaped", "/etc/understudy"):
        assert "cannot be the name" in person.say("save", name=name)["error"]
        taught = server.host.active_trainer.session.make_trained_automaton()
        save_copy(server.host.library_view, taught, name)  # as a program may
    assert files(server.host) == ["%2E%2E%2F%2E%2E%2Fescaped.json", "%2Fetc%2Funderstudy.json"]
    person.done("remove", name="../../escaped")
    assert files(server.host) == ["%2Fetc%2Funderstudy.json", ".trash/%2E%2E%2F%2E%2E%2Fescaped.json"]
    assert to_json(server.host.library())["trash"] == ["../../escaped"]
    assert sorted(path.name for path in server.host.library_view.folder.parent.iterdir()) == ["library"]


def test_the_trash_gives_back_what_was_removed_last(server: StudioServer, person: Page) -> None:
    person.done(**GOTO)
    assert "being trained" in person.say("remove", name="goto")["error"]
    for states in (["forward"], ["forward", "rotate_left"]):
        teach(person, *states)
        person.done("save", name="copy")
        person.done("remove", name="copy")
    assert files(server.host) == [".trash/copy.json", ".trash/copy~2.json"]
    person.done("restore", name="copy")
    assert "already" in person.say("restore", name="copy")["error"]
    assert files(server.host) == [".trash/copy.json", "copy.json"]
    (row,) = to_json(server.host.library())["trained"]
    assert row["examples"] == server.host.active_trainer.session_view.examples


def test_what_is_run_by_others_is_not_removed(server: StudioServer, person: Page) -> None:
    person.done(**GOTO)
    teach(person, "forward")
    person.done("save")
    person.done(**CARRY)
    assert "which is being trained, uses goto" in person.say("remove", name="goto")["error"]
    teach(person, "goto")
    person.done("save")
    assert [row["runs"] for row in to_json(server.host.library())["trained"]] == [
        ["goto(station)", "unload_food"],
        ["forward", "rotate_left", "rotate_right"],
    ]
    person.done(**{**GOTO, "name": "third"})
    assert "is used by carry" in person.say("remove", name="goto")["error"]
    person.done("remove", name="carry")
    person.done("remove", name="goto")
    person.done("restore", name="carry")
    (row,) = to_json(server.host.library())["trained"]
    assert not row["complete"]
    assert "goto" in row["problem"]


def test_a_broken_document_hides_nothing(server: StudioServer, person: Page) -> None:
    person.done(**GOTO)
    teach(person, "forward")
    person.done("save")
    (server.host.library_view.folder / "broken.json").write_text("{")
    person.done("save")
    rows = {row["name"]: row for row in to_json(server.host.library())["trained"]}
    assert rows["goto"]["complete"]
    assert not rows["broken"]["complete"]
    assert rows["broken"]["problem"] in person.say("open", name="broken")["error"]
    assert "already" in person.send({**GOTO, "name": "broken"})["error"]
    person.done("remove", name="broken")


def test_which_robot_is_trained(server: StudioServer, person: Page) -> None:
    person.done("select_agent", agent=1)
    person.done(**GOTO)
    assert server.host.active_trainer.robot == 1
    person.done("select_agent", agent=2)
    assert server.host.active_trainer.robot == 2
    assert server.host.active_trainer.name == "goto"
    teach(person, "forward")
    assert "robot 3" in person.say("select_agent", agent=0)["error"]
    person.done("save")
    person.done("open", name="goto")
    person.done("select_agent", agent=0)
    assert server.host.active_trainer.robot == 0
    assert server.host.active_trainer.session_view.examples == 2


def test_the_world_by_hand(server: StudioServer, person: Page) -> None:
    person.done(**GOTO)
    person.done("pause", paused=True)
    discs = len(person.scene["discs"])
    person.done("move_robot", agent=1, x=2.0, y=2.0, heading=None)
    person.done("add_obstacle", x=5.0, y=9.0, radius=0.3)
    while len(person.scene["discs"]) == discs:
        person.hear()
    assert person.scene["discs"][-1:] == [{"x": 5.0, "y": 9.0, "radius": 0.3, "color": None}]
    slots = [row[0] for row in person.frame.objects] if person.frame else []
    person.done("move_object", slot=slots[0], x=9.0, y=9.5)
    person.done("remove_object", slot=slots[1])
    person.done("step")
    while person.frame is None or person.frame.tick != 1:
        person.hear()
    assert person.frame.robots[1][:2] == (2.0, 2.0)
    assert (slots[0], 9.0, 9.5) in [(row[0], *row[2:4]) for row in person.frame.objects]
    assert slots[1] not in [row[0] for row in person.frame.objects]
    assert "overlaps" in person.say("move_robot", agent=0, x=5.0, y=9.0)["error"]
    person.done("move_obstacle", index=discs, x=5.0, y=11.0)
    person.done("move_robot", agent=0, x=5.0, y=9.0)
    person.done("remove_obstacle", index=discs)
    while len(person.scene["discs"]) > discs:
        person.hear()


def test_choosing_anew_keeps_the_examples(server: StudioServer, person: Page) -> None:
    person.done(**GOTO)
    teach(person, "forward", "rotate_left")
    person.done(
        "change_design", states=["forward", "rotate_left"], features=["angle_to(A)"], flags=[], reaction_s=0.2
    )
    session = to_json(server.host.session_data())
    assert session is not None
    assert [state["name"] for state in session["states"]] == ["start", "forward", "rotate_left"]
    assert [feature["label"] for feature in session["features"]] == ["angle_to(A)"]
    assert (session["reaction_s"], session["watched"], session["presses"]) == (0.2, False, 4)
    person.done("edit", number=1, next="rotate_left")
    assert person.done("why")["levels"]
    person.done("delete", number=2)
    person.done("undo")
    person.done("redo")
    assert [each["number"] for each in to_json(server.host.session_data())["examples"]] == [1, 3, 4]


def test_the_automata_it_runs_are_told_with_their_states_and_transitions(
    server: StudioServer, person: Page
) -> None:
    person.done(**GOTO)
    teach(person, "forward", "done")
    person.done("save")
    person.done(**CARRY)
    session = to_json(server.host.session_data())
    assert [state["automaton"] for state in session["states"]] == [None, "goto", None]
    goto = session["nested"]["goto"]
    assert [state["name"] for state in goto["states"]][-1] == "done"
    assert goto["states"][-1]["flag"]
    assert ("start", "forward") in [(edge["from"], edge["to"]) for edge in goto["edges"]]
    assert all(edge["when"] for edge in goto["edges"])


def test_contradictions_are_marked(server: StudioServer, person: Page) -> None:
    person.done(**{**GOTO, "features": ["at_station"], "parameters": [], "targets": {}})
    teach(person, "forward")
    person.done("restart")
    teach(person, "rotate_left")
    session = to_json(server.host.session_data())
    assert [(each["number"], each["contradicts"]) for each in session["examples"]] == [
        (1, True),
        (2, False),
        (3, True),
        (4, False),
    ]
    (edge,) = session["edges"]
    assert edge == {"from": "start", "to": "forward", "when": ["always"], "examples": [1]}


def test_speed_and_time(server: StudioServer, person: Page) -> None:
    person.done("speed", speed=4)
    person.done(**GOTO)
    assert server.host.active_trainer.pace.speed == 4
    assert not server.host.paused
    server.host.wall.now += 0.2  # type: ignore[attr-defined]
    while person.frame is None or person.frame.tick < 8:
        person.hear()
    assert person.frame.tick == 8


def test_a_session_that_was_cut_off_is_offered(tmp_path: Path) -> None:
    folder = tmp_path / "library"
    with serve_studio(make_studio(folder, seed=3)) as client, open_page(client) as person:
        person.done(**GOTO)
        person.done("move_robot", agent=0, x=6.0, y=6.5, heading=1.0)
        teach(person, "forward", "rotate_left")
    assert files(make_studio(folder).host) == []  # not saved
    again = make_studio(folder)
    with serve_studio(again) as client, open_page(client) as person:
        (left,) = person.news["library"]["interrupted"]
        assert (left["name"], left["examples"]) == ("goto", 4)
        assert "interrupted with 4 examples" in person.send(GOTO)["error"]
        person.done("open", name="goto")
        assert again.host.seed == 3
        assert to_json(again.host.library())["interrupted"] == []
        robots = again.host.world.view().robots
        assert (robots.x[0], robots.y[0]) == pytest.approx((6.0, 6.5), abs=0.1)
        assert again.host.paused
        person.done("reset", seed=None)
        assert again.host.seed == 3
    last = make_studio(folder)
    with serve_studio(last) as client, open_page(client) as person:
        person.done(**{**GOTO, "discard": True})
        assert to_json(last.host.library())["interrupted"] == []
        assert sorted(path.suffix for path in (folder / ".journals").iterdir()) == [".ended", ".journal"]


def test_a_session_that_was_saved_is_not_offered(tmp_path: Path) -> None:
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as person:
        person.done(**GOTO)
        teach(person, "forward")
        person.done("save")
    assert make_studio(tmp_path).host.cut_off == {}
    assert [path.suffix for path in (tmp_path / ".journals").iterdir()] == [".ended"]


def test_a_session_that_was_cut_off_is_thrown_away(tmp_path: Path) -> None:
    """What was saved can be opened then; and there is a way back."""
    folder = tmp_path / "library"
    with serve_studio(make_studio(folder)) as client, open_page(client) as person:
        person.done(**GOTO)
        teach(person, "forward")
        person.done("save")
        teach(person, "rotate_left")
    again = make_studio(folder)
    with serve_studio(again) as client, open_page(client) as person:
        assert list(again.host.cut_off) == ["goto"]
        assert "no automaton 'reach'" in person.say("discard", name="reach")["error"]
        person.done("discard", name="goto")
        assert to_json(again.host.library())["interrupted"] == []
        person.done("recall", name="goto")
        assert list(again.host.cut_off) == ["goto"]
        assert "goto" in person.say("recall", name="goto")["error"]
        person.done("discard", name="goto")
        person.done("open", name="goto")
        assert again.host.active_trainer.session_view.examples == 2


def test_what_was_learned_from_a_recording_opens_where_its_readings_are(tmp_path: Path) -> None:
    """The robots of this world have no gap; the sentence says what works."""
    table = tmp_path / "near.csv"
    table.write_text(
        "state,next,kind,gap:continuous\nrun,run,default,3\nrun,stop,directive,1\nstop,stop,default,1\n"
    )
    assert run("learn", "table", table, "--library", tmp_path / "library", "--name", "near").exit_code == 0
    with (
        serve_studio(make_studio(tmp_path / "library", world="forage-team")) as client,
        open_page(client) as page,
    ):
        said = page.say("open", name="near")["error"]
    assert "near was learned from a recording or a table, and this robot has no gap" in said
    assert "understudy replay FILE" in said
