"""Failing worlds in the studio: listed, opened where they go wrong, corrected by a press, run again and ticked off."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.falsification.idle_lesson import make_idle_library
from tests.falsification.kept import keep
from tests.falsification.planted import FORAGE
from tests.make.studios import Page, Wall, open_page, serve_studio

from understudy.addons.checks.falsification.failing_world import FACTS_FILE
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.sim.kit import make_scenario_kit
from understudy.storage.library_folder import save_automaton
from understudy.training.trainee import Mode
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost

SEEDS = {"forage-1": 26, "forage-2": 2, "forage-3": 12, "forage-4": 12}
"""In the first three worlds the robot stops with 11.3, 9.7 and 9.1 m to go, which one press mends."""
LIMITS = {"forage-4": 20.0}
"""Nobody is as fast as that, s."""
MENDED = {"forage-1": "passes", "forage-2": "passes", "forage-3": "passes", "forage-4": "fails"}


def make_failures(folder: Path) -> Path:
    """Keep the failing worlds, and the library in which they fail; return the library's folder."""
    library = make_idle_library()
    for taught in library.taught.values():
        save_automaton(folder / "library", taught)
    for name, seed in SEEDS.items():
        limit_s = LIMITS.get(name, 600.0)
        keep(Trial(FORAGE, seed), folder / "failures" / name, library=library, limit_s=limit_s)
    return folder / "library"


@pytest.fixture
def server(library_with_failures: Path) -> StudioServer:
    return start(library_with_failures.parent)


def start(folder: Path) -> StudioServer:
    """Start a studio in a folder with a library and failing worlds."""
    kit, failures = make_scenario_kit(FORAGE), folder / "failures"
    host = SessionHost(FORAGE, folder / "library", kit, seed=7, wall=Wall(), failures=failures)
    return StudioServer(host, wall=Wall(glance=0.01))


def read_failures(person: Page) -> dict[str, Any]:
    found: dict[str, Any] = person.news["failures"]
    return found


def until(person: Page, holds: Callable[[dict[str, Any]], bool]) -> None:
    """Wait until something holds of the list."""
    while not holds(read_failures(person)):
        person.wait_for_news()


def states(person: Page) -> dict[str, str]:
    """Whether each fails."""
    return {each["name"]: each["state"] for each in read_failures(person)["worlds"]}


def rerun(person: Page) -> dict[str, str]:
    person.done("rerun_failures")
    until(person, lambda found: found["running"])
    until(person, lambda found: not found["running"])
    return states(person)


def test_they_are_listed_with_what_went_wrong(person: Page) -> None:
    worlds = read_failures(person)["worlds"]
    assert {each["name"] for each in worlds} == set(SEEDS)
    assert all((each["state"], each["behavior"]) == ("not run", "forage") for each in worlds)
    assert all("no more progress" in each["sentences"][0] for each in worlds)
    assert read_failures(person)["open"] is None


def test_one_is_opened_corrected_and_ticked_off(person: Page, server: StudioServer) -> None:
    """The press is learned, unsaved; older failures are run again beside it, and one still fails."""
    assert set(rerun(person).values()) == {"fails"}
    person.done("open_failure", name="forage-2")
    trainer = server.host.active_trainer
    assert (trainer.name, trainer.session_view.state, server.host.paused) == ("goto", "start", True)
    assert trainer.session_view.targets == {"A": "station"}
    assert trainer.session_view.features["distance_to(A)"] == pytest.approx(9.66, abs=0.01)
    assert server.host.status.text == (
        "Paused in forage-2, where it goes wrong. Press what goto should do, and resume"
    )
    until(person, lambda found: found["open"] is not None)
    assert (read_failures(person)["open"], read_failures(person)["previous_world"]) == ("forage-2", "forage")
    person.done("press", state="left")
    person.done("step")
    assert trainer.session_view.state == "left"
    assert trainer.has_unsaved_changes
    until(person, lambda found: found["stale"])
    assert rerun(person) == MENDED


def test_doing_nothing_in_one_teaches_nothing(person: Page, server: StudioServer) -> None:
    """It opens in Try: what the robot does there is wrong, and who only looks does not agree to it."""
    person.done("open_failure", name="forage-2")
    session = server.host.active_trainer.session
    examples = len(session.examples)
    assert session.mode is Mode.TESTING
    for _ in range(120):
        person.done("step")
    assert len(session.examples) == examples


