"""Teams in pictures: which robots are of one side, in which color, and that both can be seen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from understudy.sim.scenario.schema import RobotGroup, RobotType, Scenario
from understudy.sim.view import RunFrame, WorldView
from understudy.sim.world import World
from understudy.viz.palette import COLORS, PAINTS
from understudy.viz.path_png import draw_path_png
from understudy.viz.run_gif import draw_run_gif
from understudy.viz.team_colors import assign_team_colors

Kind = tuple[str, str | None, str | None]


def world(*kinds: Kind, each: int = 2) -> World:
    """A world with so many robots each of types that have a name, a team and a color."""
    types = {name: RobotType(team=team, color=color) for name, team, color in kinds}
    robots = tuple(RobotGroup(type=name, count=each) for name in types)
    return World(Scenario(name="sides", size=(20.0, 12.0), types=types, robots=robots))


def view(*kinds: Kind) -> WorldView:
    return world(*kinds).view()


RED, BLUE = ("red_ones", None, "red"), ("blue_ones", None, "blue")
SIDES: list[tuple[list[Kind], tuple[str, ...], list[int]]] = [  # types; what sides are called; of each robot
    ([RED, BLUE], ("red ones", "blue ones"), [0, 0, 1, 1]),
    ([BLUE, RED], ("blue ones", "red ones"), [0, 0, 1, 1]),
    (
        [("a", "home", "red"), ("b", "guests", "blue"), ("c", "home", None)],
        ("home", "guests"),
        [0, 0, 1, 1, 0, 0],
    ),
    ([("a", "home", "red"), ("b", "home", "blue")], ("a", "b"), [0, 0, 1, 1]),
]


@pytest.mark.parametrize(("kinds", "names", "of"), SIDES)
def test_sides_are_teams_or_else_types(kinds: list[Kind], names: tuple[str, ...], of: list[int]) -> None:
    found = assign_team_colors(view(*kinds))
    assert found is not None
    assert found.names == names
    assert found.of.tolist() == of
    assert found.counts[0] == f"{of.count(0)} {names[0]}"


def test_robots_of_one_type_have_no_sides() -> None:
    assert assign_team_colors(view(RED)) is None


CHOSEN = [  # colors that scenarios give, colors that are drawn
    (("red", "blue"), (PAINTS["red"], PAINTS["blue"])),
    (("red", "red"), (PAINTS["red"], COLORS[0])),
    (("white", "green"), (COLORS[0], PAINTS["green"])),
    ((None, "blue"), (COLORS[1], PAINTS["blue"])),
    (("gray", "grey"), (PAINTS["gray"], COLORS[0])),
    ((None, None), (COLORS[0], COLORS[1])),
]


@pytest.mark.parametrize(("given", "drawn"), CHOSEN)
def test_sides_are_of_different_colors(given: tuple[str | None, ...], drawn: tuple[str, ...]) -> None:
    found = assign_team_colors(view(*((f"t{at}", None, color) for at, color in enumerate(given))))
    assert found is not None
    assert found.colors == drawn


def test_a_shade_for_each_robot() -> None:
    found = assign_team_colors(world(RED, BLUE, each=4).view())
    assert found is not None
    assert len(set(found.shades)) == 8
    for side, shade in zip(found.of.tolist(), found.shades, strict=True):
        red, _, blue = bytes.fromhex(shade[1:])
        assert (red > blue) == (side == 0)


def pixels(image: Image.Image, color: str) -> int:
    return int((np.array(image.convert("RGB")) == list(bytes.fromhex(color[1:]))).all(axis=2).sum())


@pytest.mark.parametrize("each", [1, 10, 60])
def test_both_sides_are_seen_at_a_glance(each: int, tmp_path: Path) -> None:
    """Of every robot the greater part of its disc is its side's, while all do the same."""
    body = world(RED, BLUE, each=each)
    seen = []
    for _ in range(5):
        seen.append(RunFrame(body.view(), ["one"] * body.agents))
        body.act({"drive": np.ones(body.agents)})
    draw_run_gif(seen, tmp_path / "run.gif")
    draw_path_png(seen, tmp_path / "path.png")
    for name, least in (("run.gif", 25), ("path.png", 25)):
        with Image.open(tmp_path / name) as image:
            for color in (PAINTS["red"], PAINTS["blue"]):
                assert pixels(image, color) >= least * each
