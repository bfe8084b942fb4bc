"""A body of one's own in the studio: its pictures and readings, teaching by presses, and what is refused."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from tests.make.studios import Page, Wall, open_page, serve_studio
from tests.own_worlds import NAME

from understudy.addons.bridges.environments.body_maker import BodyMaker
from understudy.sim.body_world import BodyWorld
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost

CLIMB: dict[str, Any] = {
    "do": "new",
    "name": "climb",
    "states": ["ahead", "back"],
    "features": ["x"],
    "flags": ["done"],
    "live": False,
}


@pytest.fixture
def function() -> str:
    return "make_slope"


@pytest.fixture
def server(tmp_path: Path, function: str) -> StudioServer:
    return make_studio(tmp_path / "mine", function)


def make_studio(folder: Path, function: str) -> StudioServer:
    """A studio with a body that begins at 7 m."""
    maker = BodyMaker(f"{NAME}:{function}")
    world = BodyWorld(maker, 7, name=maker.name)
    host = SessionHost(world.scenario, folder, maker.find_kit(), wall=Wall(), ground=world)
    return StudioServer(host, wall=Wall(glance=0.01))


def see(person: Page) -> list[int]:
    """Wait for the next picture; return its columns that are light."""
    person.picture = None
    while person.picture is None:
        person.hear()
    image = Image.open(BytesIO(person.picture)).convert("L")
    assert image.size == (12, 4)
    return [column for column in range(12) if image.getpixel((column, 0)) > 128]


def test_pictures_follow_the_body(server: StudioServer, person: Page) -> None:
    assert person.scene["drawing"] == "pictures"
    assert (person.scene["width"], person.scene["height"]) == (0.12, 0.04)
    assert see(person) == [7]
    person.done(**CLIMB)
    assert server.host.paused  # its episode may be over in a moment
    person.done("press", state="ahead")
    person.done("step")
    person.done("step")
    while see(person) != [8]:
        pass
    assert person.frame is not None
    assert person.frame.features == [8.0]
    assert person.frame.time_s == 1.0


def test_teaching_ends_with_the_episode_and_begins_again(server: StudioServer, person: Page) -> None:
    person.done(**CLIMB)
    person.done("press", state="ahead")
    for _ in range(6):
        person.done("step")
    assert server.host.status.text == "The episode is over after 3.0 s. Begin a new world, or reset this one"
    assert server.host.paused
    person.done("reset", seed=2)
    assert (server.host.seed, server.host.world.time_s) == (2, 0.0)
    assert len(server.host.active_trainer.session.examples) == 2
    person.done("save")
    assert "climb" in server.host.library_view.library.taught


def test_an_interrupted_session_goes_on(server: StudioServer, tmp_path: Path, function: str) -> None:
    """Its lesson is there again; the body begins anew."""
    with serve_studio(server) as client, open_page(client) as person:
        person.done(**CLIMB)
        person.done("press", state="ahead")
        person.done("step")
    again = make_studio(tmp_path / "mine", function)
    assert list(again.host.cut_off) == ["climb"]
    with serve_studio(again) as client, open_page(client) as person:
        person.done("open", name="climb")
        assert len(again.host.active_trainer.session.examples) == 2
        person.done("press", state="back")
        person.done("step")
        assert len(again.host.active_trainer.session.examples) == 4


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"do": "move_robot", "agent": 0, "x": 0.1, "y": 0.02, "heading": 0.0}, "cannot be changed by hand"),
    ({"do": "add_obstacle", "x": 0.1, "y": 0.02, "radius": 0.1}, "cannot be changed by hand"),
    ({"do": "rewind", "time_s": 0.0}, "cannot be rewound: reset the world instead"),
    (
        {"do": "open_world", "name": "forage", "discard": True},
        "is a body of your own: start the studio again",
    ),
    ({"do": "save_world", "name": "slope"}, "is a body of your own: start the studio again"),
    ({"do": "evaluate", "count": 3}, "test it in other worlds with understudy eval"),
    ({"do": "next_situation"}, "only a robot of a simulated world can be placed"),
]


@pytest.mark.parametrize(("message", "sentence"), REFUSED, ids=[each["do"] for each, _ in REFUSED])
def test_refused(server: StudioServer, person: Page, message: dict[str, Any], sentence: str) -> None:
    person.done(**{**CLIMB, "live": True})
    person.done("press", state="ahead")
    person.done("step")
    assert sentence in person.send(message)["error"]


@pytest.mark.parametrize("function", ["make_plain"])
def test_without_pictures(server: StudioServer, person: Page) -> None:
    assert person.scene["drawing"] == "none"
    assert server.host.picture() is None
