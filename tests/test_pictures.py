"""Pictures: every document is well-formed, says what it shows, and no part of a graph covers another."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from math import hypot
from pathlib import Path
from xml.etree import ElementTree

import pytest
from PIL import Image

from understudy.errors import SettingError, UnknownName
from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.pictures import automaton_svg, path_png, run_gif
from understudy.pictures.layout import BADGE, place_arrows, place_boxes
from understudy.worlds.forage import Forage, ForageSettings
from understudy.worlds.forage_expert import HandForager
from understudy.worlds.forage_view import from_forage
from understudy.worlds.view import Frame

STATES = (
    START,
    State("go", "GoTo", Binding(A="nearest_food")),
    State("left & right", "rotate_left"),
    State("back", "GoTo", Binding(A="station")),
    State("done", flag="done"),
    State("lost", flag="failed"),
)


def frames(seconds: float) -> Iterator[Frame]:
    world = Forage([3])
    forager = HandForager(1, ForageSettings())
    while world.time_s < seconds:
        commands = forager.decide(world.sense(forager.keys))
        yield Frame(from_forage(world.view()), ("turning" if commands["turn"][0] else "other",))
        world.act(commands)


def test_svg_says_what_it_shows() -> None:
    conditions = {
        ("start", "go"): ["always"],
        ("go", "go"): ["never shown"],
        ("go", "done"): ["distance_to(A) below 0.4 m", "food_left is no"],
        ("go", "left & right"): ["angle < 3 and " + "so on " * 40],
    }
    svg = automaton_svg(Automaton("Find", STATES, parameters=("A",)), conditions)
    root = ElementTree.fromstring(svg)
    texts = ["".join(node.itertext()) for node in root.iter("{http://www.w3.org/2000/svg}text")]
    for text in ("Find(A)", "go → done", "distance_to(A) below 0.4 m", "or food_left is no", "raises failed"):
        assert text in texts
    assert "never shown" not in svg
    assert max(map(len, texts)) < 90
    description = root.find("{http://www.w3.org/2000/svg}desc")
    assert description is not None
    assert "from go to done when distance_to(A) below 0.4 m or food_left is no" in (description.text or "")
    assert svg == automaton_svg(Automaton("Find", STATES, parameters=("A",)), conditions)


def test_svg_of_an_automaton_that_was_taught_nothing() -> None:
    ElementTree.fromstring(automaton_svg(Automaton("New"), {}))


def test_svg_refuses_conditions_of_another_automaton() -> None:
    with pytest.raises(UnknownName, match="'fly'"):
        automaton_svg(Automaton("Find", STATES), {("start", "fly"): ["always"]})


@pytest.mark.parametrize("count", [2, 3, 4, 5, 6, 8])
def test_nothing_in_a_graph_covers_another(count: int) -> None:
    boxes = place_boxes([(90.0 + 30 * (at % 3), 48.0) for at in range(count)])
    assert not any(one.near(other) for one, other in combinations(boxes, 2))
    pairs = [(one, (one + step) % count) for one in range(count) for step in (1, count - 1)]
    arrows = place_arrows(boxes, sorted(set(pairs)))
    badges = [arrow.badge for arrow in arrows]
    assert all(not box.holds(badge, BADGE) for box in boxes for badge in badges)
    assert all(hypot(a[0] - b[0], a[1] - b[1]) > 2 * BADGE for a, b in combinations(badges, 2))


def test_path_png(tmp_path: Path) -> None:
    path_png(list(frames(60.0)), tmp_path / "path.png", title="A path")
    with Image.open(tmp_path / "path.png") as image:
        assert min(image.size) > 800
        assert len(image.convert("RGB").getcolors(1_000_000) or ()) > 50


def test_run_gif(tmp_path: Path) -> None:
    run_gif(list(frames(20.0)), tmp_path / "run.gif", speed=10.0, per_s=10.0)
    with Image.open(tmp_path / "run.gif") as image:
        assert getattr(image, "n_frames", 0) == pytest.approx(20, abs=2)


def test_nothing_recorded(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match="record a run"):
        path_png([], tmp_path / "path.png")
    with pytest.raises(SettingError, match="record a run"):
        run_gif([], tmp_path / "run.gif")
    with pytest.raises(SettingError, match="speed"):
        run_gif(list(frames(1.0)), tmp_path / "run.gif", speed=0.0)
    assert not list(tmp_path.iterdir())
