"""Teams that do not fit together: one error each, before anything runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pytest
from tests.bodies import Scripted, kit
from tests.make.programs import make_automaton

from understudy.errors import DefinitionError, UnboundParameter, UnknownName
from understudy.model.automaton import State
from understudy.model.binding import Binding
from understudy.model.library import Library
from understudy.model.squad import Assignment, Order, Role, Squad
from understudy.runtime.team.members import Member
from understudy.runtime.team.squad_kit import make_squad_kit
from understudy.runtime.team.team import Team, TeamTree

PAIR = Squad("pair", (Role("scouts", "scout"), Role("carriers", "carrier")))
CAMP = Squad("camp", (Role("pairs", "pair"),))
TYPES, TYPE_OF = ("scout", "carrier"), (0, 0, 1, 1)

Lists = Sequence[Sequence[tuple[int, int, int]]]

GOOD: Lists = [[(0, 0, 0), (1, 2, 1)], [(0, 1, 0), (1, 3, 1)]]
BROKEN: list[tuple[Lists, Lists, str]] = [  # the pairs' members, the camps', the error
    ([[(0, 0, 0)], [(0, 0, 0)]], [], "number 1: row 0 of 'scout' is a member, and one of squad 'pair', number 0"),
    ([[(0, 0, 0), (0, 0, 0)]], [], "squad 'pair', number 0: row 0 of 'scout' is a member, and one of"),
    (GOOD, [[(2, 1, 0)], [(2, 1, 0)]], "squad 'camp', number 1: row 1 of 'pair' is a member, and one of"),
    ([[(0, 4, 0)]], [], "squad 'pair', number 0: row 4 of 'scout' is none of the 4 there are"),
    ([[(0, -1, 0)]], [], "row -1 of 'scout' is none"),
    (GOOD, [[(2, 2, 0)]], "squad 'camp', number 0: row 2 of 'pair' is none of the 2 there are"),
    ([[(0, 2, 0)]], [], "row 2 is of 'carrier', and its role 'scouts' is for 'scout'"),
    ([[(0, 0, 1)]], [], "row 0 is of 'scout', and its role 'carriers' is for 'carrier'"),
    ([[(1, 2, 2)]], [], "role 2 of a member is not one of its 2 roles"),
    ([[(2, 0, 0)]], [], "sort 2 of a member is none of the 2 below it"),
    (GOOD, [[(3, 0, 0)]], "sort 3 of a member is none of the 3 below it"),
]  # fmt: skip


def tree(pairs: Lists, camps: Lists) -> TeamTree:
    def members(lists: Lists) -> tuple[tuple[Member, ...], ...]:
        return tuple(tuple(Member(*each) for each in squad) for squad in lists)

    return TeamTree(TYPES, TYPE_OF, ((PAIR, members(pairs)), (CAMP, members(camps))))


@pytest.mark.parametrize(("pairs", "camps", "words"), BROKEN)
def test_everybody_is_there_and_in_one_squad(pairs: Lists, camps: Lists, words: str) -> None:
    with pytest.raises(DefinitionError) as caught:
        tree(pairs, camps)
    assert words in str(caught.value)


def test_names_are_told_apart() -> None:
    with pytest.raises(DefinitionError, match="squad 'scout': its name is taken"):
        TeamTree(TYPES, TYPE_OF, ((Squad("scout", (Role("a", "carrier"),)), ()),))


def test_what_fits() -> None:
    assert tree(GOOD, [[(2, 0, 0), (2, 1, 0)]]).names == ("scout", "carrier", "pair", "camp")


FOLLOWERS = [  # a squad -> the robots below it
    ("pair", 0, [0, 2]),
    ("pair", 1, [1, 3]),
    ("camp", 0, [1, 3]),
    ("camp", 1, [0, 2]),
]


@pytest.mark.parametrize(("name", "number", "robots"), FOLLOWERS)
def test_robots_follow_the_squads_above_them(name: str, number: int, robots: list[int]) -> None:
    found = tree(GOOD, [[(2, 1, 0)], [(2, 0, 0)]]).mark_robots_below(name, number)
    assert found.nonzero()[0].tolist() == robots


SCOUT = Library.from_automata(kit, make_automaton("search"))
CARRIER = Library.from_automata(kit, make_automaton("fetch", parameters=("A",)))


def team(*duties: Assignment) -> Team:
    """A pair whose coordinator gives one order, once a camp's tells it to."""
    pair = Squad(PAIR.name, PAIR.roles, (), {"work": Order(duties)})
    members: Mapping[str, Library] = {"scout": SCOUT, "carrier": CARRIER}
    pairs = Library.from_automata(
        make_squad_kit(pair, (), members), make_automaton("shift", [State("on", "work")])
    )
    camps = Library.from_automata(
        make_squad_kit(CAMP, (), {"pair": pairs}), make_automaton("day", [State("shift", "shift")])
    )
    made = TeamTree(
        TYPES, (0, 1), ((pair, ((Member(0, 0, 0), Member(1, 1, 1)),)), (CAMP, ((Member(2, 0, 0),),)))
    )
    return Team(Scripted(2), made, {**members, "pair": pairs, "camp": camps}, {"camp": ("day", {})})


def test_members_know_what_is_ordered_of_them() -> None:
    team(Assignment("search", role="scouts"), Assignment("fetch", Binding(A="ball"), "carriers")).run(3)
    team(Assignment("forward")).run(3)


LACKING = [
    (Assignment("fly"), "its scouts (scout) have no behavior 'fly'", "search"),
    (Assignment("search"), "its carriers (carrier) have no behavior 'search'", "fetch"),
    (
        Assignment("fetch", Binding(A="ball"), "scouts"),
        "its scouts (scout) have no behavior 'fetch'",
        "search",
    ),
]


@pytest.mark.parametrize(("duty", "words", "known"), LACKING, ids=str)
def test_an_order_that_members_do_not_know(duty: Assignment, words: str, known: str) -> None:
    with pytest.raises(DefinitionError) as caught:
        team(duty)
    assert caught.value.what == "squad 'pair', order 'work'"
    assert words in str(caught.value)
    assert known in caught.value.remedy


def test_an_order_that_lacks_a_target_or_has_one_too_many() -> None:
    with pytest.raises(UnboundParameter) as unbound:
        team(Assignment("fetch", role="carriers"))
    with pytest.raises(UnknownName, match="'B'") as unknown:
        team(Assignment("fetch", Binding(A="ball", B="ball"), role="carriers"))
    for caught in (unbound.value, unknown.value):
        assert "squad 'pair', order 'work' asks for it" in caught.__notes__
