"""Other names, copies and former versions of what is in the library."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from tests.make.studios import GOTO, Page, open_page, serve_studio, teach, to_json
from tests.ui.web.test_library import CARRY, files, names

from understudy.storage.library_folder import list_versions
from understudy.ui.web.server import StudioServer


@pytest.fixture
def person(server: StudioServer) -> Iterator[Page]:
    with serve_studio(server) as client, open_page(client) as here:
        here.done(**GOTO)
        teach(here, "forward")
        here.done("save")
        yield here


def test_what_is_trained_has_another_name(server: StudioServer, person: Page) -> None:
    """It goes on under the new one, its former versions with it."""
    teach(person, "rotate_left")
    assert "save it first" in person.say("rename", name="goto", to="reach")["error"]
    person.done("save")
    person.done("bind_targets", targets={"A": "nearest_food"})
    examples = server.host.active_trainer.session_view.examples
    person.done("rename", name="goto", to="reach")
    assert names(server.host) == ["reach"]
    assert [path[:19] for path in files(server.host)] == ["reach.json", "versions/reach/0001"]
    trainer = server.host.active_trainer
    assert (trainer.name, trainer.session_view.examples, trainer.session_view.targets["A"]) == (
        "reach",
        examples,
        "nearest_food",
    )
    assert (trainer.has_unsaved_changes, trainer.paused, trainer.status.text) == (
        False,
        True,
        "Renamed goto to reach",
    )
    teach(person, "forward")
    person.done("save")
    assert names(server.host) == ["reach"]
    assert [each.number for each in list_versions(server.host.library_view.folder, "reach")] == [1, 2]


def test_versions_go_behind_those_of_a_former_one(server: StudioServer, person: Page) -> None:
    person.done("duplicate", name="goto", to="reach")
    person.done("open", name="reach")
    teach(person, "rotate_left")
    person.done("save")
    person.done(**{**GOTO, "name": "other"})
    person.done("remove", name="reach")
    person.done("open", name="goto")
    teach(person, "rotate_right")
    person.done("save")
    person.done("rename", name="goto", to="reach")
    kept = person.done("list_versions", name="reach")["versions"]
    assert [each["number"] for each in kept] == [2, 1]
    assert all(each["saved"] for each in kept)


def test_what_others_run_keeps_its_name(server: StudioServer, person: Page) -> None:
    person.done(**{**CARRY, "states": ["goto(station)"]})
    assert "carry uses goto" in person.say("rename", name="goto", to="reach")["error"]
    teach(person, "goto")
    person.done("save")
    assert "carry uses goto" in person.say("rename", name="goto", to="reach")["error"]
    person.done("rename", name="carry", to="bring")
    assert names(server.host) == ["bring", "goto"]


@pytest.mark.parametrize("do", ["rename", "duplicate"])
def test_names_that_cannot_be(server: StudioServer, person: Page, do: str) -> None:
    person.done("duplicate", name="goto", to="twin")
    before = files(server.host)
    assert "twin already" in person.say(do, name="goto", to="Twin")["error"]
    assert "basic behavior" in person.say(do, name="goto", to="forward")["error"]
    assert "no automaton" in person.say(do, name="nobody", to="body")["error"]
    (server.host.library_view.folder / "broken.json").write_text("{")
    assert "broken.json" in person.say(do, name="broken", to="whole")["error"]
    (server.host.library_view.folder / "broken.json").unlink()
    assert files(server.host) == before


NO_NAMES = ["a/b", "../twin", "start", "1", "2go", " go", "go*", "a\\b"]


@pytest.mark.parametrize("name", NO_NAMES)
@pytest.mark.parametrize("do", ["rename", "duplicate", "save", "new"])
def test_names_that_are_none(server: StudioServer, person: Page, do: str, name: str) -> None:
    """A path, the start state, a number: refused wherever an automaton gets a name."""
    before = files(server.host)
    fields = {"rename": {"name": "goto", "to": name}, "duplicate": {"name": "goto", "to": name}}
    asked = fields.get(do, {"name": name} if do == "save" else {**GOTO, "name": name})
    problem = person.say(**{"do": do, **asked})["error"]
    assert repr(name) in problem
    assert "starts with a letter" in problem or "start state" in problem
    assert files(server.host) == before


@pytest.mark.parametrize("field", ["parameters", "flags"])
@pytest.mark.parametrize("name", ["1", "a/b", "start"])
def test_parameters_and_flags_have_names(server: StudioServer, person: Page, field: str, name: str) -> None:
    asked = {**GOTO, "name": "other", field: [name], "targets": {}, "features": ["distance_to(station)"]}
    assert repr(name) in person.say(**asked)["error"]
    assert server.host.active_trainer.name == "goto"


@pytest.mark.parametrize("name", ["go to", "goto-2", "bring_home", "Ärger", "goto2"])
def test_names_that_can_be(server: StudioServer, person: Page, name: str) -> None:
    person.done("duplicate", name="goto", to=name)
    assert name in names(server.host)


def test_a_copy_is_as_the_library_has_it(server: StudioServer, person: Page) -> None:
    teach(person, "rotate_left")
    person.done("duplicate", name="goto", to="twin")
    assert files(server.host) == ["goto.json", "twin.json"]
    rows = {row["name"]: row["examples"] for row in to_json(server.host.library())["trained"]}
    assert rows["twin"] == rows["goto"] == 2
    assert server.host.active_trainer.has_unsaved_changes


def test_versions_and_what_changed(server: StudioServer, person: Page) -> None:
    assert person.done("list_versions", name="goto")["versions"] == []
    for state in ("rotate_left", "rotate_right"):
        teach(person, state)
        person.done("save")
    assert [each["number"] for each in person.done("list_versions", name="goto")["versions"]] == [2, 1]
    ((topic, lines),) = [
        (each["topic"], each["lines"])
        for each in person.done("diff_versions", name="goto", version=1, to=2)["changes"]
        if each["topic"] == "examples"
    ]
    assert topic == "examples"
    assert [line[:2] for line in lines] == ["+ ", "+ "]
    assert "go to rotate_left (directive)" in lines[0]
    since = person.done("diff_versions", name="goto", version=1)
    assert len(next(each for each in since["changes"] if each["topic"] == "examples")["lines"]) == 4
    (appeared,) = (
        each for each in since["moved"] if (each["from"], each["to"]) == ("forward", "rotate_left")
    )
    assert (appeared["what"], appeared["gone"], len(appeared["new"])) == ("appeared", [], 1)
    assert {"number": 3, "happened": "new", "how": "shows it"} in appeared["examples"], appeared
    assert "no version '7'" in person.say("diff_versions", name="goto", version=7)["error"]


def test_back_to_a_version_and_forth(server: StudioServer, person: Page) -> None:
    teach(person, "rotate_left")
    assert "save it first" in person.say("go_back", name="goto", version=1)["error"]
    person.done("save")
    person.done("go_back", name="goto", version=1)
    assert server.host.active_trainer.session_view.examples == 2
    assert not server.host.active_trainer.has_unsaved_changes
    assert "version 1" in server.host.status.text
    person.done("go_back", name="goto", version=2)
    assert server.host.active_trainer.session_view.examples == 4
    assert [each.number for each in list_versions(server.host.library_view.folder, "goto")] == [1, 2, 3]
    person.done("rename", name="goto", to="reach")
    person.done("go_back", name="reach", version=1)
    assert (server.host.active_trainer.name, server.host.active_trainer.session_view.examples) == ("reach", 2)
    assert names(server.host) == ["reach"]


def test_who_looks_on_may_read_versions(server: StudioServer, person: Page) -> None:
    with serve_studio(server) as client, open_page(client) as other:
        assert other.done("list_versions", name="goto")["versions"] == []
        assert "not in control" in other.say("rename", name="goto", to="reach")["error"]


def test_a_copy_can_be_used_at_once(server: StudioServer, person: Page) -> None:
    person.done(**{**CARRY, "states": ["goto(station)"]})
    assert "twin" in person.say("change_design", states=["twin(station)"], features=["done"])["error"]
    person.done("duplicate", name="goto", to="twin")
    person.done("change_design", states=["twin(station)", "goto(station)"], features=["done"])
    teach(person, "twin", "goto")
    person.done("save")
    assert to_json(server.host.library())["trained"][0]["runs"] == ["twin(station)", "goto(station)"]


@pytest.mark.parametrize("name", ["goto 2", "go to it", "x" * 150])
def test_any_name_can_be_chosen_as_a_state(server: StudioServer, person: Page, name: str) -> None:
    person.done("duplicate", name="goto", to=name)
    person.done(**{**CARRY, "states": [f"{name}(nearest_food)"]})
    teach(person, name)
    assert server.host.active_trainer.session_view.state == name


@pytest.mark.parametrize("name", ["goto(A)", "a,b", "a=b"])
def test_a_name_that_could_not_is_refused(server: StudioServer, person: Page, name: str) -> None:
    for way in ({"do": "duplicate", "name": "goto", "to": name}, {"do": "save", "name": name}):
        assert "cannot be the name of a state" in person.send(way)["error"]
    assert "cannot be the name of a state" in person.send({**GOTO, "name": name})["error"]
    assert names(server.host) == ["goto"]
