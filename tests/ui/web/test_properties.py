"""Properties at the page: added, changed and deleted in the library's file, checked as the file is, tested at once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.falsification.idle_lesson import make_idle_library
from tests.falsification.planted import FORAGE
from tests.make.studios import Page, Wall, open_page, serve_studio

from understudy import Library
from understudy.judging.properties.condition import parse_condition
from understudy.judging.properties.condition_examples import list_condition_examples
from understudy.judging.properties.margins import bind_condition
from understudy.judging.properties.property_file import load_properties
from understudy.judging.properties.run_property import make_property_task
from understudy.model.property import Property, PropertyKind, SeededWorlds
from understudy.sim.catalog import find_scenario, list_scenarios
from understudy.sim.kit import make_scenario_kit
from understudy.sim.world import World
from understudy.storage.library_folder import save_automaton
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost

NEVER: dict[str, Any] = {
    "kind": "never",
    "condition": "delivered is at least 99 units",
    "seconds": None,
    "behavior": "forage",
    "targets": {},
    "world": "forage",
    "seeds": "3",
    "limit_s": 20.0,
    "at_least": None,
}
BY_HAND = """\
# ours
understudy = "properties"
version = 1

[by-hand]  # of an old meeting
behavior = "goto"
targets = { A = "station" }
world = "forage"
seeds = [
  4,  # the far one
  7,
]
always = "done is raised"
within_s = 0.5
"""


@pytest.fixture
def server(tmp_path: Path) -> StudioServer:
    for taught in make_idle_library().taught.values():
        save_automaton(tmp_path / "library", taught)
    host = SessionHost(FORAGE, tmp_path / "library", make_scenario_kit(FORAGE), seed=7, wall=Wall())
    return StudioServer(host, wall=Wall(glance=0.01))


@pytest.fixture
def file(server: StudioServer) -> Path:
    return server.host.folder / "properties.toml"


def read_properties(person: Page) -> dict[str, Any]:
    found: dict[str, Any] = person.news["properties"]
    return found


def until(person: Page, holds: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    while not holds(read_properties(person)):
        person.wait_for_news()
    return read_properties(person)


def row(person: Page, name: str, *verdicts: str) -> dict[str, Any]:
    """Wait until a property has one of these verdicts."""
    found: dict[str, Any] = next(
        each
        for each in until(
            person,
            lambda now: any(each["name"] == name and each["verdict"] in verdicts for each in now["rows"]),
        )["rows"]
        if each["name"] == name
    )
    return found


def test_one_is_added_and_tested_at_once(person: Page, server: StudioServer, file: Path) -> None:
    assert read_properties(person) == {"problem": "", "rows": [], "testing": None, "finished": 0, "total": 1}
    person.done("save_property", name="few", fields=NEVER)
    found = row(person, "few", "holds")
    assert found["sentences"] == ["no failure in 3 worlds: it fails in at most 63.2 % of worlds, at 95 %"]
    assert (found["claim"], found["fields"], found["stale"]) == (f"never {NEVER['condition']}", NEVER, False)
    (kept,) = load_properties(file)
    assert (kept.what, kept.start.limit_s, kept.behavior) == (NEVER["condition"], 20.0, "forage")
    assert file.read_text().endswith('seeds = 3\nnever = "delivered is at least 99 units"\nlimit_s = 20\n')


def test_one_that_a_person_wrote_is_changed_and_keeps_its_comments(
    person: Page, server: StudioServer, file: Path
) -> None:
    file.write_text(BY_HAND)
    person.done("test_properties")
    found = row(person, "by-hand", "fails")
    assert "2 of 2 worlds failed" in found["sentences"][0]
    fields = found["fields"] | {"seconds": 600.0, "at_least": 0.2}
    assert (fields["kind"], fields["seeds"], fields["targets"]) == ("always", "[4, 7]", {"A": "station"})
    person.done("save_property", name="by-hand", fields=fields, changes=True)
    assert file.read_text() == BY_HAND.replace("0.5", "600") + "at_least = 0.2\n"
    until(person, lambda now: now["rows"][0]["fields"]["seconds"] == 600.0)
    person.done("save_property", name="few", fields=NEVER)
    person.done("delete_property", name="few")
    assert file.read_text() == BY_HAND.replace("0.5", "600") + "at_least = 0.2\n"
    person.done("delete_property", name="by-hand")
    assert file.read_text() == BY_HAND[: BY_HAND.index("\n[by-hand]")]
    until(person, lambda now: now["rows"] == [])


MISTAKES: list[
    tuple[dict[str, Any], str, str]
] = [  # the fields, the one with the mistake, words of the sentence
    ({"condition": ""}, "condition", "never: '' cannot be understood"),
    ({"condition": "front is below"}, "condition", "cannot be understood"),
    (
        {"condition": "distance_to(station) is below 1"},
        "condition",
        "has no unit, but distance_to(station) is in m",
    ),
    ({"condition": "moon is below 1 m"}, "condition", "has no feature or reading 'moon'"),
    ({"condition": "robot is in pit"}, "condition", "has no region 'pit'"),
    ({"kind": "always"}, "seconds", "within_s: is missing; give the time in s"),
    ({"kind": "never longer"}, "seconds", "never_longer_than_s: is missing"),
    ({"kind": "progress", "seconds": -1.0}, "seconds", "is -1; give seconds above 0"),
    ({"kind": "always", "seconds": 5.0}, "limit_s", "is not needed: within_s is the limit"),
    ({"behavior": "soccer"}, "behavior", "'soccer'"),
    ({"behavior": "goto"}, "behavior", "A"),
    ({"behavior": "goto", "targets": {"A": "moon"}}, "behavior", "'moon'"),
    ({"world": "moon"}, "world", "has no world 'moon'"),
    ({"world": "../../secret.toml"}, "world", "has no world"),
    ({"seeds": "many"}, "seeds", "seeds: are 'many'; give their number"),
    ({"seeds": ""}, "seeds", "are missing"),
    ({"seeds": "2\nx = 3"}, "seeds", ""),
    ({"seeds": "0"}, "seeds", "are 0"),
    ({"seeds": "[1, 1]"}, "seeds", "are not all different"),
    ({"at_least": 2.0}, "at_least", "is 2; give a share between 0 and 1"),
    ({"limit_s": 0.0}, "limit_s", "is 0; give seconds above 0"),
]


@pytest.mark.parametrize(("fields", "field", "words"), MISTAKES)
def test_a_mistake_is_shown_at_its_field_and_nothing_is_written(
    person: Page, file: Path, fields: dict[str, Any], field: str, words: str
) -> None:
    file.write_text(BY_HAND)
    answer = person.say("save_property", name="few", fields=NEVER | fields)
    if words:
        assert (answer["field"], words in answer["mistake"]) == (field, True), answer
        assert "properties.toml" not in answer["mistake"]
        assert "\n" not in answer["mistake"]
    else:
        assert "matching regex" in answer["error"]
    assert file.read_text() == BY_HAND


@pytest.mark.parametrize("name", ["by-hand", "version"])
def test_a_name_is_given_once(person: Page, file: Path, name: str) -> None:
    file.write_text(BY_HAND)
    answer = person.say("save_property", name=name, fields=NEVER)
    assert (answer["field"], answer["mistake"]) == (
        "name",
        f"{name}: there is a table of this name; give another name",
    )
    assert file.read_text() == BY_HAND


def test_a_file_with_mistakes_is_shown_and_left_alone(person: Page, file: Path) -> None:
    file.write_text(BY_HAND.replace("seeds", "sedes"))
    person.done("test_properties")
    (found,) = until(person, lambda now: bool(now["rows"]))["rows"]
    assert ("by-hand.sedes" in found["problem"], found["fields"], found["claim"]) == (True, None, "")
    file.write_text("[")
    person.done("test_properties")
    assert "is not TOML" in until(person, lambda now: now["problem"] != "")["problem"]
    answer = person.say("save_property", name="few", fields=NEVER)
    assert (answer["field"], "is not TOML" in answer["mistake"]) == ("", True)
    assert file.read_text() == "["


def test_results_are_marked_when_the_lesson_changes(person: Page, server: StudioServer) -> None:
    """A correction makes the result old, the next test runs with it though it is not saved."""
    always = NEVER | {
        "kind": "always",
        "condition": "goal",
        "seconds": 600.0,
        "limit_s": None,
        "seeds": "[26]",
    }
    person.done("save_property", name="delivers", fields=always)
    person.done("save_property", name="few", fields=NEVER)
    person.done("test_properties")
    assert row(person, "delivers", "fails")["stale"] is False
    row(person, "few", "holds")
    person.done("open", name="goto")
    person.done("bind_targets", targets={"A": "station"})
    person.done("press", state="left")
    person.done("step")
    until(person, lambda now: all(each["stale"] for each in now["rows"]))
    person.done("test_properties", name="few")
    found = until(person, lambda now: not now["rows"][1]["stale"])
    assert found["rows"][0]["stale"] is True


def test_choices_fit_the_world_and_the_behavior(person: Page) -> None:
    found = person.done("property_choices", world="forage", behavior="goto")
    assert {"forage", "patrol"} <= set(found["worlds"])
    assert {"name": "goto", "parameters": ["A"]} in found["behaviors"]
    assert "station" in found["bindable"]
    assert {"heading": "Goal and flags", "text": "goal is reached"} in found["conditions"]
    assert person.done("property_choices", world="moon", behavior="")["conditions"] == []


@pytest.mark.parametrize("world", list_scenarios())
def test_every_offered_condition_can_be_used(world: str) -> None:
    scenario = find_scenario(world)
    library, shown = Library(make_scenario_kit(scenario)), World(scenario, [0])
    worlds, behavior = SeededWorlds(world, (0,)), next(iter(library.kit.behaviors))
    subject = Property(kind=PropertyKind.NEVER, what="goal is reached", start=worlds, behavior=behavior)
    task = make_property_task(subject, library, scenario)
    run = task.make_run(scenario, [0])
    examples = list_condition_examples(shown, library, ["done"])
    assert len({each.text for each in examples}) == len(examples) > 5
    for each in examples:
        bind_condition(parse_condition(each.text), run, ["done"])()


def test_who_looks_on_may_not_change_them(person: Page, server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as other:
        for asked in (
            {"do": "save_property", "name": "few", "fields": NEVER},
            {"do": "delete_property", "name": "few"},
            {"do": "test_properties"},
        ):
            assert "not in control" in other.say(**asked)["error"]
