"""Everything that ships in the catalog keeps the laws, its kit too."""

from __future__ import annotations

import pytest

from understudy.model.behavior import Behavior
from understudy.model.feature import AnyFeature
from understudy.testing import check_behavior, check_feature, check_world
from understudy.worlds.catalog import CATALOG

FEATURES = [(name, part) for name, world in CATALOG.items() for part in world.kit.features.values()]
BEHAVIORS = [(name, part) for name, world in CATALOG.items() for part in world.kit.behaviors.values()]


@pytest.mark.parametrize("name", CATALOG)
def test_world(name: str) -> None:
    check_world(CATALOG[name].make)
    assert CATALOG[name].name == name
    assert CATALOG[name].doc


@pytest.mark.parametrize(("name", "feature"), FEATURES)
def test_feature(name: str, feature: AnyFeature) -> None:
    check_feature(feature, CATALOG[name].make([1, 2, 3]))


@pytest.mark.parametrize(("name", "behavior"), BEHAVIORS)
def test_behavior(name: str, behavior: Behavior) -> None:
    check_behavior(behavior, CATALOG[name].make([1, 2, 3]))
    assert behavior.doc
