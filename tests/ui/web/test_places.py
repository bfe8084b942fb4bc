"""Other worlds and libraries are chosen on the page, and a world that was edited is saved as a scenario."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.make.studios import GOTO, Page, make_studio, open_page, serve_studio, teach
from tests.ui.web.test_library import names

from understudy.sim.scenario.files import load_scenario
from understudy.ui.web.places import DOCUMENT
from understudy.ui.web.server import StudioServer


@pytest.fixture
def server(tmp_path: Path) -> StudioServer:
    return make_studio(tmp_path / "mine", seed=3)


@pytest.fixture
def person(server: StudioServer) -> Iterator[Page]:
    """Somebody who has saved goto, and goes on teaching it."""
    with serve_studio(server) as client, open_page(client) as here:
        here.done(**GOTO)
        teach(here, "forward")
        here.done("save")
        yield here


def places(person: Page) -> dict[str, Any]:
    """What can be chosen, as the page has it now."""
    found: dict[str, Any] = person.news["places"]
    return found


def test_what_can_be_chosen(server: StudioServer, person: Page, tmp_path: Path) -> None:
    (tmp_path / "pictures").mkdir()
    (tmp_path / "pictures" / "notes.json").write_text("{}")
    found = places(person)
    assert (found["world"], found["library"], found["can_save"]) == ("forage", "mine", True)
    assert {"forage", "arena", "soccer"} <= set(found["worlds"])
    assert found["libraries"] == ["mine"]


def test_another_world_and_back(server: StudioServer, person: Page) -> None:
    """What is trained goes along where the other world has all that it needs; the seed stays."""
    person.done("open_world", name="rooms")
    assert (server.host.scenario.name, server.host.seed) == ("rooms", 3)
    while person.scene["scenario"] != "rooms":
        person.hear()
    person.done("open_world", name="forage")
    assert server.host.scenario.name == "forage"
    assert "goto" in names(server.host)
    person.done("open", name="goto")
    teach(person, "rotate_left")


def test_what_is_trained_goes_along(server: StudioServer, person: Page) -> None:
    person.done("save_world", name="yard")
    person.done("open_world", name="yard")
    assert server.host.active_trainer.name == "goto"
    assert server.host.status.text == "World yard: goto is opened here"
    teach(person, "rotate_left")
    person.done("undo")


@pytest.mark.parametrize(
    "asked", [{"do": "open_world", "name": "arena"}, {"do": "open_library", "name": "other"}]
)
def test_unsaved_changes_are_not_left_behind(
    server: StudioServer, person: Page, asked: dict[str, Any]
) -> None:
    teach(person, "rotate_left")
    examples = len(server.host.active_trainer.session.examples)
    assert "unsaved changes" in person.say(**asked)["error"]
    assert len(server.host.active_trainer.session.examples) == examples
    person.done(**asked, discard=True)


def test_a_new_library_and_the_old_one(server: StudioServer, person: Page, tmp_path: Path) -> None:
    person.done("open_library", name="other")
    assert names(server.host) == []
    assert not (tmp_path / "other").exists()  # until something is saved
    person.done(**GOTO)
    teach(person, "forward", "rotate_left")
    person.done("save")
    assert (tmp_path / "other" / "goto.json").is_file()
    person.done("open_library", name="mine")
    assert server.host.active_trainer.name == "goto"
    assert server.host.active_trainer.folder == tmp_path / "mine"
    assert len(server.host.active_trainer.session.examples) == 2
    while places(person)["library"] != "mine":
        person.hear()
    assert places(person)["libraries"] == ["mine", "other"]


def test_a_pipe_is_no_document_of_a_library(server: StudioServer, tmp_path: Path) -> None:
    """A studio that opened it would wait without end; here the pipe has an end, so that the test fails instead."""
    (tmp_path / "pipes").mkdir()
    os.mkfifo(tmp_path / "pipes" / "goto.json")
    pipe = os.open(tmp_path / "pipes" / "goto.json", os.O_RDWR)
    try:
        os.write(pipe, DOCUMENT * 100)
        assert server.host.places.list_libraries(tmp_path / "mine") == ["mine"]
    finally:
        os.close(pipe)


@pytest.mark.parametrize("name", ["../elsewhere", "/etc", "a/b", "1"])
def test_a_library_stays_beside_the_first(
    server: StudioServer, person: Page, tmp_path: Path, name: str
) -> None:
    before = sorted(tmp_path.rglob("*"))
    assert "cannot be the name of a library" in person.say("open_library", name=name)["error"]
    (tmp_path / "pictures").mkdir()
    assert "is there already" in person.say("open_library", name="pictures")["error"]
    (tmp_path / "pictures").rmdir()
    assert sorted(tmp_path.rglob("*")) == before


def test_an_edited_world_is_saved_and_offered(server: StudioServer, person: Page, tmp_path: Path) -> None:
    person.done("add_obstacle", x=6.0, y=6.0, radius=0.4)
    person.done("save_world", name="yard")
    while "yard" not in places(person)["worlds"]:
        person.hear()
    scenario = load_scenario(tmp_path / "scenarios" / "yard.toml")
    assert [each.radius for each in scenario.obstacles] == [0.4]
    assert scenario.about == "Saved in the studio: forage, world 3, as it stood then."
    person.done("open_world", name="yard", discard=True)
    person.done("reset", seed=8)
    assert server.host.world.view().discs.x.tolist() == [6.0]


@pytest.mark.parametrize(
    ("name", "problem"),
    [("yard", "already"), ("YARD", "already"), ("forage", "already"), ("../yard", "cannot be the name")],
)
def test_no_world_is_overwritten(
    server: StudioServer, person: Page, tmp_path: Path, name: str, problem: str
) -> None:
    person.done("save_world", name="yard")
    before = (tmp_path / "scenarios" / "yard.toml").read_bytes()
    person.done("add_obstacle", x=6.0, y=6.0, radius=0.4)
    assert problem in person.say("save_world", name=name)["error"]
    assert (tmp_path / "scenarios" / "yard.toml").read_bytes() == before
    assert [path.name for path in (tmp_path / "scenarios").glob("*.toml")] == ["yard.toml"]


def test_a_world_that_cannot_be_read_leaves_all_as_it_is(
    server: StudioServer, person: Page, tmp_path: Path
) -> None:
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios" / "broken.toml").write_text("size = 3")
    assert "broken.toml" in person.say("open_world", name="broken")["error"]
    assert "no world" in person.say("open_world", name="nowhere")["error"]
    assert (server.host.scenario.name, server.host.active_trainer.name) == ("forage", "goto")
