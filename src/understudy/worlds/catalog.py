"""The worlds that ship, by name: a plain mapping."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from understudy.errors import UnknownName
from understudy.model.kit import Kit
from understudy.runtime.body import every_key
from understudy.worlds.forage import Forage
from understudy.worlds.forage import kit as forage_kit


@dataclass(frozen=True)
class CatalogWorld:
    """A world by name: what it is, the parts that go with it, and what makes a row per seed."""

    name: str
    doc: str
    kit: Kit
    make: Callable[[Sequence[int]], Forage]


CATALOG: Mapping[str, CatalogWorld] = MappingProxyType(
    {
        "forage": CatalogWorld(
            "forage", "Bring food from sources that deplete to the station.", forage_kit, Forage
        )
    }
)


def prepare(world: CatalogWorld) -> None:
    """Have the world's kernels compiled or loaded, so that no later call waits (seconds, once per installation)."""
    body = world.make([0])
    body.sense(every_key(body))
    body.act({channel.name: np.ones(1) for channel in body.channels})


def find_world(name: str) -> CatalogWorld:
    """The world of this name; UnknownName where there is none."""
    if name not in CATALOG:
        raise UnknownName(what="world", name=name, where="Understudy", known=list(CATALOG))
    return CATALOG[name]
