"""Kits of coordinators: a feature for each statistic, and for each behavior of their members the order to run it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from understudy.errors import DefinitionError
from understudy.model.behaviors import Behavior
from understudy.model.binding import Binding
from understudy.model.features import Feature, FlagFeature, TimeInState
from understudy.model.library import Kit, Library
from understudy.model.squad import Assignment, Order, Squad
from understudy.runtime.body import Reading
from understudy.runtime.team.squad_body import list_squad_readings

PARAMETER = "A"
"""What features of targets call their target."""


def make_squad_kit(squad: Squad, below: Sequence[Reading], members: Mapping[str, Library]) -> Kit:
    """Make the kit to teach a coordinator with, given its members' readings and the library of each sort of them."""
    fresh = {each.name: each.reset_value for each in squad.statistics}
    features = [
        Feature(
            reading.name, reading.kind, reading.name, of=PARAMETER if reading.of_targets else None,
            unit=reading.unit, doc=reading.doc, fresh=fresh[reading.name],
        )
        for reading in list_squad_readings(squad, below)
    ]  # fmt: skip
    targets = next(iter(members.values())).kit.targets.values()
    own = (FlagFeature("done"), FlagFeature("failed"), TimeInState())
    return Kit.from_parts(*features, *own, *_orders(squad, members), *targets)


def _orders(squad: Squad, members: Mapping[str, Library]) -> list[Behavior]:
    parameters_of: dict[str, tuple[str, ...]] = {}
    knows: dict[str, list[str]] = {}
    for role in squad.roles:
        library = members[role.of]
        for name in (*library.kit.behaviors, *library.taught):
            parameters = library.parameters(name)
            if parameters_of.setdefault(name, parameters) != parameters:
                raise DefinitionError(
                    what=f"squad {squad.name!r}",
                    problem=f"its members have two behaviors {name!r}, with other parameters",
                    remedy="rename one of the two",
                )
            knows.setdefault(name, []).append(role.name)
    behaviors = []
    for name, parameters in parameters_of.items():
        binding = Binding({each: each for each in parameters})
        everyone = len(knows[name]) == len(squad.roles)
        duties = [Assignment(name, binding, None if everyone else role) for role in knows[name]]
        doc = f"Order {'all' if everyone else ' and '.join(knows[name])} to run {name}."
        behaviors.append(
            Behavior(name, doc=doc, parameters=parameters, order=Order(tuple(dict.fromkeys(duties))))
        )
    for name, order in squad.orders.items():
        if name in parameters_of:
            raise DefinitionError(
                what=f"squad {squad.name!r}, order {name!r}",
                problem="a behavior of its members has this name",
                remedy="rename the order",
            )
        doc = f"Order {'; '.join(map(str, order.duties))}."
        behaviors.append(Behavior(name, doc=doc, order=order))
    return behaviors
