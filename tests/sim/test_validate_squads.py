"""Squads that cannot be: one error each, which names the key and says what would be right."""

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
[[objects]]
name = "home"
home = true
color = "blue"
[types.scout]
color = "red"
sensors = [{ kind = "camera" }, { kind = "stuck" }]
[types.scout.behaviors]
go = { drive = 1 }
[types.carrier]
capacity = 4
sensors = [{ kind = "cargo" }, { kind = "stuck" }]
[[robots]]
type = "scout"
count = 4
[[robots]]
type = "carrier"
count = 2
[targets]
home = { object = "home" }
[squads.pair.members.scouts]
of = "scout"
least = 2
[squads.pair]
count = 2
statistics = { sees = { how = "any", reading = "blob_size" } }
[squads.camp.members.pairs]
of = "pair"
[squads.camp.members.carriers]
of = "carrier"
[squads.camp.statistics]
seen = { how = "any", reading = "sees", role = "pairs" }
[squads.camp.orders]
work = [{ run = "fetch", with = { A = "home" }, role = "carriers" }, { run = "look", share = "1/2" }, { run = "wait" }]
[radio]
loss = 0.1
"""


def pair(*steps: str | int) -> Steps:
    return ("squads", "pair", *steps)


def camp(*steps: str | int) -> Steps:
    return ("squads", "camp", *steps)


SCOUTS, SEEN, WORK = ("members", "scouts"), ("statistics", "seen"), ("orders", "work")

# where in the good one, what stands there instead, the key that is named, words of the error
BROKEN: list[tuple[Steps, Any, str, str]] = [
    # keys and types of values
    (("squads",), [], "squads", "give a table"),
    (("squad",), {}, "squad", "did you mean 'squads'"),
    (pair(), {}, "squads.pair.members", "is missing"),
    (pair("member"), {}, "squads.pair.member", "did you mean 'members'"),
    (pair(*SCOUTS), {}, "squads.pair.members.scouts.of", "is missing"),
    (pair(*SCOUTS, "least"), 1.5, "squads.pair.members.scouts.least", "give a whole number"),
    (pair("statistics", "n"), {}, "squads.pair.statistics.n.how", "is missing"),
    (camp(*SEEN, "how"), "meen", "squads.camp.statistics.seen.how", "did you mean 'mean'"),
    (camp(*SEEN, "fro_s"), 2, "squads.camp.statistics.seen.fro_s", "did you mean 'for_s'"),
    (camp(*WORK, 1, "share"), 0.5, "squads.camp.orders.work[1].share", "a whole number or a text"),
    (camp(*WORK, 0, "wiht"), {}, "squads.camp.orders.work[0].wiht", "did you mean 'with'"),
    (camp(*WORK, 0, "with_"), {}, "squads.camp.orders.work[0].with_", "is not a key"),
    (camp(*WORK, 0, "with"), "home", "squads.camp.orders.work[0].with", "give a table"),
    (camp(*WORK, 0, "with", "A"), 1, "squads.camp.orders.work[0].with.A", "give a text"),
    # numbers
    (("radio", "loss"), 1.5, "radio.loss", "probability"),
    (("radio", "delay_s"), -1, "radio.delay_s", "0 or more"),
    (pair("count"), 0, "squads.pair.count", "1 or more"),
    (pair(*SCOUTS, "least"), -1, "squads.pair.members.scouts.least", "0 or more"),
    (pair(*SCOUTS, "preferred"), 0, "squads.pair.members.scouts.preferred", "1 or more"),
    (camp(*SEEN, "for_s"), 0, "squads.camp.statistics.seen.for_s", "above 0"),
    (camp(*SEEN, "within_s"), float("inf"), "squads.camp.statistics.seen.within_s", "above 0"),
    (camp(*WORK, 1, "share"), 0, "squads.camp.orders.work[1].share", "1 or more"),
    (camp(*WORK, 1, "share"), "0/3", "squads.camp.orders.work[1].share", "1/3"),
    (camp(*WORK, 1, "share"), "1/0", "squads.camp.orders.work[1].share", "1/3"),
    (camp(*WORK, 1, "share"), "3/3", "squads.camp.orders.work[1].share", "1/3"),
    (camp(*WORK, 1, "share"), "half", "squads.camp.orders.work[1].share", "is 'half'; give a part"),
    # names
    (("squads", " "), {"members": {}}, "squads", "not a valid name"),
    (("squads", "scout"), {"members": {"x": {"of": "pair"}}}, "squads.scout", "name of a type"),
    (pair("members", "a\nb"), {"of": "scout"}, "squads.pair.members", "not a valid name"),
    (pair("statistics", ""), {"how": "count"}, "squads.pair.statistics", "not a valid name"),
    (
        pair("statistics", "n"),
        {"how": "any", "flag": ""},
        "squads.pair.statistics.n.flag",
        "not a valid name",
    ),
    (camp("orders", "?"), [], "squads.camp.orders", "not a valid name"),
    (camp(*WORK, 2, "run"), "", "squads.camp.orders.work[2].run", "not a valid name"),
    (camp(*WORK, 0, "with"), {"": "home"}, "squads.camp.orders.work[0].with", "not a valid name"),
    # members
    (pair("members"), {}, "squads.pair.members", "at least one role"),
    (pair(*SCOUTS, "of"), "scuot", "squads.pair.members.scouts.of", "did you mean 'scout'"),
    (pair(*SCOUTS, "of"), "pair", "squads.pair.members.scouts.of", "pair -> pair"),
    (pair(*SCOUTS, "of"), "camp", "squads.pair.members.scouts.of", "pair -> camp -> pair"),
    (pair(*SCOUTS, "least"), 0, "squads.pair.members.scouts.least", "allows squads without members"),
    (pair(*SCOUTS, "preferred"), 1, "squads.pair.members.scouts.least", "is 2, above preferred, 1"),
    (pair(*SCOUTS, "most"), 1, "squads.pair.members.scouts.least", "is 2, above most, 1"),
    (
        pair(*SCOUTS),
        {"of": "scout", "preferred": 3, "most": 2},
        "squads.pair.members.scouts.preferred",
        "is 3, above most, 2",
    ),
    # what cannot be met
    (
        pair("count"),
        3,
        "squads.pair.members.scouts.least",
        "3 × 2 for 'scouts' in 'pair' make 6, and there are 4 robots of the type 'scout'",
    ),
    (
        camp("members", "spies"),
        {"of": "scout"},
        "squads.pair.members.scouts.least",
        "2 × 2 for 'scouts' in 'pair' and 1 × 1 for 'spies' in 'camp' together make 5, and there are 4 robots",
    ),
    (
        pair(*SCOUTS),
        {"of": "scout", "most": 1},
        "squads.pair.members.scouts.most",
        "leaves somebody in no squad: 2 × 1 for 'scouts' in 'pair' make 2, and there are 4 robots",
    ),
    (
        camp("members", "pairs", "least"),
        3,
        "squads.camp.members.pairs.least",
        "1 × 3 for 'pairs' in 'camp' make 3, and there are 2 squads of the sort 'pair'",
    ),
    (
        ("squads", "gang"),
        {"members": {"pairs": {"of": "pair", "least": 2}}},
        "squads.camp.members.pairs.least",
        "together make 3, and there are 2 squads",
    ),
    (
        ("robots",),
        [{"type": "scout", "count": 4}],
        "squads.camp.members.carriers.least",
        "there are 0 robots",
    ),
    # statistics
    (
        camp(*SEEN),
        {"how": "any"},
        "squads.camp.statistics.seen",
        "is the any of nothing; name a reading or a flag",
    ),
    (camp(*SEEN), {"how": "mean"}, "squads.camp.statistics.seen", "is the mean of nothing; name a reading"),
    (camp(*SEEN, "flag"), "done", "squads.camp.statistics.seen", "is of a reading and of a flag"),
    (
        camp(*SEEN),
        {"how": "count", "least": 2},
        "squads.camp.statistics.seen",
        "compares something that is not a reading",
    ),
    (
        camp(*SEEN),
        {"how": "any", "reading": "sees", "since": True, "for_s": 1},
        "squads.camp.statistics.seen",
        "more than one way",
    ),
    (
        camp(*SEEN),
        {"how": "mean", "reading": "sees", "since": True},
        "squads.camp.statistics.seen",
        "times a mean",
    ),
    (
        pair("statistics", "sees"),
        {"how": "any", "reading": "blob_size", "least": 3, "below": 2},
        "squads.pair.statistics.sees.least",
        "below is 2",
    ),
    (camp(*SEEN, "role"), "pears", "squads.camp.statistics.seen.role", "did you mean 'pairs'"),
    (
        camp(*SEEN, "role"),
        "carriers",
        "squads.camp.statistics.seen.reading",
        "is of 'sees', which nobody in the role 'carriers' reads; known are 'food_here'",
    ),
    (
        camp(*SEEN),
        {"how": "any", "reading": "sees"},
        "squads.camp.statistics.seen.reading",
        "only members in 'pairs' read; give one role, such as role = 'pairs'",
    ),
    (
        pair("statistics", "sees", "reading"),
        "blob_siz",
        "squads.pair.statistics.sees.reading",
        "which none of its members reads; did you mean 'blob_size'? known are 'blob_x', 'blob_size' and 'stuck'",
    ),
    (camp(*SEEN), {"how": "centroid"}, "squads.camp.statistics.seen", "is of 'x', which none"),
    (
        camp(*SEEN),
        {"how": "centroid", "reading": "at"},
        "squads.camp.statistics.seen.reading",
        "is of 'at_x', which none",
    ),
    (camp(*SEEN), {"how": "centroid", "flag": "done"}, "squads.camp.statistics.seen", "and of a flag"),
    (pair("statistics", "done"), {"how": "count"}, "squads.pair.statistics.done", "rename one"),
    (
        pair("statistics", "time_in_state"),
        {"how": "count"},
        "squads.pair.statistics.time_in_state",
        "rename one",
    ),
    (
        pair("statistics", "stuck"),
        {"how": "count", "reading": "stuck"},
        "squads.pair.statistics.stuck",
        "is a different reading for a robot",
    ),
    (
        camp("statistics", "sees"),
        {"how": "count"},
        "squads.camp.statistics.sees",
        "is a different reading for the squad 'pair'",
    ),
    # who is counted no more
    (pair("drops"), "stukc", "squads.pair.drops", "did you mean 'stuck'"),
    (pair("drops"), "blob_x", "squads.pair.drops", "no such yes-or-no reading of its members"),
    (camp("drops"), "sees", "squads.camp.drops", "known are 'food_left', 'station_here' and 'stuck'"),
    # orders
    (camp(*WORK), [], "squads.camp.orders.work", "is empty"),
    (camp("orders", "go"), [{"run": "wait"}], "squads.camp.orders.go", "its members do already"),
    (pair("orders"), {"work": [{"run": "wait"}]}, "squads.camp.orders.work", "its members do already"),
    (camp(*WORK, 0, "role"), "carrier", "squads.camp.orders.work[0].role", "did you mean 'carriers'"),
    (camp(*WORK, 0, "with", "A"), "hone", "squads.camp.orders.work[0].with.A", "did you mean 'home'"),
    (camp(*WORK, 1), {"run": "look"}, "squads.camp.orders.work[2]", "left nobody"),
    (camp(*WORK, 1, "role"), "carriers", "squads.camp.orders.work[1]", "left nobody"),
]


@pytest.mark.parametrize(("steps", "value", "key", "words"), BROKEN, ids=lambda each: str(each)[:60])
def test_broken_squads_say_what_and_where(steps: Steps, value: Any, key: str, words: str) -> None:
    document = with_change(tomllib.loads(GOOD), steps, value)
    text = format_toml({"understudy": "scenario", "version": 1, **document})
    with pytest.raises(FileError) as caught:
        parse_scenario(text, "broken.toml")
    assert caught.value.place == key
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_two_statistics_of_one_name_are_told() -> None:
    squads = """
        [types.pose]
        sensors = [{ kind = "pose" }]
        [[robots]]
        type = "pose"
        [squads.all]
        members = { robots = { of = "pose" } }
        statistics = { at_x = { how = "minimum", reading = "x" }, at = { how = "centroid" } }
    """
    with pytest.raises(
        FileError, match=r"squads.all.statistics.at: reads 'at_x', as does the statistic 'at_x'"
    ):
        parse_scenario('understudy = "scenario"\nversion = 1\nsize = [5, 5]\n' + squads)


def test_the_good_one_is_good() -> None:
    parse_scenario('understudy = "scenario"\nversion = 1\n' + GOOD)
