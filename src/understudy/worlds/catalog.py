"""The worlds that ship, by name: a plain mapping."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

from understudy.model.kit import Kit
from understudy.worlds.forage import Forage
from understudy.worlds.forage import kit as forage_kit


class MakesWorlds(Protocol):
    """What makes worlds side by side, one per seed."""

    def __call__(self, seeds: list[int] | range, /) -> Forage:
        """A body of as many rows as there are seeds, or more."""
        ...


@dataclass(frozen=True)
class CatalogWorld:
    """A world by name: what it is, the parts that go with it, and what makes it."""

    name: str
    doc: str
    kit: Kit
    make: MakesWorlds


CATALOG: Mapping[str, CatalogWorld] = MappingProxyType(
    {
        "forage": CatalogWorld(
            "forage", "Bring food from sources that deplete to the station.", forage_kit, Forage
        )
    }
)
