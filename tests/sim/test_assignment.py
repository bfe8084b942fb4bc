"""Dealing robots to squads: by hand, and for whatever a scenario asks for."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from understudy.errors import SettingError
from understudy.model.squad import Assignment, Order, Squad, Statistic
from understudy.runtime.team.members import Member
from understudy.runtime.team.team import TeamTree
from understudy.sim.scenario.files import format_scenario, load_scenario, parse_scenario
from understudy.sim.scenario.scenario_errors import ScenarioErrors
from understudy.sim.scenario.schema import RobotGroup, RobotType, Scenario
from understudy.sim.scenario.squad_schema import RoleSpec, SquadSpec
from understudy.sim.scenario.validation import check_scenario
from understudy.sim.team.assignment import assign_team_members, sort_squads_bottom_up
from understudy.sim.team.squads import make_squad

Roles = Mapping[str, RoleSpec]


def of(sort: str, least: int = 1, preferred: int | None = None, most: int | None = None) -> RoleSpec:
    return RoleSpec(of=sort, least=least, preferred=preferred, most=most)


def squad(count: int | None = None, /, **members: RoleSpec) -> SquadSpec:
    return SquadSpec(members=members) if count is None else SquadSpec(members=members, count=count)


def scenario(squads: Mapping[str, SquadSpec], *robots: tuple[str, int]) -> Scenario:
    """Small robots, so many of each type one after the other."""
    kinds: dict[str, RobotType] = {name: RobotType(radius=0.01) for name in ("a", "b")}
    groups = tuple(RobotGroup(type=name, count=count) for name, count in robots)
    return Scenario(size=(50.0, 50.0), types=kinds, robots=groups, squads=squads)


def rows(tree: TeamTree) -> dict[str, list[dict[str, list[int]]]]:
    """Of each sort of squads, squad after squad: role -> the rows of its members."""
    found: dict[str, list[dict[str, list[int]]]] = {}
    for sort, lists in tree.squads:
        found[sort.name] = [
            {
                role.name: [each.row for each in members if each.role == at]
                for at, role in enumerate(sort.roles)
            }
            for members in lists
        ]
    return found


A = (("a", 10),)
DEALT: list[
    tuple[dict[str, SquadSpec], tuple[tuple[str, int], ...], dict[str, list[dict[str, list[int]]]]]
] = [
    ({"s": squad(r=of("a"))}, A, {"s": [{"r": [*range(10)]}]}),
    ({"s": squad(2, r=of("a"))}, A, {"s": [{"r": [*range(5)]}, {"r": [*range(5, 10)]}]}),
    # as many squads as get what they prefer; the rest goes to the first by turns
    ({"s": squad(r=of("a", 2, 4))}, A, {"s": [{"r": [0, 1, 2, 3, 4]}, {"r": [5, 6, 7, 8, 9]}]}),
    ({"s": squad(r=of("a", 2, 4))}, (("a", 9),), {"s": [{"r": [0, 1, 2, 3, 4]}, {"r": [5, 6, 7, 8]}]}),
    ({"s": squad(r=of("a", 2, 4))}, (("a", 3),), {"s": [{"r": [0, 1, 2]}]}),
    ({"s": squad(r=of("a", 2, 3))}, A, {"s": [{"r": [0, 1, 2, 3]}, {"r": [4, 5, 6]}, {"r": [7, 8, 9]}]}),
    # what is preferred comes before what is more than that
    (
        {"s": squad(2, few=of("a", 1, most=3), many=of("a", 1, 3))},
        A,
        {"s": [{"few": [0, 1], "many": [2, 3, 4]}, {"few": [5, 6], "many": [7, 8, 9]}]},
    ),
    (
        {"s": squad(2, few=of("a", 0), many=of("a", 1, 3))},
        (("a", 5),),
        {"s": [{"few": [], "many": [0, 1, 2]}, {"few": [], "many": [3, 4]}]},
    ),
    # two roles, and two sorts of squads, of one type: together they have what they prefer
    (
        {"s": squad(x=of("a", 1, 2), y=of("a", 1, 3))},
        A,
        {"s": [{"x": [0, 1], "y": [2, 3, 4]}, {"x": [5, 6], "y": [7, 8, 9]}]},
    ),
    (
        {"s": squad(1, r=of("a", 4, most=4)), "t": squad(r=of("a", 1, 2))},
        A,
        {"s": [{"r": [0, 1, 2, 3]}], "t": [{"r": [4, 5]}, {"r": [6, 7]}, {"r": [8, 9]}]},
    ),
    # groups of robots in the order of the file; a type that nobody wants is in no squad
    ({"s": squad(r=of("a"))}, (("a", 2), ("b", 3), ("a", 1)), {"s": [{"r": [0, 1, 5]}]}),
    (
        {"s": squad(2, x=of("b"), y=of("a"))},
        (("a", 2), ("b", 3)),
        {"s": [{"x": [2, 3], "y": [0]}, {"x": [4], "y": [1]}]},
    ),
    # squads of squads, declared in any order, beside robots
    (
        {"top": squad(of=of("s")), "s": squad(r=of("a", 1, 3))},
        (("a", 9),),
        {"s": [{"r": [0, 1, 2]}, {"r": [3, 4, 5]}, {"r": [6, 7, 8]}], "top": [{"of": [0, 1, 2]}]},
    ),
    (
        {
            "s": squad(r=of("a", 1, 2)),
            "t": squad(2, below=of("s"), scout=of("b", 1, 1, 1)),
            "u": squad(below=of("t", 2, most=2)),
        },
        (("b", 2), ("a", 6)),
        {
            "s": [{"r": [2, 3]}, {"r": [4, 5]}, {"r": [6, 7]}],
            "t": [{"below": [0, 1], "scout": [0]}, {"below": [2], "scout": [1]}],
            "u": [{"below": [0, 1]}],
        },
    ),
]


@pytest.mark.parametrize(("squads", "robots", "dealt"), DEALT)
def test_who_is_in_which_squad(
    squads: dict[str, SquadSpec],
    robots: tuple[tuple[str, int], ...],
    dealt: dict[str, list[dict[str, list[int]]]],
) -> None:
    made = scenario(squads, *robots)
    check_scenario(made)
    assert rows(assign_team_members(made)) == dealt


def test_the_tree_knows_types_and_sorts_by_number() -> None:
    made = scenario(
        {"top": squad(of=of("s")), "s": squad(x=of("b"), y=of("a"))}, ("a", 1), ("b", 1), ("a", 1)
    )
    tree = assign_team_members(made)
    assert tree.names == ("a", "b", "s", "top")
    assert tree.type_of == (0, 1, 0)
    assert [lists for _, lists in tree.squads] == [
        ((Member(1, 1, 0), Member(0, 0, 1), Member(0, 2, 1)),),
        ((Member(2, 0, 0),),),
    ]


def test_a_scenario_without_squads_has_none() -> None:
    assert assign_team_members(load_scenario("forage-team")).squads == ()


SPELLED = """
understudy = "scenario"
version = 1
size = [10, 8]
[types.rover]
sensors = [{ kind = "pose" }, { kind = "camera" }, { kind = "stuck" }]
color = "red"
[[robots]]
type = "rover"
count = 4
[targets]
red = { color = "red" }
[squads.pair]
doc = "Two who go together."
count = 2
drops = "stuck"
[squads.pair.members.robots]
of = "rover"
least = 2
preferred = 2
most = 3
[squads.pair.statistics]
near = { how = "count", reading = "blob_size", least = 9, below = 99.5, role = "robots", doc = "How many are near." }
lost = { how = "none", reading = "blob_x", for_s = 2 }
last = { how = "any", flag = "done", since = true }
middle = { how = "centroid", within_s = 3 }
[squads.pair.orders]
part = [
    { run = "go", with = { A = "red" }, share = "1/3" },
    { run = "stop", role = "robots", share = 2 },
    { run = "wait" },
]
[squads.all]
members = { pairs = { of = "pair" } }
statistics = { center = { how = "centroid", reading = "middle" } }
[radio]
delay_s = 0.2
loss = 0.1
"""


def test_a_squad_as_it_is_spelled() -> None:
    made = parse_scenario(SPELLED)
    checker = ScenarioErrors(made)
    pair, everyone = (make_squad(checker, name) for name in sort_squads_bottom_up(checker))
    assert isinstance(pair, Squad)
    assert (pair.name, pair.doc, everyone.name) == ("pair", "Two who go together.", "all")
    assert (pair.drops, everyone.drops) == ("stuck", None)
    (role,) = pair.roles
    assert (role.name, role.of, role.least, role.preferred, role.most) == ("robots", "rover", 2, 2, 3)
    assert pair.statistics == (
        Statistic("near", "count", "blob_size", None, "robots", 9.0, 99.5, doc="How many are near."),
        Statistic("lost", "none", "blob_x", for_s=2.0),
        Statistic("last", "any", flag="done", since=True),
        Statistic("middle_x", "mean", "x", within_s=3.0),
        Statistic("middle_y", "mean", "y", within_s=3.0),
    )
    assert everyone.statistics == (
        Statistic("center_x", "mean", "middle_x"),
        Statistic("center_y", "mean", "middle_y"),
    )
    go, stop, wait = pair.orders["part"].duties
    assert (go.behavior, dict(go.binding), go.role, go.share) == ("go", {"A": "red"}, None, Fraction(1, 3))
    assert (stop.role, stop.share) == ("robots", Fraction(2))
    assert wait == Assignment("wait")
    assert pair.orders == {"part": Order((go, stop, wait))}
    assert (made.radio.delay_s, made.radio.loss) == (0.2, 0.1)


def test_written_and_read_again_it_is_the_same() -> None:
    made = parse_scenario(SPELLED)
    text = format_scenario(made)
    assert parse_scenario(text) == made
    assert format_scenario(parse_scenario(text)) == text
    assert msgspec.json.decode(msgspec.json.encode(made), type=Scenario) == made
    for heading in ("[squads.pair]", "[squads.pair.members.robots]", "[squads.all.statistics]", "[radio]"):
        assert heading in text


SIZES = st.none() | st.integers(1, 6)


def members(sorts: tuple[str, ...]) -> st.SearchStrategy[RoleSpec]:
    """Any role; mostly one that can be."""
    some = st.builds(of, st.sampled_from(sorts), st.integers(0, 3), SIZES, SIZES)
    return some.map(in_order) | some


def in_order(member: RoleSpec) -> RoleSpec:
    sizes = iter(sorted(size for size in (member.preferred, member.most) if size is not None))
    preferred = None if member.preferred is None else next(sizes)
    most = None if member.most is None else next(sizes)
    least = min([member.least, *(size for size in (preferred, most) if size is not None)])
    return of(member.of, least, preferred, most)


@st.composite
def trees(draw: st.DrawFn) -> Scenario:
    """Whatever can be asked for."""
    names = draw(st.permutations(("s", "t", "u")))[: draw(st.integers(1, 3))]
    sorts: tuple[str, ...] = ("a", "b")
    squads = {}
    for name in names:
        any_sort = draw(st.integers(0, 9)) == 0
        inside = ("a", "b", *names) if any_sort else sorts
        roles = draw(
            st.dictionaries(st.sampled_from("xyz"), members(inside), min_size=not any_sort, max_size=2)
        )
        squads[name] = squad(draw(st.none() | st.integers(1, 3)), **roles)
        sorts = (*sorts, name)
    groups = draw(st.lists(st.tuples(st.sampled_from("ab"), st.integers(4, 12)), min_size=1, max_size=4))
    shuffled = dict(draw(st.permutations(list(squads.items()))))
    return scenario(shuffled, *groups)


def bounds(number: int, member: RoleSpec) -> tuple[bool, bool]:
    """Whether a role has enough, and not too many."""
    return number >= member.least, member.most is None or number <= member.most


@settings(max_examples=120)
@given(trees())
def test_everybody_is_in_one_squad_and_every_role_within_its_bounds_or_it_is_one_error(
    made: Scenario,
) -> None:
    refused = None
    try:
        check_scenario(made)
    except SettingError as error:
        refused = error
    if refused is not None:
        assert refused.setting.startswith("squads.")
        assert "\n" not in str(refused)
        return
    tree = assign_team_members(made)
    assert assign_team_members(parse_scenario(format_scenario(made))) == tree
    found = rows(tree)
    there: dict[str, list[int]] = {
        **{
            name: [row for row, kind in enumerate(tree.type_of) if kind == at]
            for at, name in enumerate(tree.types)
        },
        **{name: list(range(len(lists))) for name, lists in found.items()},
    }
    for sort, mine in there.items():
        wishes = [
            (name, role, member)
            for name, one in made.squads.items()
            for role, member in one.members.items()
            if member.of == sort
        ]
        dealt: list[int] = []
        short, over = False, False
        for name in dict.fromkeys(name for name, _, _ in wishes):
            for one in found[name]:
                for role, member in ((role, member) for at, role, member in wishes if at == name):
                    assert bounds(len(one[role]), member) == (True, True)
                    usual = member.least if member.preferred is None else member.preferred
                    short, over = short or len(one[role]) < usual, over or len(one[role]) > usual
                    dealt += one[role]
        assert dealt == (mine if wishes else [])  # all of them, and neighbors together
        assert not (short and over)
    for name, spelled in made.squads.items():
        assert spelled.count in (msgspec.UNSET, len(found[name]))


@given(st.integers(1, 20), st.integers(1, 5), st.lists(members(("a",)), min_size=1, max_size=3))
def test_only_what_cannot_be_met_is_refused(robots: int, count: int, roles: list[RoleSpec]) -> None:
    made = scenario({"s": squad(count, **{"xyz"[at]: role for at, role in enumerate(roles)})}, ("a", robots))
    least = count * sum(role.least for role in roles)
    most = [role.most for role in roles]
    sizes = [[size for size in (role.least, role.preferred, role.most) if size is not None] for role in roles]
    can: Any = (
        0 < least <= robots
        and (None in most or count * sum(each or 0 for each in most) >= robots)
        and all(given == sorted(given) for given in sizes)
    )
    try:
        check_scenario(made)
    except SettingError:
        assert not can
    else:
        assert can


def test_ten_thousand_robots_are_dealt_quickly() -> None:
    squads = {"s": squad(r=of("a", 1, 4)), "t": squad(r=of("s", 1, 50)), "u": squad(r=of("t"))}
    made = scenario(squads, ("a", 10_000))
    assert [len(lists) for _, lists in assign_team_members(made).squads] == [2500, 50, 1]
