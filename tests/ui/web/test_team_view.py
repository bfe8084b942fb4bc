"""A coordinator is trained in the studio as a robot is: chosen in the team, its squad's statistics for features."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from tests.make.studios import Frame, Page, make_studio, to_json
from tests.sim.patrollers import ROBOTS

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
def server(tmp_path: Path) -> StudioServer:
    folder = tmp_path / "library"
    for name in ROBOTS.taught:
        save_automaton(folder, TrainedAutomaton(ROBOTS.automaton(name)))
    return make_studio(folder, world="patrol")


def read_refusal(person: Page, do: str, **fields: Any) -> str:
    """The sentence of a refusal."""
    return str(person.say(do, **fields)["error"])


def test_the_team_is_told(server: StudioServer) -> None:
    (patrol,) = to_json(server.host.scene())["squads"]
    assert (patrol["name"], patrol["squads"]) == ("patrol", [[0, 1, 2, 3]])


def test_directing_a_coordinator_moves_its_squad(server: StudioServer, person: Page) -> None:
    person.done("select_agent", agent=0, sort="patrol")
    behaviors = {behavior["name"] for behavior in to_json(server.host.scene())["behaviors"]}
    assert {"wander", "servo", "forwards"} <= behaviors
    person.done(**LEAD)
    person.done("pause", paused=True)
    person.done("press", state="out")
    person.done("step")
    frame = Frame.read(server.host.frame())
    session = to_json(server.host.session_data())
    assert frame.agent == NONE
    assert {session["activities"][robot[4]] for robot in frame.robots} <= {"forwards", "left", "right"}
    assert session["state"] == "out"
    assert session["examples"][0]["values"] == ["no", "4"]


def test_what_a_squad_was_taught_is_kept_in_its_folder(
    server: StudioServer, person: Page, tmp_path: Path
) -> None:
    person.done("select_agent", agent=0, sort="patrol")
    person.done(**LEAD)
    person.done("pause", paused=True)
    person.done("press", state="out")
    person.done("step")
    assert "unsaved changes" in read_refusal(person, "select_agent", agent=0)
    person.done("save")
    assert (tmp_path / "library" / "patrol" / "lead.json").is_file()
    person.done("select_agent", agent=2)
    assert (server.host.sort, server.host.agent) == (None, 2)
    assert "lead" not in server.host.library_view.library.taught
    assert "wander" in server.host.library_view.library.taught


def test_there_are_only_so_many(server: StudioServer, person: Page) -> None:
    """And what is refused changes nothing."""
    assert "from 1 to 1" in read_refusal(person, "select_agent", agent=1, sort="patrol")
    assert "patrol" in read_refusal(person, "select_agent", agent=0, sort="scouts")
    assert "from 1 to 4" in read_refusal(person, "select_agent", agent=4)
    assert (server.host.sort, server.host.agent) == (None, 0)


def test_what_everybody_knows_has_what_is_trained_as_it_stands(server: StudioServer) -> None:
    groups, mine = server.host.groups, server.host.library_view.library
    robots = groups.collect_libraries(None, 0, mine)
    assert [sort for sort, library in robots.items() if library is mine] == ["pioneer"]
    assert set(groups.collect_libraries("patrol", 0, mine)) == set(robots)
    assert groups.collect_libraries("patrol", 0, mine)["patrol"] is mine


def test_a_coordinator_promises_and_says_why(server: StudioServer, person: Page) -> None:
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
    last = to_json(server.host.session_data())["examples"][-1]["number"]
    person.done("delete", number=last)
    (said,) = person.done("save")["regressions"]
    assert said.startswith("out no longer has the property: done is raised within 1 s in patrol")
