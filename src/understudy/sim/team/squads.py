"""Convert squads of a scenario to the values that coordinators run with; errors name the key in the scenario."""

from __future__ import annotations

import re
from fractions import Fraction

from understudy.errors import DefinitionError
from understudy.model.binding import Binding
from understudy.model.squad import Assignment, Order, Role, Squad, Statistic
from understudy.sim.scenario.scenario_errors import ScenarioErrors
from understudy.sim.scenario.squad_schema import AssignmentSpec, StatisticSpec

AXES = ("x", "y")
"""The readings that a centroid averages."""
PART = re.compile(r"\d{1,6}/\d{1,6}")
"""The pattern of a share that is a fraction."""


def make_squad(checker: ScenarioErrors, name: str) -> Squad:
    """Make the description of a kind of squad; raise SettingError for invalid statistics or shares."""
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
    """Make the statistics that one entry of a scenario describes: itself, or the two means of a centroid."""
    settings = {field: getattr(spelled, field) for field in spelled.__struct_fields__}
    how, reading = settings.pop("how"), settings.pop("reading")
    try:
        if how != "centroid":
            return (Statistic(name, how, reading, **settings),)
        of = "" if reading is None else f"{reading}_"
        return tuple(Statistic(f"{name}_{axis}", "mean", f"{of}{axis}", **settings) for axis in AXES)
    except DefinitionError as error:
        checker.fail(key, error.problem.removeprefix("it "), error.remedy)


def _duty(checker: ScenarioErrors, key: str, duty: AssignmentSpec) -> Assignment:
    return Assignment(duty.run, Binding(duty.with_), duty.role, _share(checker, f"{key}.share", duty.share))


def _share(checker: ScenarioErrors, key: str, share: int | str | None) -> Fraction | None:
    """Return a share as a number: a fraction below 1 of the members, or a number of members."""
    if share is None or isinstance(share, int):
        return None if share is None else Fraction(share)
    part = Fraction(share) if PART.fullmatch(share) and int(share.partition("/")[2]) else Fraction(0)
    if not 0 < part < 1:
        checker.fail(key, f"is {share!r:.40}", 'give a part such as "1/3", or how many, from 1 up')
    return part
