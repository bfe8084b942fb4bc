"""Kits: the named parts that come from code - features, basic behaviors and targets - as one plain value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Self, TypeVar

from understudy.errors import DefinitionError
from understudy.model.behaviors import Behavior
from understudy.model.features import AnyFeature
from understudy.model.target import Target

Part = TypeVar("Part", AnyFeature, Behavior, Target)


@dataclass(frozen=True)
class Kit:
    """Features, basic behaviors and targets by name."""

    features: Mapping[str, AnyFeature]
    behaviors: Mapping[str, Behavior]
    targets: Mapping[str, Target]

    @classmethod
    def of(cls, *parts: AnyFeature | Behavior | Target) -> Self:
        """A kit of these parts, in this order; two of one sort and name are refused."""
        features: dict[str, AnyFeature] = {}
        behaviors: dict[str, Behavior] = {}
        targets: dict[str, Target] = {}
        for part in parts:
            if isinstance(part, Behavior):
                _add(behaviors, part, "behaviors")
            elif isinstance(part, Target):
                _add(targets, part, "targets")
            elif isinstance(part, AnyFeature):
                _add(features, part, "features")
            else:
                remedy = "give features, behaviors and targets, one by one"
                raise DefinitionError(what="kit", problem=f"{part!r:.60} is no part of it", remedy=remedy)
        return cls(MappingProxyType(features), MappingProxyType(behaviors), MappingProxyType(targets))

    def __add__(self, other: Kit) -> Kit:
        """Both kits' parts; a name that both have is refused."""
        return Kit.of(*self.parts, *other.parts)

    @property
    def parts(self) -> tuple[AnyFeature | Behavior | Target, ...]:
        """Everything in the kit: features, basic behaviors, targets."""
        return (*self.features.values(), *self.behaviors.values(), *self.targets.values())


def _add(parts: dict[str, Part], part: Part, sort: str) -> None:
    if part.name in parts:
        raise DefinitionError(
            what="kit", problem=f"two {sort} are called {part.name!r}", remedy="rename one of the two"
        )
    parts[part.name] = part
