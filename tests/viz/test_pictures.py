"""Pictures: every document is well-formed, says what it shows, and no part of a graph covers another."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from math import hypot
from pathlib import Path
from time import process_time
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from tests.make.run_frames import make_crossing

from understudy.errors import SettingError, UnknownName
from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.sim.forage import Forage, ForageSettings
from understudy.sim.view import RunFrame
from understudy.viz.appearance import count_food_units, find_removed_objects, list_object_marks
from understudy.viz.automaton_svg import draw_automaton_svg
from understudy.viz.graph_layout import BADGE, place_arrows, place_boxes
from understudy.viz.palette import (
    COLORS,
    FOOD,
    GROUND,
    INK,
    PAINTS,
    PAPER,
    SOLID,
    blend_color,
    choose_drawing_color,
)
from understudy.viz.path_png import draw_path_png
from understudy.viz.run_gif import FrameBuffer, draw_run_gif
from understudy.viz.sheet import choose_scale_length
from understudy_lab.tasks.forage_expert import ExpertForager

STATES = (
    START,
    State("go", "GoTo", Binding(A="nearest_food")),
    State("left & right", "rotate_left"),
    State("back", "GoTo", Binding(A="station")),
    State("done", flag="done"),
    State("lost", flag="failed"),
)


def frames(seconds: float) -> Iterator[RunFrame]:
    world = Forage([3])
    forager = ExpertForager(1, ForageSettings())
    while world.time_s < seconds:
        commands = forager.decide(world.sense(forager.keys))
        yield RunFrame(world.view(), ("turning" if commands["turn"][0] else "other",))
        world.act(commands)


def shades(image: Image.Image) -> set[object]:
    return {color for _, color in image.convert("RGB").getcolors(1_000_000) or ()}


def rgb(color: str) -> tuple[int, ...]:
    return tuple(bytes.fromhex(color[1:]))


def test_svg_says_what_it_shows() -> None:
    conditions = {
        ("start", "go"): ["always"],
        ("go", "go"): ["never shown"],
        ("go", "done"): ["distance_to(A) below 0.4 m", "food_left is no"],
        ("go", "left & right"): ["angle < 3 and " + "so on " * 40],
    }
    svg = draw_automaton_svg(Automaton("Find", STATES, parameters=("A",)), conditions)
    root = ElementTree.fromstring(svg)
    texts = ["".join(node.itertext()) for node in root.iter("{http://www.w3.org/2000/svg}text")]
    for text in ("Find(A)", "go → done", "distance_to(A) below 0.4 m", "or food_left is no", "raises failed"):
        assert text in texts
    assert "never shown" not in svg
    assert max(map(len, texts)) < 90
    description = root.find("{http://www.w3.org/2000/svg}desc")
    assert description is not None
    assert "from go to done when distance_to(A) below 0.4 m or food_left is no" in (description.text or "")
    assert svg == draw_automaton_svg(Automaton("Find", STATES, parameters=("A",)), conditions)


def test_svg_of_an_automaton_that_was_taught_nothing() -> None:
    ElementTree.fromstring(draw_automaton_svg(Automaton("New"), {}))


def test_svg_refuses_conditions_of_another_automaton() -> None:
    with pytest.raises(UnknownName, match="'fly'"):
        draw_automaton_svg(Automaton("Find", STATES), {("start", "fly"): ["always"]})


@pytest.mark.parametrize("count", [2, 3, 4, 5, 6, 8])
def test_nothing_in_a_graph_covers_another(count: int) -> None:
    boxes = place_boxes([(90.0 + 30 * (at % 3), 48.0) for at in range(count)])
    assert not any(one.is_near(other) for one, other in combinations(boxes, 2))
    pairs = [(one, (one + step) % count) for one in range(count) for step in (1, count - 1)]
    arrows = place_arrows(boxes, sorted(set(pairs)))
    badges = [arrow.badge for arrow in arrows]
    assert all(not box.contains(badge, BADGE) for box in boxes for badge in badges)
    assert all(hypot(a[0] - b[0], a[1] - b[1]) > 2 * BADGE for a, b in combinations(badges, 2))


def test_path_png(tmp_path: Path) -> None:
    draw_path_png(list(frames(60.0)), tmp_path / "path.png", title="A path")
    with Image.open(tmp_path / "path.png") as image:
        assert min(image.size) > 800
        assert len(image.convert("RGB").getcolors(1_000_000) or ()) > 50


def test_run_gif(tmp_path: Path) -> None:
    draw_run_gif(list(frames(20.0)), tmp_path / "run.gif", speed=10.0, per_s=10.0)
    with Image.open(tmp_path / "run.gif") as image:
        assert getattr(image, "n_frames", 0) == pytest.approx(20, abs=2)


CREWS = [1, 4, 30, 80]


@pytest.mark.parametrize("robots", CREWS)
def test_any_world_as_a_path_and_in_motion(tmp_path: Path, robots: int) -> None:
    seen = make_crossing(25, robots=robots)
    draw_path_png(seen, tmp_path / "path.png", title="A path")
    draw_run_gif(seen, tmp_path / "run.gif", speed=2.0)
    with Image.open(tmp_path / "path.png") as image:
        assert shades(image) >= {rgb(INK), rgb(SOLID), rgb(FOOD), rgb(PAINTS["brown"])}
    with Image.open(tmp_path / "run.gif") as image:
        assert getattr(image, "n_frames", 0) == pytest.approx(20, abs=2)
        assert shades(image) >= {rgb(INK), rgb(SOLID), rgb(PAPER), rgb(GROUND), rgb(COLORS[0])}


@pytest.mark.parametrize(("width", "height"), [(40.0, 8.0), (8.0, 40.0), (0.6, 0.5)])
def test_arenas_of_any_shape(tmp_path: Path, width: float, height: float) -> None:
    seen = make_crossing(10, width=width, height=height)
    draw_path_png(seen, tmp_path / "path.png")
    draw_run_gif(seen, tmp_path / "run.gif")
    with Image.open(tmp_path / "path.png") as image:
        assert max(image.size) < 1700
    with Image.open(tmp_path / "run.gif") as image:
        assert max(image.size) < 700


def test_a_thousand_robots_are_drawn_at_once(tmp_path: Path) -> None:
    seen = make_crossing(30, robots=1000, width=60.0, height=40.0)
    began = process_time()
    draw_path_png(seen, tmp_path / "path.png")
    draw_run_gif(seen, tmp_path / "run.gif", speed=1.0)
    assert process_time() - began < 20.0


def test_what_a_picture_says_of_things() -> None:
    view = make_crossing(1, robots=2)[0].view
    known = {thing.name: thing for thing in list_object_marks(view)}
    assert [thing.label for thing in list_object_marks(view)] == [
        "3 of 8 units left",
        "4 units",
        "base",
        "box",
    ]
    assert known["food"].served
    assert known["base"].square
    assert known["box"].rimmed
    assert find_removed_objects(list_object_marks(view), list_object_marks(view), view) == []
    assert count_food_units(view) == 7


def test_scales_are_round() -> None:
    assert [choose_scale_length(width) for width in (12.0, 6.0, 3.5, 40.0, 100.0)] == [
        2.0,
        1.0,
        0.5,
        5.0,
        10.0,
    ]


def test_names_of_colors() -> None:
    assert choose_drawing_color("red") == PAINTS["red"] == choose_drawing_color("RED")
    assert choose_drawing_color("#12ab9f") == "#12ab9f"
    assert choose_drawing_color("mauve") == choose_drawing_color("mauve") in COLORS
    assert blend_color("#000000", "#ffffff", 0.0) == "#ffffff"


def test_a_recording_keeps_every_so_many_frames_and_both_ends() -> None:
    seen = make_crossing(100)
    for count in range(1, 101):
        recording = FrameBuffer(most=8)
        for frame in seen[:count]:
            recording.append(frame)
        times = [round(frame.view.time_s, 6) for frame in recording.frames]
        assert times[0] == 0.0
        assert times[-1] == pytest.approx(0.1 * (count - 1))
        assert len(times) <= 9
        assert len({round(step, 6) for step in np.diff(times[:-1])}) <= 1
    assert FrameBuffer().frames == []


def test_nothing_recorded(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match="record a run"):
        draw_path_png([], tmp_path / "path.png")
    with pytest.raises(SettingError, match="record a run"):
        draw_run_gif([], tmp_path / "run.gif")
    with pytest.raises(SettingError, match="speed"):
        draw_run_gif(list(frames(1.0)), tmp_path / "run.gif", speed=0.0)
    assert not list(tmp_path.iterdir())
