"""Kits of types: what robots of one type can be taught with, where others of the scenario sense or do other things."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from understudy.model.behaviors import Behavior
from understudy.model.features import AnyFeature, Feature
from understudy.model.kit import Kit
from understudy.model.target import Target
from understudy.sim.kit import behaviors_of, readings_of, readings_of_type
from understudy.sim.scenario.schema import Scenario


def kits_of(scenario: Scenario, kit: Kit) -> Mapping[str, Kit]:
    """The kit of each type: the scenario's without what only other types sense or do; `kit` itself if that is all."""
    return MappingProxyType({name: _of_type(scenario, name, kit) for name in scenario.types})


def mixed(kits: Mapping[str, Kit]) -> bool:
    """Whether types can be taught different things, so that each has a library of its own."""
    parts = [(set(kit.features), set(kit.behaviors)) for kit in kits.values()]
    return any(each != parts[0] for each in parts)


def _of_type(scenario: Scenario, name: str, kit: Kit) -> Kit:
    kind = scenario.types[name]
    mine = {reading.name for _, reading in readings_of_type(kind)}
    others = {reading.name for reading in readings_of(scenario)} - mine
    foreign = set(behaviors_of(scenario)) - set(kind.behaviors)
    parts = [part for part in kit.parts if not _is_of(part, others, foreign)]
    return kit if len(parts) == len(kit.parts) else Kit.of(*parts)


def _is_of(part: AnyFeature | Behavior | Target, readings: set[str], behaviors: set[str]) -> bool:
    """Whether a part is a feature of one of these readings, or one of these behaviors."""
    if isinstance(part, Behavior):
        return part.name in behaviors
    return isinstance(part, Feature) and part.reading in readings
