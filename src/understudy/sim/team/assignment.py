"""Compute how many squads a scenario has of each kind, and assign robots and squads to them (paper section 5.2).

Every member of a sort that some role needs is assigned. Each role of each squad gets its least number, then all get
one more in turn up to the preferred number, then in turn up to the most. Members are assigned in order of rows, so
that neighbors stay together.
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
    """A role that needs members of a sort: the kind of squad, the role's name and index, and its sizes."""

    squad: str
    role: str
    position: int
    member: RoleSpec

    @property
    def usual_count(self) -> int:
        """The number of members that the role has in each squad if there are enough: preferred, else least."""
        return self.member.least if self.member.preferred is None else self.member.preferred

    @property
    def key(self) -> str:
        """The path of the role in the scenario file."""
        return f"squads.{self.squad}.members.{self.role}"


def assign_team_members(scenario: Scenario) -> TeamTree:
    """Return the squads of each world of a scenario with their members; raise SettingError if that is impossible."""
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
    """Sort the kinds of squads so that each follows its members' sorts; raise SettingError if there is a cycle."""
    left, ordered = dict(checker.scenario.squads), list[str]()
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
        ordered += ready
        for name in ready:
            del left[name]
    return tuple(ordered)


def count_team_members(checker: ScenarioErrors, order: Sequence[str]) -> Mapping[str, int]:
    """Count robots of each type and squads of each kind; raise SettingError if they cannot be assigned."""
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
    """Yield the roles that need members of a sort, in the order of the file."""
    for name, squad in scenario.squads.items():
        for index, (role, member) in enumerate(squad.members.items()):
            if member.of == sort:
                yield RoleDemand(name, role, index, member)


def _fixed(squad: SquadSpec) -> int | None:
    """Return the number of squads of a kind if it does not depend on the number of members, else None."""
    if isinstance(squad.count, int):
        return squad.count
    return None if any(member.preferred is not None for member in squad.members.values()) else 1


def _count(scenario: Scenario, name: str, numbers: Mapping[str, int]) -> int:
    """Return the number of squads of a kind: as given, or as many as have members for the preferred sizes."""
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
    """Raise SettingError if a member of a sort would be in no squad, or a squad would have too few of them."""
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
    """Describe in words the numbers that roles need, and their total."""
    words = [
        f"{numbers[wish.squad]} × {size} for {wish.role!r} in {wish.squad!r}"
        for wish, size in zip(wishes, each, strict=True)
    ]
    total = _total(wishes, each, numbers)
    return f"{join_names(words)} {'make' if len(words) == 1 else 'together make'} {total}"


def _seats(scenario: Scenario, sort: str, numbers: Mapping[str, int]) -> Iterator[tuple[RoleDemand, int]]:
    """Yield each role that members of a sort can have, with the index of its squad, squad by squad."""
    wishes = list(_wishes(scenario, sort))
    for name in dict.fromkeys(wish.squad for wish in wishes):
        for squad in range(numbers[name]):
            for wish in wishes:
                if wish.squad == name:
                    yield wish, squad


def _shares(number: int, seats: Sequence[tuple[RoleDemand, int]]) -> list[int]:
    """Return how many members each seat (a role of a squad) gets, distributed in turns, so that squads stay even."""
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
