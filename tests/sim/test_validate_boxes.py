"""Boxes to pull, signals and claims that cannot be: one error each, which names the key and what would be right."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest
from tests.sim.test_validation import Steps, with_change

from understudy.errors import FileError
from understudy.sim.scenario.files import parse_scenario
from understudy.sim.scenario.toml_writer import format_toml

GOOD = """
size = [10, 8]
regions = { spot = { center = [5, 3], radius = 1 } }
[[objects]]
name = "home"
home = true
[[objects]]
name = "box"
count = 3
pull = { robots = 2 }
[types.puller]
[[types.puller.sensors]]
kind = "locator"
[[types.puller.sensors]]
kind = "holding"
[[types.puller.sensors]]
kind = "claimed"
signal = "claim"
range = 1
[types.puller.behaviors]
tow = { drive = 1, signal = "claim" }
wait = { load = 1, signal = "help" }
drop = { unload = 1 }
[[robots]]
type = "puller"
count = 4
[targets]
box = { nearest = "box" }
free = { nearest = "box", unclaimed = "claim", within = 1 }
caller = { signal = "help" }
mate = { signal = "help", robot = "teammate" }
one = { signal = "help", team = "puller" }
[goal]
gathered = 3
"""
BEHAVIORS, CLAIMED = ("types", "puller", "behaviors"), ("types", "puller", "sensors", 2)

# where in the good one, what stands there instead, the key that is named, words of the error
BROKEN: list[tuple[Steps, Any, str, str]] = [
    (("objects", 1, "pull", "robots"), 0, "objects[1].pull.robots", "1 or more"),
    (("objects", 1, "pull", "robots"), 5, "objects[1].pull.robots", "there are 4 robots"),
    (("objects", 1, "pull", "hands"), 5, "objects[1].pull.hands", "known are 'robots' and 'respawn'"),
    (("objects", 1, "pull"), 3, "objects[1].pull", "give a table"),
    (("objects", 1, "solid"), True, "objects[1].pull", "beside solid"),
    (("objects", 1, "pushable"), True, "objects[1].pull", "beside pushable"),
    (("objects", 1, "amount"), 3, "objects[1].pull", "beside amount"),
    (("objects", 1, "walk"), {"speed": 1}, "objects[1].pull", "beside walk"),
    (
        ("objects", 1),
        {"name": "box", "pull": {"respawn": True}, "within": "spot"},
        "objects[1].within",
        "a region that is a box",
    ),
    ((*BEHAVIORS, "tow", "signal"), 1, "types.puller.behaviors.tow.signal", 'signal = "help"'),
    ((*BEHAVIORS, "tow", "signal"), " ", "types.puller.behaviors.tow.signal", "not a valid name"),
    ((*BEHAVIORS, "tow", "drive"), "fast", "types.puller.behaviors.tow.drive", "give a number from -1 to 1"),
    ((*BEHAVIORS, "tow", "signl"), 1, "types.puller.behaviors.tow.signl", "did you mean 'signal'"),
    ((*CLAIMED, "signal"), "clam", "types.puller.sensors[2].signal", "did you mean 'claim'"),
    ((*CLAIMED, "range"), 0, "types.puller.sensors[2].range", "above 0"),
    (CLAIMED, {"kind": "claimed", "signal": "claim"}, "types.puller.sensors[2].range", "is missing"),
    ((*CLAIMED, "targets"), [], "types.puller.sensors[2].targets", "is empty"),
    ((*CLAIMED, "targets"), ["caller"], "types.puller.sensors[2].targets", "known are 'box'"),
    ((*CLAIMED, "targets"), ["free"], "types.puller.sensors[2].targets", "known are 'box'"),
    ((*CLAIMED, "name"), "holding", "types.puller.sensors[2]", "as does sensors[1]"),
    (("targets", "caller", "signal"), "hepl", "targets.caller.signal", "did you mean 'help'"),
    (("targets", "caller", "nearest"), "box", "targets.caller", "exactly one of"),
    (("targets", "mate", "team"), "puller", "targets.mate", "exactly one of"),
    (("targets", "free", "unclaimed"), "hlp", "targets.free.unclaimed", "did you mean 'help'"),
    (("targets", "free"), {"nearest": "box", "unclaimed": "claim"}, "targets.free.unclaimed", "give both"),
    (("targets", "free"), {"nearest": "box", "within": 1}, "targets.free.within", "give both"),
    (
        ("targets", "free"),
        {"object": "box", "unclaimed": "claim", "within": 1},
        "targets.free.unclaimed",
        "without `nearest`",
    ),
    (("targets", "free", "within"), 0, "targets.free.within", "above 0"),
    (("goal", "gathered"), 4, "goal.gathered", "at most 3, or let boxes respawn"),
    (("goal", "gathered"), -1, "goal.gathered", "0 or more"),
    (("goal", "gathered"), 0, "goal", "how many boxes"),
    (("goal", "target"), "home", "goal", "give either"),
    (("goal", "all"), True, "goal.all", "without a target"),
    (("objects", 0, "home"), False, "goal.gathered", "no home that a box can be brought into"),
    (("objects", 0, "solid"), True, "goal.gathered", "not solid"),
    (("objects", 1), {"name": "box"}, "types.puller.behaviors.wait.load", "or some object a pull"),
]


@pytest.mark.parametrize(("steps", "value", "key", "words"), BROKEN, ids=lambda each: str(each)[:60])
def test_broken_boxes_say_what_and_where(steps: Steps, value: Any, key: str, words: str) -> None:
    document = with_change(tomllib.loads(GOOD), steps, value)
    with pytest.raises(FileError) as caught:
        parse_scenario(format_toml({"understudy": "scenario", "version": 1, **document}), "broken.toml")
    assert (caught.value.place, words in str(caught.value)) == (key, True), str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_good_one_is_good() -> None:
    scenario = parse_scenario('understudy = "scenario"\nversion = 1\n' + GOOD)
    assert (
        parse_scenario(format_toml({"understudy": "scenario", "version": 1, **tomllib.loads(GOOD)}))
        == scenario
    )


def test_more_than_there_are_can_be_gathered_where_boxes_respawn() -> None:
    document = with_change(tomllib.loads(GOOD), ("goal", "gathered"), 400)
    document = with_change(document, ("objects", 1, "pull", "respawn"), True)
    parse_scenario(format_toml({"understudy": "scenario", "version": 1, **document}))
