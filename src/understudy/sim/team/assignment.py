"""Dealing: how many squads a scenario has of each sort, and who is in which (paper section 5.2).

Everybody of a sort that some role wants is dealt: each role of each squad gets its least, then all get one more by
turns up to what they prefer, then by turns up to their most. Neighbors stay together: the first squad has the first.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from understudy.errors import join_names
from understudy.runtime.team.members import Member
from understudy.runtime.team.team import TeamTree
from understudy.sim.params import count_robots
from understudy.sim.scenario.scenario_errors import ScenarioErrors
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario.squad_schema import RoleSpec, SquadSpec
from understudy.sim.team.squads import make_squad


class RoleDemand(NamedTuple):
    """A role that wants members of a sort: of which sort of squad, which of its roles."""

    squad: str
    role: str
    position: int
    member: RoleSpec

    @property
    def usual_count(self) -> int:
        """How many it likes to have in each squad."""
        return self.member.least if self.member.preferred is None else self.member.preferred

    @property
    def key(self) -> str:
        """Where it stands in the scenario."""
        return f"squads.{self.squad}.members.{self.role}"


def assign_team_members(scenario: Scenario) -> TeamTree:
    """The team of each world of a scenario that can be."""
    checker = ScenarioErrors(scenario)
    order, types = sort_squads_bottom_up(checker), tuple(scenario.types)
    numbers = count_team_members(checker, order)
    type_of = tuple(types.index(name) for name in _types_of_rows(scenario))
    members: dict[str, list[list[Member]]] = {name: [[] for _ in range(numbers[name])] for name in order}
    for band, sort in enumerate((*types, *order)):
        rows: Iterator[int] = iter(range(numbers[sort]))
        if sort in types:
            rows = (row for row, kind in enumerate(type_of) if kind == band)
        seats = list(_seats(scenario, sort, numbers))
        for (wish, squad), share in zip(seats, _shares(numbers[sort], seats), strict=True):
            members[wish.squad][squad] += [Member(band, next(rows), wish.position) for _ in range(share)]
    squads = (
        (make_squad(checker, name), tuple(tuple(sorted(squad, key=_by_role)) for squad in members[name]))
        for name in order
    )
    return TeamTree(types, type_of, tuple(squads))


def sort_squads_bottom_up(checker: ScenarioErrors) -> tuple[str, ...]:
    """The sorts of squads, each after those that its members are of; SettingError where they go in a circle."""
    left, found = dict(checker.scenario.squads), list[str]()
    while left:
        ready = [name for name, squad in left.items() if not _within(squad, left)]
        if not ready:
            cycle = [next(iter(left))]
            while cycle[-1] not in cycle[:-1]:
                cycle.append(_within(left[cycle[-1]], left)[0].of)
            cycle = cycle[cycle.index(cycle[-1]) :]
            role = next(role for role, member in left[cycle[0]].members.items() if member.of == cycle[1])
            problem = f"leads back to its own squad: {' -> '.join(cycle)}"
            remedy = "let squads have members that are of no squad above"
            checker.fail(f"squads.{cycle[0]}.members.{role}.of", problem, remedy)
        found += ready
        for name in ready:
            del left[name]
    return tuple(found)


def count_team_members(checker: ScenarioErrors, order: Sequence[str]) -> Mapping[str, int]:
    """How many robots there are of each type and squads of each sort; SettingError where they cannot be dealt."""
    scenario = checker.scenario
    numbers = dict.fromkeys(scenario.types, 0)
    for robots in scenario.robots:
        numbers[robots.type] += count_robots(robots.count, robots.at)
    for name in order:
        numbers[name] = _count(scenario, name, numbers)
    for sort in numbers:
        _check_wishes(checker, sort, numbers)
    return numbers


def _within(squad: SquadSpec, sorts: Mapping[str, SquadSpec]) -> list[RoleSpec]:
    return [member for member in squad.members.values() if member.of in sorts]


def _types_of_rows(scenario: Scenario) -> Iterator[str]:
    for robots in scenario.robots:
        for _ in range(count_robots(robots.count, robots.at)):
            yield robots.type


def _by_role(member: Member) -> tuple[int, int]:
    return member.role, member.row


def _wishes(scenario: Scenario, sort: str) -> Iterator[RoleDemand]:
    """The roles that members of a sort are for, as they are declared."""
    for name, squad in scenario.squads.items():
        for index, (role, member) in enumerate(squad.members.items()):
            if member.of == sort:
                yield RoleDemand(name, role, index, member)


def _fixed(squad: SquadSpec) -> int | None:
    """How many squads of a sort there are, where that does not depend on how many members there are."""
    if isinstance(squad.count, int):
        return squad.count
    return None if any(member.preferred is not None for member in squad.members.values()) else 1


def _count(scenario: Scenario, name: str, numbers: Mapping[str, int]) -> int:
    """How many squads of a sort: as said, or as many as there are members for, each role with what it prefers."""
    squad = scenario.squads[name]
    fixed = _fixed(squad)
    if fixed is not None:
        return fixed
    fitting = []
    for sort in dict.fromkeys(member.of for member in squad.members.values() if member.preferred is not None):
        free, together = numbers[sort], 0
        for wish in _wishes(scenario, sort):
            others = _fixed(scenario.squads[wish.squad])
            free -= (others or 0) * wish.usual_count
            together += wish.usual_count if others is None else 0
        fitting.append(free // together)
    return max(1, min(fitting))


def _check_wishes(checker: ScenarioErrors, sort: str, numbers: Mapping[str, int]) -> None:
    """Whether everybody of a sort finds a squad, and every squad enough of them."""
    wishes = list(_wishes(checker.scenario, sort))
    if not wishes:
        return
    sorts = "robots of the type" if sort in checker.scenario.types else "squads of the sort"
    there = f"there are {numbers[sort]} {sorts} {sort!r}"
    least = [wish.member.least for wish in wishes]
    needed = _total(wishes, least, numbers)
    if needed > numbers[sort]:
        problem = f"cannot be met: {_sum(wishes, least, numbers)}, and {there}"
        checker.fail(f"{wishes[0].key}.least", problem, "ask for fewer, or have more of them")
    most = [wish.member.most for wish in wishes if wish.member.most is not None]
    if len(most) == len(wishes) and _total(wishes, most, numbers) < numbers[sort]:
        problem = f"leaves somebody in no squad: {_sum(wishes, most, numbers)}, and {there}"
        remedy = "give more, leave it out, or give a larger count of squads"
        checker.fail(f"{wishes[0].key}.most", problem, remedy)


def _total(wishes: Sequence[RoleDemand], each: Sequence[int], numbers: Mapping[str, int]) -> int:
    return sum(numbers[wish.squad] * size for wish, size in zip(wishes, each, strict=True))


def _sum(wishes: Sequence[RoleDemand], each: Sequence[int], numbers: Mapping[str, int]) -> str:
    """What wishes add up to, in words."""
    words = [
        f"{numbers[wish.squad]} × {size} for {wish.role!r} in {wish.squad!r}"
        for wish, size in zip(wishes, each, strict=True)
    ]
    total = _total(wishes, each, numbers)
    return f"{join_names(words)} {'make' if len(words) == 1 else 'together make'} {total}"


def _seats(scenario: Scenario, sort: str, numbers: Mapping[str, int]) -> Iterator[tuple[RoleDemand, int]]:
    """The roles of each squad that members of a sort are for, squad after squad."""
    wishes = list(_wishes(scenario, sort))
    for name in dict.fromkeys(wish.squad for wish in wishes):
        for squad in range(numbers[name]):
            for wish in wishes:
                if wish.squad == name:
                    yield wish, squad


def _shares(number: int, seats: Sequence[tuple[RoleDemand, int]]) -> list[int]:
    """How many of them each role of each squad gets: role by role, a turn of all its squads, so that they stay even."""
    shares = [wish.member.least for wish, _ in seats]
    bounds = [
        [wish.usual_count for wish, _ in seats],
        [number if wish.member.most is None else wish.member.most for wish, _ in seats],
    ]
    left = number - sum(shares)
    order = {key: place for place, key in enumerate(dict.fromkeys(wish.key for wish, _ in seats))}
    turns = sorted(range(len(seats)), key=lambda seat: order[seats[seat][0].key])
    for most in bounds:
        some = turns
        while left > 0 and some:
            some = [seat for seat in some if shares[seat] < most[seat]]
            for seat in some[:left]:
                shares[seat] += 1
            left -= min(left, len(some))
    return shares
