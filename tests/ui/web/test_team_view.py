"""A coordinator is trained in the studio as a robot is: chosen in the team, its squad's statistics for features."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.sim.patrollers import ROBOTS
from tests.ui.web.pages import Frame, Page, page, plain, served, studio

from understudy.model.library import TrainedAutomaton
from understudy.storage.library_folder import save_automaton
from understudy.ui.web.frames import NONE
from understudy.ui.web.server import StudioServer

LEAD: dict[str, Any] = {
    "do": "new",
    "name": "lead",
    "states": ["out=wander", "attack=servo(intruder)"],
    "features": ["someone_sees(intruder)", "present"],
    "flags": [],
}


@pytest.fixture
def made(tmp_path: Path) -> StudioServer:
    folder = tmp_path / "library"
    for name in ROBOTS.taught:
        save_automaton(folder, TrainedAutomaton(ROBOTS.automaton(name)))
    return studio(folder, world="patrol")


@pytest.fixture
def person(made: StudioServer) -> Iterator[Page]:
    with served(made) as client, page(client) as here:
        yield here


def refused(person: Page, do: str, **fields: Any) -> str:
    """The sentence of a refusal."""
    return str(person.say(do, **fields)["error"])


def test_the_team_is_told(made: StudioServer) -> None:
    (patrol,) = plain(made.host.scene())["squads"]
    assert (patrol["name"], patrol["squads"]) == ("patrol", [[0, 1, 2, 3]])


def test_directing_a_coordinator_moves_its_squad(made: StudioServer, person: Page) -> None:
    person.done("select_agent", agent=0, sort="patrol")
    behaviors = {behavior["name"] for behavior in plain(made.host.scene())["behaviors"]}
    assert {"wander", "servo", "forwards"} <= behaviors
    person.done(**LEAD)
    person.done("pause", paused=True)
    person.done("press", state="out")
    person.done("step")
    frame = Frame.read(made.host.frame())
    session = plain(made.host.session_data())
    assert frame.agent == NONE
    assert {session["activities"][robot[4]] for robot in frame.robots} <= {"forwards", "left", "right"}
    assert session["state"] == "out"
    assert session["examples"][0]["values"] == ["no", "4"]


def test_what_a_squad_was_taught_is_kept_in_its_folder(
    made: StudioServer, person: Page, tmp_path: Path
) -> None:
    person.done("select_agent", agent=0, sort="patrol")
    person.done(**LEAD)
    person.done("pause", paused=True)
    person.done("press", state="out")
    person.done("step")
    assert "unsaved changes" in refused(person, "select_agent", agent=0)
    person.done("save")
    assert (tmp_path / "library" / "patrol" / "lead.json").is_file()
    person.done("select_agent", agent=2)
    assert (made.host.sort, made.host.agent) == (None, 2)
    assert "lead" not in made.host.library_view.library.taught
    assert "wander" in made.host.library_view.library.taught


def test_there_are_only_so_many(made: StudioServer, person: Page) -> None:
    """And what is refused changes nothing."""
    assert "from 1 to 1" in refused(person, "select_agent", agent=1, sort="patrol")
    assert "patrol" in refused(person, "select_agent", agent=0, sort="scouts")
    assert "from 1 to 4" in refused(person, "select_agent", agent=4)
    assert (made.host.sort, made.host.agent) == (None, 0)


def test_what_everybody_knows_has_what_is_trained_as_it_stands(made: StudioServer) -> None:
    groups, mine = made.host.groups, made.host.library_view.library
    robots = groups.collect_libraries(None, 0, mine)
    assert [sort for sort, library in robots.items() if library is mine] == ["pioneer"]
    assert set(groups.collect_libraries("patrol", 0, mine)) == set(robots)
    assert groups.collect_libraries("patrol", 0, mine)["patrol"] is mine


def test_a_coordinator_promises_and_says_why(made: StudioServer, person: Page) -> None:
    person.done("select_agent", agent=0, sort="patrol")
    person.done(
        "new", name="out", states=["wander"], features=["someone_sees(intruder)"], flags=["done"], targets={}
    )
    person.done("pause", paused=True)
    for state in ("wander", "done"):
        person.done("press", state=state)
        person.done("step")
    person.done("restart")
    person.done("add_property", flag="done", within_s=1)
    person.done("save")
    tested = person.done("test", name="out")["test"]
    assert (tested["works"], len(tested["properties"])) == (True, 1)
    (level,) = person.done("why")["levels"]
    assert (level["automaton"], level["decision"]) == ("out", "It goes from start to wander, always.")
    last = plain(made.host.session_data())["examples"][-1]["number"]
    person.done("delete", number=last)
    (said,) = person.done("save")["regressions"]
    assert said.startswith("out no longer has the property: done is raised within 1 s in patrol")
