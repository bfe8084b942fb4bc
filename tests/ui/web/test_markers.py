"""Markers in the studio: placed, moved and removed, taught with, and still there after a kill and in the library."""

from __future__ import annotations

from math import isnan, nan
from pathlib import Path
from typing import Any

import pytest
from tests.make.studios import GOTO, Page, make_studio, open_page, serve_studio
from tests.ui.cli.commands import run, run_json

from understudy.addons.robots.twin import find_drawn_world
from understudy.sim.scenario.files import TARGET, list_builtin_scenarios
from understudy.sim.target_lookup import find_target_place
from understudy.storage.library_folder import open_document

TO_MARKER = {**GOTO, "states": ["forward", "rotate_left"], "targets": {"A": TARGET}}
"""A lesson about going to the marker."""


def slots(somebody: Page) -> list[int]:
    """Where the frame has markers."""
    names = [each["name"] for each in somebody.scene["classes"]]
    assert somebody.frame is not None
    return [slot for slot, kind, *_ in somebody.frame.objects if names[kind] == "marker"]


@pytest.mark.parametrize("world", list_builtin_scenarios())
def test_placed_moved_and_removed_in_any_world(tmp_path: Path, world: str) -> None:
    made = make_studio(tmp_path, world=world)
    with serve_studio(made) as client, open_page(client) as somebody:
        kinds = {each["name"]: each for each in somebody.scene["classes"]}
        assert (kinds["marker"]["marker"], kinds["marker"]["offered"]) == (True, True)
        assert not kinds["mouse"]["offered"]
        assert somebody.scene["targets"][-1] == TARGET, "what is there already comes first"
        somebody.done("add_object", kind="marker", x=1.0, y=1.0)
        while not (there := slots(somebody)):
            somebody.hear()
        somebody.done("move_object", slot=there[0], x=2.0, y=1.5)
        assert find_target_place(find_drawn_world(made.host.world), TARGET) == (2.0, 1.5)
        somebody.done("remove_object", slot=there[0])
        assert find_target_place(find_drawn_world(made.host.world), TARGET) is None


def press_each(somebody: Page, *states: str) -> list[dict[str, Any]]:
    """Press and step; the examples there are then."""
    for state in states:
        somebody.done("press", state=state)
        somebody.done("step")
    somebody.wait_for_news()
    examples: list[dict[str, Any]] = somebody.news["session"]["examples"]
    return examples


def test_a_lesson_about_markers_outlasts_its_studio(tmp_path: Path) -> None:
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as somebody:
        somebody.send(TO_MARKER)
        somebody.done("pause", paused=True)
        assert press_each(somebody, "rotate_left")[0]["values"] == ["–", "–"], "none is placed yet"
        somebody.done("add_object", kind="marker", x=3.0, y=4.0)
        assert "–" not in press_each(somebody, "forward")[2]["values"]
    made = make_studio(tmp_path)
    with serve_studio(made) as client, open_page(client) as somebody:
        somebody.done("open", name="goto")
        assert find_target_place(find_drawn_world(made.host.world), TARGET) == pytest.approx((3.0, 4.0))
        assert made.host.active_trainer.session_view.targets == {"A": TARGET}
        assert "–" not in press_each(somebody, "done")[-1]["values"]
        somebody.done("save")
        somebody.done("new", name="trip", states=["goto(nearest_marker)"], features=["done"], flags=["there"])
        press_each(somebody, "goto", "there")
        somebody.done("save")
    first = open_document(tmp_path / "goto.json", made.host.kit).taught.lesson
    assert first is not None
    assert first.examples[0].values == pytest.approx((nan, nan), nan_ok=True)
    told = run_json("run", "forage", "--library", tmp_path, "--behavior", "trip", "--seconds", "2")
    assert told["path"] == ["there"]
    told = run_json(
        "run", "arena", "--library", tmp_path, "--behavior", "goto", "--bind", f"A={TARGET}", "--seconds", "2"
    )
    assert told["behavior"] == "goto"


def test_where_there_is_no_such_target_it_is_said(tmp_path: Path) -> None:
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as somebody:
        somebody.send(TO_MARKER)
        somebody.done("pause", paused=True)
        press_each(somebody, "forward")
        somebody.done("save")
        somebody.done(
            "new", name="trip", states=["goto(nearest_marker)"], features=["food_left"], flags=["there"]
        )
        press_each(somebody, "goto")
        somebody.done("save")
    plain = "understudy.sim.forage:FORAGE_KIT"
    result = run(
        "run", "forage", "--kit", plain, "--library", tmp_path, "--behavior", "trip", "--seconds", "2"
    )
    assert result.exit_code == 2
    assert "no target 'nearest_marker'" in " ".join(result.stderr.split()), result.stderr


def test_what_a_parameter_stands_for_is_shown_at_once_while_time_stands_still(tmp_path: Path) -> None:
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as somebody:
        somebody.send(GOTO)
        somebody.done("pause", paused=True)
        while somebody.frame is None or len(somebody.frame.features) != 2:
            somebody.hear()
        assert not isnan(somebody.frame.features[0])
        somebody.done("bind_targets", targets={"A": TARGET})
        while not isnan(somebody.frame.features[0]):
            somebody.hear()
        somebody.done("change_design", states=["forward"], features=["food_left"])
        while len(somebody.frame.features) != 1:
            somebody.hear()