def test_what_was_corrected_goes_along_to_the_next_one_and_back(person: Page, server: StudioServer) -> None:
    person.done("open_failure", name="forage-2")
    person.done("press", state="left")
    person.done("step")
    examples = len(server.host.active_trainer.session.examples)
    person.done("open_failure", name="forage-3")
    trainer = server.host.active_trainer
    assert len(trainer.session.examples) == examples
    assert trainer.has_unsaved_changes
    assert trainer.session_view.features["distance_to(A)"] == pytest.approx(9.11, abs=0.01)
    person.done("press", state="left")
    person.done("step")
    assert rerun(person) == MENDED
    person.done("leave_failure")
    assert (server.host.scenario.name, server.host.seed) == ("forage", 7)
    assert len(server.host.active_trainer.session.examples) > examples
    until(person, lambda found: found["open"] is None)
    person.done("save")
    assert rerun(person) == MENDED
    assert "no failing world is open" in person.say("leave_failure")["error"]


@pytest.mark.parametrize("goes_to", ["open_failure", "leave_failure", None])
def test_a_studio_that_ends_in_a_failing_world_loses_no_press(
    person: Page, server: StudioServer, goes_to: str | None
) -> None:
    """The lesson is offered again, also right after it went along to another world."""
    person.done("open_failure", name="forage-2")
    person.done("press", state="left")
    person.done("step")
    if goes_to is not None:
        person.done(goes_to, **({"name": "forage-1"} if goes_to == "open_failure" else {}))
    examples = [str(each) for each in server.host.active_trainer.session.examples]
    server.host.close()
    again = start(server.host.folder.parent)
    with serve_studio(again) as client, open_page(client) as later:
        assert [each["name"] for each in later.news["library"]["interrupted"]] == ["goto"]
        assert "interrupted" in later.say("open_failure", name="forage-1")["error"]
        later.done("open", name="goto")
        assert [str(each) for each in again.host.active_trainer.session.examples] == examples
        later.done("step")


def test_one_that_passes_is_opened_where_it_went_wrong(person: Page, server: StudioServer) -> None:
    person.done("open_failure", name="forage-2")
    person.done("press", state="left")
    person.done("step")
    person.done("open_failure", name="forage-1")
    assert "it passes now" in server.host.status.text


def test_an_unsaved_draft_that_does_not_run_there_is_not_lost(person: Page, server: StudioServer) -> None:
    person.done("new", name="other", states=["forward"], features=["distance_to(A)"], parameters=["A"])
    person.done("press", state="forward")
    person.done("step")
    assert "other has unsaved changes" in person.say("open_failure", name="forage-1")["error"]
    assert server.host.active_trainer.name == "other"
    person.done("open_failure", name="forage-1", discard=True)
    assert server.host.active_trainer.name == "goto"


def test_properties_are_tested_beside(person: Page, server: StudioServer) -> None:
    (server.host.folder / "properties.toml").write_text(
        'understudy = "properties"\nversion = 1\n[stands]\nbehavior = "forage"\nworld = "forage"\nseeds = 2\n'
        'limit_s = 20\nnever = "food_stored is at least 99 units"\n'
    )
    rerun(person)
    (found,) = person.news["properties"]["rows"]
    assert (found["name"], found["verdict"]) == ("stands", "holds")
    assert "no failure in 2 worlds" in found["sentences"][0]
    (server.host.folder / "properties.toml").write_text("[")
    rerun(person)
    assert "properties.toml" in read_failures(person)["problems"][0]


def test_what_cannot_be_read_or_run_is_said(person: Page, server: StudioServer) -> None:
    folder = server.host.failures.folder
    assert folder is not None
    facts = folder / "forage-1" / FACTS_FILE
    facts.write_text(facts.read_text().replace('"behavior": "forage"', '"behavior": "soccer"'))
    (folder / "forage-2" / FACTS_FILE).write_text("{")
    assert rerun(person) == {"forage-1": "unknown", "forage-3": "fails", "forage-4": "fails"}
    assert "soccer" in next(
        each["problem"] for each in read_failures(person)["worlds"] if each["name"] == "forage-1"
    )
    assert "forage-2" in read_failures(person)["problems"][0]
    assert "soccer" in person.say("open_failure", name="forage-1")["error"]
    assert "'forage-9'" in person.say("open_failure", name="forage-9")["error"]


def test_quick_runs_are_repeated_when_the_lesson_changed(person: Page, server: StudioServer) -> None:
    rerun(person)
    person.done("open_failure", name="forage-2")
    person.done("press", state="left")
    person.done("step")
    assert set(states(person).values()) == {"fails"}
    server.host.wall.now += 2.0  # type: ignore[attr-defined]  # the clock of a test
    until(person, lambda _: states(person)["forage-1"] == "passes")
    assert states(person) == MENDED
    assert server.host.status.text == "3 of 4 failing worlds passed"


def test_who_looks_on_may_not_open_one(person: Page, server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as other:
        for asked in ({"do": "open_failure", "name": "forage-1"}, {"do": "rerun_failures"}):
            assert "not in control" in other.say(**asked)["error"]
