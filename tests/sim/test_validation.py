"""Scenarios that cannot be: one error each, which names the key and says what would be right."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from math import inf, nan
from typing import Any

import pytest
from msgspec.structs import replace

from understudy.errors import FileError, SettingError
from understudy.sim.scenario.files import list_builtin_scenarios, load_scenario, parse_scenario
from understudy.sim.scenario.schema import (
    AppearanceSchedule,
    ArenaRegion,
    Goal,
    ObjectClass,
    Obstacle,
    RobotGroup,
    RobotType,
    Scenario,
    Sonar,
    TargetLocator,
    TargetSpec,
    Wall,
)
from understudy.sim.scenario.toml_writer import format_toml
from understudy.sim.scenario.validation import check_scenario

GOOD = """
size = [10, 8]
[[walls]]
points = [[3, 0], [3, 5]]
[[obstacles]]
radius = 0.5
at = [[6, 6]]
[[obstacles]]
points = [[-0.5, -0.5], [0.5, -0.5], [0, 0.5]]
at = [[8, 6]]
[regions]
left = { box = [0, 0, 3, 8] }
spot = { center = [5, 3], radius = 1 }
[[objects]]
name = "home"
home = true
color = "blue"
at = [[1, 1]]
[[objects]]
name = "food"
count = [1, 3]
amount = [2, 4]
color = "green"
[types.rover]
capacity = 4
color = "red"
[[types.rover.sensors]]
kind = "sonar"
sectors = { ahead = [-20, 20] }
[[types.rover.sensors]]
kind = "camera"
[types.rover.behaviors]
go = { drive = 1 }
[[robots]]
type = "rover"
count = 2
[targets]
home = { object = "home" }
"""

Steps = tuple[str | int, ...]

TWO_LOCATORS = [{"kind": "locator"}, {"kind": "locator", "range": 2}]

# where in the good one, what stands there instead, the key that is named, words of the error
BROKEN: list[tuple[Steps, Any, str, str]] = [
    # numbers
    (("size", 0), 0, "size[0]", "a number above 0"),
    (("size", 0), inf, "size[0]", "inf"),
    (("size", 1), nan, "size[1]", "nan"),
    (("size", 1), 1e30, "size[1]", "at most"),
    (("tick_s",), -0.1, "tick_s", "0.0001 or more"),
    (("spare_objects",), -1, "spare_objects", "from 0"),
    (("spare_objects",), 10_001, "spare_objects", "from 0 to 10 000"),
    (("generator",), 0, "generator", "1 or 2"),
    (("generator",), 3, "generator", "1 or 2"),
    (("types", "rover", "radius"), 0, "types.rover.radius", "above 0"),
    (("types", "rover", "noise_drive"), -0.1, "types.rover.noise_drive", "0 or more"),
    (("types", "rover", "load_s"), 0.25, "types.rover.load_s", "multiple of tick_s"),
    (("types", "rover", "turning_deg"), 1800, "types.rover.turning_deg", "shorter tick_s"),
    (("types", "rover", "sensors", 0, "noise"), -1, "types.rover.sensors[0].noise", "0 or more"),
    (("tick_s",), 1e-300, "tick_s", "0.0001 or more"),
    (("types", "rover", "sensors", 0, "dropout"), 1.5, "types.rover.sensors[0].dropout", "probability"),
    (("types", "rover", "sensors", 1, "view_deg"), 180, "types.rover.sensors[1].view_deg", "less than 180"),
    (("types", "rover", "sensors", 1, "misses"), nan, "types.rover.sensors[1].misses", "probability"),
    (("types", "rover", "sensors", 1, "width_px"), 0, "types.rover.sensors[1].width_px", "pixels"),
    (("objects", 1, "amount"), [4, 2], "objects[1].amount", "least first"),
    (("objects", 1, "count"), -1, "objects[1].count", "from 0"),
    (("objects", 1, "apart"), -0.1, "objects[1].apart", "0 or more"),
    (("obstacles", 0, "radius"), -0.5, "obstacles[0].radius", "above 0"),
    # types of values, and keys
    (("size",), 3, "size", "give a list"),
    (("size",), [1, 2, 3], "size", "list of 2"),
    (("types", "rover", "radius"), "big", "types.rover.radius", "give a number"),
    (("types", "rover", "radius"), True, "types.rover.radius", "give a number"),
    (("types", "rover", "raduis"), 0.2, "types.rover.raduis", "did you mean 'radius'"),
    (
        ("types", "rover", "sensors", 0, "kind"),
        "sonor",
        "types.rover.sensors[0].kind",
        "did you mean 'sonar'",
    ),
    (("types", "rover", "sensors", 0, "kind"), "radar", "types.rover.sensors[0].kind", "'camera'"),
    (
        ("types", "rover", "sensors", 0, "sees"),
        ["wall"],
        "types.rover.sensors[0].sees[0]",
        "did you mean 'walls'",
    ),
    (("types", "rover", "sensors", 0), {"sectors": {}}, "types.rover.sensors[0].kind", "is missing"),
    (("types", "rover", "sensors", 0), {"kind": "sonar"}, "types.rover.sensors[0].sectors", "is missing"),
    (
        ("types", "rover", "sensors", 0, "sectors", "ahead"),
        [1],
        "types.rover.sensors[0].sectors.ahead",
        "list of 2",
    ),
    (("types", "rover", "behaviors", "go", "drive"), "on", "types.rover.behaviors.go.drive", "give a number"),
    (("objects", 0, "colour"), "red", "objects[0].colour", "did you mean 'color'"),
    (("objects", 0, "name"), 5, "objects[0].name", "give a text"),
    (("robots",), {}, "robots", "give a list"),
    (("robot",), [], "robot", "did you mean 'robots'"),
    # names
    (("objects", 1, "name"), "home", "objects[1].name", "objects[0]"),
    (("objects", 1, "name"), "mouse", "objects[1].name", "pointer"),
    (("objects", 1, "name"), " ", "objects[1].name", "not a valid name"),
    (("objects", 1, "color"), "a\nb", "objects[1].color", "not a valid name"),
    (("types",), {}, "types", "at least one"),
    (("types", "rover", "sensors", 0, "sectors"), {}, "types.rover.sensors[0].sectors", "at least one"),
    (
        ("types", "rover", "sensors", 0, "sectors", "ahead"),
        [20, -20],
        "types.rover.sensors[0].sectors.ahead",
        "from",
    ),
    (
        ("types", "rover", "sensors", 0, "sectors", "a b "),
        [0, 0],
        "types.rover.sensors[0].sectors",
        "not a valid name",
    ),
    (("types", "rover", "sensors", 0, "sectors", "blob_x"), [0, 0], "types.rover.sensors[1]", "sensors[0]"),
    (("types", "rover", "sensors", 0, "sectors", "done"), [0, 0], "types.rover.sensors[0]", "second feature"),
    (("types", "rover", "sensors", 0, "sees"), [], "types.rover.sensors[0].sees", "what reflects"),
    (
        ("types", "rover", "sensors", 1),
        {"kind": "since", "name": "unseen", "of": "ahead"},
        "types.rover.sensors[1].of",
        "yes or no",
    ),
    (("types", "rover", "behaviors", "go", "fly"), 1, "types.rover.behaviors.go.fly", "'drive', 'turn'"),
    (("types", "rover", "behaviors", "go", "drive"), 2, "types.rover.behaviors.go.drive", "from -1 to 1"),
    (("types", "rover", "behaviors", "go", "drive"), inf, "types.rover.behaviors.go.drive", "finite"),
    (("types", "rover", "sensors"), TWO_LOCATORS, "types.rover.sensors[1]", "as does sensors[0]"),
    (
        ("types", "rover", "sensors", 1),
        {"kind": "locator", "targets": ["hom"]},
        "types.rover.sensors[1].targets",
        "did you mean 'home'",
    ),
    (
        ("types", "rover", "sensors", 1),
        {"kind": "locator", "targets": ["home", "home"]},
        "types.rover.sensors[1]",
        "the target 'home'",
    ),
    (
        ("types", "rover", "sensors", 1),
        {"kind": "locator", "targets": []},
        "types.rover.sensors[1].targets",
        "empty",
    ),
    (("targets", "home"), {}, "targets.home", "exactly one"),
    (("targets", "home"), {"object": "home", "color": "red"}, "targets.home", "exactly one"),
    (("targets", "home", "object"), "hone", "targets.home.object", "did you mean 'home'"),
    (("targets", "home"), {"color": "pink"}, "targets.home.color", "a color nobody has"),
    (("targets", "home"), {"team": "them"}, "targets.home.team", "no such team"),
    (("targets", "home", "index"), 40, "targets.home.index", "0 to 16"),
    (("targets", "home"), {"nearest": "food", "index": 1}, "targets.home.index", "without an object"),
    (("features",), {"f": {"reading": "sonar"}}, "features.f.reading", "no sensor reads"),
    (("features",), {"done": {"reading": "ahead"}}, "features.done", "second feature"),
    (("goal",), {}, "goal", "either delivered"),
    (("goal",), {"delivered": True, "target": "home"}, "goal", "either delivered"),
    (("goal",), {"target": "house"}, "goal.target", "no such class"),
    (("goal",), {"delivered": True, "all": True}, "goal.all", "without a target"),
    # places
    (("robots",), [], "robots", "at least one robot"),
    (("robots", 0, "type"), "rovr", "robots[0].type", "did you mean 'rover'"),
    (("robots", 0, "count"), [1, 2], "robots[0].count", "one whole number"),
    (("robots", 0, "count"), 0, "robots[0].count", "from 1 up"),
    (("robots", 0, "count"), 2000, "robots[0].count", "not enough free space"),
    (("robots", 0, "stored"), 5, "robots[0].stored", "at most 4"),
    (("robots", 0, "within"), "right", "robots[0].within", "no such region"),
    (("robots", 0, "near"), "hom", "robots[0].near", "did you mean 'home'"),
    (("robots", 0, "near_m"), 1, "robots[0].near_m", "name the object"),
    (("robots", 0, "at"), [[5, 5]], "robots[0].count", "beside places"),
    (("robots", 0), {"type": "rover", "at": []}, "robots[0].at", "at least one place"),
    (("robots", 0), {"type": "rover", "at": [[5]]}, "robots[0].at[0]", "x and y"),
    (("robots", 0), {"type": "rover", "at": [[5, 5, nan]]}, "robots[0].at[0][2]", "finite"),
    (("robots", 0), {"type": "rover", "at": [[0.1, 5]]}, "robots[0].at[0]", "outside the arena"),
    (("robots", 0), {"type": "rover", "at": [[3.1, 2]]}, "robots[0].at[0]", "overlaps a wall"),
    (("robots", 0), {"type": "rover", "at": [[6.5, 6]]}, "robots[0].at[0]", "overlaps obstacles[0].at[0]"),
    (("robots", 0), {"type": "rover", "at": [[8, 6]]}, "robots[0].at[0]", "overlaps obstacles[1].at[0]"),
    (
        ("robots", 0),
        {"type": "rover", "at": [[5, 2], [5, 3], [5.3, 2]]},
        "robots[0].at[2]",
        "robots[0].at[0]",
    ),
    (("robots", 0), {"type": "rover", "at": [[1, 1]], "within": "left"}, "robots[0].within", "beside places"),
    (("objects", 0, "at"), [[11, 1]], "objects[0].at[0]", "outside the arena"),
    (("objects", 0, "near"), "food", "objects[0].near", "beside places"),
    (("objects", 1, "near"), "food", "objects[1].near", "itself"),
    (("objects", 1, "presence"), {"away_s": [1, 2]}, "objects[1].count", "come and go"),
    (("objects", 0, "presence"), {"away_s": [1, 2]}, "objects[0].at", "appear at random"),
    (("objects", 1), {"name": "x", "walk": {"speed": 1}, "within": "spot"}, "objects[1].within", "a box"),
    (("objects", 1, "radius"), 4.5, "objects[1]", "no room"),
    (("obstacles", 0, "at"), [[5, -1]], "obstacles[0].at[0]", "outside the arena"),
    (("obstacles", 0, "points"), [[0, 0], [1, 0], [0, 1]], "obstacles[0]", "either a radius or points"),
    (("obstacles", 1, "points"), [[0, 0], [1, 0]], "obstacles[1].points", "at least 3"),
    (("obstacles", 1, "points"), [[0, 0], [1, 1], [1, 0], [0, 1]], "obstacles[1].points", "meet"),
    (("obstacles", 1, "points"), [[0, 0], [1, 0], [1, 0], [0, 1]], "obstacles[1].points", "twice"),
    (("obstacles", 1, "points"), [[0, 0], [1, 0], [2, 0]], "obstacles[1].points", "meet"),
    (("walls", 0, "points"), [[3, 0]], "walls[0].points", "at least 2"),
    (("walls", 0, "points"), [[3, 0], [3, 0]], "walls[0].points[1]", "again"),
    (("walls", 0, "points"), [[3, 0], [3, 50]], "walls[0].points[1]", "outside"),
    (("walls", 0, "closed"), True, "walls[0].points", "at least 3"),
    (("regions", "left"), {}, "regions.left", "either a box"),
    (("regions", "left", "box"), [3, 0, 0, 8], "regions.left.box", "x0 < x1"),
    (("regions", "spot", "center"), [50, 3], "regions.spot.center", "outside"),
]


def with_change(document: Any, steps: Steps, value: Any) -> Any:
    """A copy of plain values with another one in a place."""
    if not steps:
        return value
    if isinstance(document, Mapping):
        inside = document.get(steps[0], {})
        return {**document, steps[0]: with_change(inside, steps[1:], value)}
    changed = list(document)
    changed[int(steps[0])] = with_change(document[int(steps[0])], steps[1:], value)
    return changed


@pytest.mark.parametrize(("steps", "value", "key", "words"), BROKEN, ids=lambda each: str(each)[:60])
def test_broken_scenarios_say_what_and_where(steps: Steps, value: Any, key: str, words: str) -> None:
    document = with_change(tomllib.loads(GOOD), steps, value)
    text = format_toml({"understudy": "scenario", "version": 1, **document})
    with pytest.raises(FileError) as caught:
        parse_scenario(text, "broken.toml")
    assert caught.value.place == key
    assert words in str(caught.value)
    assert str(caught.value).startswith(f"broken.toml at {key}: ")
    assert "\n" not in str(caught.value)


def test_the_good_one_is_good() -> None:
    parse_scenario('understudy = "scenario"\nversion = 1\n' + GOOD)


@pytest.mark.parametrize("name", list_builtin_scenarios())
def test_built_in_scenarios_are_good(name: str) -> None:
    check_scenario(load_scenario(name))


PLAIN = Scenario(size=(10.0, 8.0), types={"rover": RobotType()}, robots=(RobotGroup(type="rover"),))
HOME = ObjectClass(name="home", home=True)

MADE: list[tuple[Mapping[str, Any], str, str]] = [  # changes of a plain scenario -> key, words
    ({"size": "large"}, "size", "give a list"),
    ({"tick_s": None}, "tick_s", "give a number"),
    ({"types": {"rover": "fast"}}, "types.rover", "give a table"),
    ({"types": {"rover": object()}}, "scenario", "plain numbers"),
    ({"goal": Goal(delivered=True)}, "goal.delivered", "no robot can carry"),
    (
        {"goal": Goal(delivered=True), "types": {"rover": RobotType(capacity=1)}},
        "goal.delivered",
        "no home",
    ),
    (
        {"goal": Goal(delivered=True), "types": {"rover": RobotType(capacity=1)}, "objects": (HOME,)},
        "goal.delivered",
        "no food",
    ),
    (
        {"types": {"rover": RobotType(behaviors={"load": {"load": 1.0}})}},
        "types.rover.behaviors.load.load",
        "capacity",
    ),
    (
        {
            "types": {
                "rover": RobotType(behaviors={"go": {"drive": 1.0}}),
                "digger": RobotType(behaviors={"go": {"drive": 0.5}}),
            }
        },
        "types.digger.behaviors.go",
        "another command",
    ),
    (
        {
            "types": {
                "rover": RobotType(sensors=(Sonar(sectors={"stuck": (0.0, 0.0)}),)),
                "digger": RobotType(sensors=load_scenario("arena").types["rover"].sensors[-1:]),
            }
        },
        "types.digger.sensors[0]",
        "a different reading",
    ),
    (
        {"objects": (replace(HOME, count=(0, 1)), ObjectClass(name="food", near="home"))},
        "objects[1].near",
        "always",
    ),
    (
        {"objects": (ObjectClass(name="a", near="b"), ObjectClass(name="b", near="a"))},
        "objects[0].near",
        "leads back to 'a'",
    ),
    (
        {
            "objects": (replace(HOME, solid=True),),
            "robots": (RobotGroup(type="rover", near="home", near_m=0.2),),
        },
        "robots[0].near_m",
        "solid",
    ),
    ({"objects": (replace(HOME, solid=True, aloft=True),)}, "objects[0].aloft", "leave out `solid`"),
    (
        {"objects": (replace(HOME, presence=AppearanceSchedule(away_s=(2.0, 1.0))),)},
        "objects[0].presence.away_s",
        "least first",
    ),
    (
        {"objects": (replace(HOME, solid=True, at=((2.0, 2.0), (2.1, 2.0))),)},
        "objects[0].at[1]",
        "overlaps objects[0].at[0]",
    ),
    (
        {
            "regions": {"corner": ArenaRegion(box=(0.0, 0.0, 0.1, 0.1))},
            "robots": (RobotGroup(type="rover", within="corner"),),
        },
        "robots[0]",
        "no room in the region 'corner'",
    ),
    ({"targets": {"enemy": TargetSpec(color="green")}}, "targets.enemy.color", "a color nobody has"),
    ({"name": ""}, "name", "not a valid name"),
]


@pytest.mark.parametrize(
    ("changes", "key", "words"), MADE, ids=lambda each: str(each)[:60].partition(" at 0x")[0]
)
def test_scenarios_made_in_python_are_checked_alike(changes: Mapping[str, Any], key: str, words: str) -> None:
    with pytest.raises(SettingError) as caught:
        check_scenario(replace(PLAIN, **changes))
    assert caught.value.setting == key
    assert words in str(caught.value)


def test_what_may_be() -> None:
    """Odd, but possible."""
    odd = replace(
        PLAIN,
        walls=(Wall(points=((1.0, 1.0), (2.0, 1.0), (2.0, 2.0)), closed=True),),
        obstacles=(
            Obstacle(radius=1.0, at=((5.0, 5.0), (5.5, 5.0))),  # overlapping obstacles
            Obstacle(
                points=((6.0, 1.0), (8.0, 1.0), (8.0, 2.0)), at=((0.0, 0.0),)
            ),  # corners in the arena's frame
        ),
        types={"rover": RobotType(speed=0.0), "never": RobotType()},
        objects=(ObjectClass(name="nothing", count=0, radius=0.0),),
    )
    check_scenario(odd)
    near = TargetLocator(range=4.0, targets=("mate",))
    two_locators = {"rover": RobotType(sensors=(TargetLocator(), near))}
    check_scenario(replace(PLAIN, types=two_locators, targets={"mate": TargetSpec(robot="any")}))


def test_many_given_places_are_checked_quickly() -> None:
    places = tuple((1.0 + 0.5 * (n % 200), 1.0 + 0.5 * (n // 200)) for n in range(40_000))
    check_scenario(replace(PLAIN, size=(110.0, 110.0), robots=(RobotGroup(type="rover", at=places),)))
