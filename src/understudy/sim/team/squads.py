"""Squads as a scenario spells them, as the values that coordinators run with; what is wrong names its key."""

from __future__ import annotations

import re
from fractions import Fraction

from understudy.errors import DefinitionError
from understudy.model.binding import Binding
from understudy.model.squad import Assignment, Order, Role, Squad, Statistic
from understudy.sim.scenario.scenario_errors import ScenarioErrors
from understudy.sim.scenario.squad_schema import AssignmentSpec, StatisticSpec

AXES = ("x", "y")
"""What a centroid is the mean of."""
PART = re.compile(r"\d{1,6}/\d{1,6}")
"""How a share is spelled that is a part."""


def make_squad(checker: ScenarioErrors, name: str) -> Squad:
    """The squads of a sort; SettingError where a statistic contradicts itself or a share is none."""
    squad, key = checker.scenario.squads[name], f"squads.{name}"
    return Squad(
        name,
        tuple(Role(role, each.of, each.least, each.preferred, each.most) for role, each in squad.members.items()),
        tuple(
            statistic
            for own, each in squad.statistics.items()
            for statistic in make_statistics(checker, f"{key}.statistics.{own}", own, each)
        ),
        {
            order: Order(tuple(_duty(checker, f"{key}.orders.{order}[{at}]", duty) for at, duty in enumerate(duties)))
            for order, duties in squad.orders.items()
        },
        squad.drops,
        squad.doc,
    )  # fmt: skip


def make_statistics(
    checker: ScenarioErrors, key: str, name: str, spelled: StatisticSpec
) -> tuple[Statistic, ...]:
    """The statistics that one of a scenario stands for: itself, or the two means of a centroid."""
    given = {field: getattr(spelled, field) for field in spelled.__struct_fields__}
    how, reading = given.pop("how"), given.pop("reading")
    try:
        if how != "centroid":
            return (Statistic(name, how, reading, **given),)
        of = "" if reading is None else f"{reading}_"
        return tuple(Statistic(f"{name}_{axis}", "mean", f"{of}{axis}", **given) for axis in AXES)
    except DefinitionError as error:
        checker.fail(key, error.problem.removeprefix("it "), error.remedy)


def _duty(checker: ScenarioErrors, key: str, duty: AssignmentSpec) -> Assignment:
    return Assignment(duty.run, Binding(duty.with_), duty.role, _share(checker, f"{key}.share", duty.share))


def _share(checker: ScenarioErrors, key: str, share: int | str | None) -> Fraction | None:
    """A share as a number: a part of them as a fraction below 1, or how many."""
    if share is None or isinstance(share, int):
        return None if share is None else Fraction(share)
    part = Fraction(share) if PART.fullmatch(share) and int(share.partition("/")[2]) else Fraction(0)
    if not 0 < part < 1:
        checker.fail(key, f"is {share!r:.40}", 'give a part such as "1/3", or how many, from 1 up')
    return part
