"""Check squads in a scenario: their tree, statistics and orders, and whether there are enough robots for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

from understudy.errors import join_names
from understudy.model.squad import Assignment, Squad, Statistic
from understudy.model.value_kinds import BOOLEAN
from understudy.runtime.body import Reading
from understudy.runtime.team.squad_body import list_squad_readings as readings_of_squad
from understudy.sim.kit import OWN_FEATURES, list_readings, list_type_readings, make_behaviors
from understudy.sim.scenario.scenario_errors import ScenarioErrors, suggest_name
from understudy.sim.scenario.squad_schema import RoleSpec
from understudy.sim.scenario.validate_names import check_identifier
from understudy.sim.team.assignment import count_team_members, sort_squads_bottom_up
from understudy.sim.team.squads import make_squad, make_statistics

Read = Mapping[str, Reading]
"""The readings of a sort of agents, by name."""


def check_squad_sorts(checker: ScenarioErrors) -> None:
    """Raise SettingError if squads contradict each other, or robots cannot be assigned to them."""
    scenario = checker.scenario
    for name in scenario.squads:
        _check_spelling(checker, name)
        _check_members(checker, name)
    order = sort_squads_bottom_up(checker)
    read: dict[str, Read] = {
        name: {reading.name: reading for _, reading in list_type_readings(robot_type)}
        for name, robot_type in scenario.types.items()
    }
    first_uses = {reading.name: (reading, "a robot") for reading in list_readings(scenario)}
    ordered: dict[str, frozenset[str]] = dict.fromkeys(scenario.types, frozenset(make_behaviors(scenario)))
    for name in order:
        squad = make_squad(checker, name)
        _check_statistics(checker, squad, read)
        below = [reading for role in squad.roles for reading in read[role.of].values()]
        if squad.drops is not None:
            yes_or_no = [
                reading.name for reading in below if reading.kind == BOOLEAN and not reading.of_targets
            ]
            checker.check_known(
                f"squads.{name}.drops", squad.drops, yes_or_no, what="yes-or-no reading of its members"
            )
        readings = readings_of_squad(squad, below)
        read[name] = {reading.name: reading for reading in readings}
        _check_sorts(checker, name, first_uses, readings)
        ordered[name] = _check_orders(checker, squad, ordered)
    count_team_members(checker, order)


def _check_spelling(checker: ScenarioErrors, name: str) -> None:
    """Raise SettingError if a name is not valid, or a squad has the name of a type of robots."""
    squad, key = checker.scenario.squads[name], f"squads.{name}"
    check_identifier(checker, "squads", name)
    if name in checker.scenario.types:
        checker.fail(key, "has the name of a type of robots", "give another name")
    for table in ("members", "statistics", "orders"):
        for own in getattr(squad, table):
            check_identifier(checker, f"{key}.{table}", own)
    for own, statistic in squad.statistics.items():
        if statistic.flag is not None:
            check_identifier(checker, f"{key}.statistics.{own}.flag", statistic.flag)
    for own, duties in squad.orders.items():
        for index, duty in enumerate(duties):
            for at, word in (("run", duty.run), *(("with", parameter) for parameter in duty.with_)):
                check_identifier(checker, f"{key}.orders.{own}[{index}].{at}", word)


def _check_members(checker: ScenarioErrors, name: str) -> None:
    squad, key = checker.scenario.squads[name], f"squads.{name}.members"
    if not squad.members:
        checker.fail(key, "is empty", "give at least one role")
    for role, member in squad.members.items():
        sorts = (*checker.scenario.types, *checker.scenario.squads)
        checker.check_known(f"{key}.{role}.of", member.of, sorts, what="type of robots or sort of squad")
        _check_sizes(checker, f"{key}.{role}", member)
    if not any(member.least for member in squad.members.values()):
        at = f"{key}.{next(iter(squad.members))}.least"
        checker.fail(at, "is 0, which allows squads without members", "give 1 or more for one of the roles")


def _check_sizes(checker: ScenarioErrors, key: str, member: RoleSpec) -> None:
    sizes = {"least": member.least, "preferred": member.preferred, "most": member.most}
    sizes_in_order = [(name, size) for name, size in sizes.items() if size is not None]
    for (name, size), (above, bound) in pairwise(sizes_in_order):
        if size > bound:
            problem = f"is {size}, above {above}, {bound}"
            checker.fail(f"{key}.{name}", problem, "give least ≤ preferred ≤ most")


def _check_statistics(checker: ScenarioErrors, squad: Squad, read: Mapping[str, Read]) -> None:
    """Raise SettingError if statistics share a name, or members do not have the readings that they need."""
    roles = [role.name for role in squad.roles]
    taken = {feature.name: "a feature of all that are taught" for feature in OWN_FEATURES}
    for own, spelled in checker.scenario.squads[squad.name].statistics.items():
        key = f"squads.{squad.name}.statistics.{own}"
        for each in make_statistics(checker, key, own, spelled):
            if each.name in taken:
                checker.fail(key, f"reads {each.name!r}, as does {taken[each.name]}", "rename one of the two")
            taken[each.name] = f"the statistic {own!r}"
            if each.role is not None:
                checker.check_known(f"{key}.role", each.role, roles, what="role")
            if None not in (each.least, each.below) and (each.least or 0.0) >= (each.below or 0.0):
                checker.fail(f"{key}.least", f"is {each.least}, and below is {each.below}", "give less")
            if each.reading is not None:
                at = f"{key}.reading" if spelled.reading is not None else key
                _check_reading(checker, at, each, squad, read)


def _check_reading(
    checker: ScenarioErrors, key: str, statistic: Statistic, squad: Squad, read: Mapping[str, Read]
) -> None:
    name, role_name = statistic.reading or "", statistic.role
    roles = {role.name: read[role.of] for role in squad.roles if role_name in (None, role.name)}
    having = [role for role, readings in roles.items() if name in readings]
    if not having:
        who = "none of its members" if role_name is None else f"nobody in the role {role_name!r}"
        names = dict.fromkeys(reading for readings in roles.values() for reading in readings)
        checker.fail(key, f"is of {name!r}, which {who} reads", suggest_name(name, names, what="reading"))
    if len(having) < len(roles):
        problem = f"is of {name!r}, which only members in {join_names(map(repr, having))} read"
        checker.fail(key, problem, f"give one role, such as role = {having[0]!r}")


def _check_sorts(
    checker: ScenarioErrors,
    squad: str,
    first_uses: dict[str, tuple[Reading, str]],
    readings: tuple[Reading, ...],
) -> None:
    """Raise SettingError if a name stands for different kinds of readings."""
    for reading in readings:
        before, of = first_uses.setdefault(reading.name, (reading, f"the squad {squad!r}"))
        if replace(before, doc="") != replace(reading, doc=""):
            own = checker.scenario.squads[squad].statistics
            name = reading.name if reading.name in own else reading.name[:-2]
            problem = f"reads {reading.name!r}, which is a different reading for {of}"
            checker.fail(f"squads.{squad}.statistics.{name}", problem, "rename one of the two")


def _check_orders(
    checker: ScenarioErrors, squad: Squad, ordered: Mapping[str, frozenset[str]]
) -> frozenset[str]:
    """Check the orders of a kind of squads; return all that its coordinators can order."""
    behaviors = frozenset[str]().union(*(ordered[role.of] for role in squad.roles))
    for name, order in squad.orders.items():
        key = f"squads.{squad.name}.orders.{name}"
        if name in behaviors:
            checker.fail(key, "has the name of what its members do already", "give another name")
        if not order.duties:
            checker.fail(key, "is empty", "give the behavior that members run")
        _check_duties(checker, key, order.duties, squad)
    return behaviors | set(squad.orders)


def _check_duties(checker: ScenarioErrors, key: str, duties: tuple[Assignment, ...], squad: Squad) -> None:
    """Raise SettingError for unknown roles or targets, or if earlier duties leave no members for a later one."""
    roles = [role.name for role in squad.roles]
    left = set(roles)
    for index, duty in enumerate(duties):
        at = f"{key}[{index}]"
        if duty.role is not None:
            checker.check_known(f"{at}.role", duty.role, roles, what="role")
        for parameter, target in duty.binding.items():
            checker.check_known(f"{at}.with.{parameter}", target, checker.scenario.targets, what="target")
        mine = left & ({duty.role} if duty.role is not None else left)
        if not mine:
            checker.fail(at, "is left nobody by the duties before it", "give one of these a share")
        if duty.share is None:
            left -= mine
