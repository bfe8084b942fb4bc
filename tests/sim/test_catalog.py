"""Everything that ships keeps the laws: the built-in scenarios, and their kits; and worlds are found by name."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from understudy.errors import FileError, UnknownName
from understudy.model.behaviors import Behavior
from understudy.model.features import AnyFeature
from understudy.sim import catalog
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import list_builtin_scenarios, read_scenario_text
from understudy.sim.world import World
from understudy.testing import check_behavior, check_feature, check_world

NAMES = list_builtin_scenarios()
KITS = {name: make_scenario_kit(find_scenario(name)) for name in NAMES}
FEATURES = [(name, part) for name, kit in KITS.items() for part in kit.features.values()]
BEHAVIORS = [(name, part) for name, kit in KITS.items() for part in kit.behaviors.values()]


def world(name: str, seeds: Sequence[int] = (1, 2, 3)) -> World:
    return World(find_scenario(name), seeds)


@pytest.mark.parametrize("name", NAMES)
def test_world(name: str) -> None:
    check_world(lambda seeds: world(name, seeds))
    assert find_scenario(name).name == name
    assert find_scenario(name).about


@pytest.mark.parametrize(("name", "feature"), FEATURES)
def test_feature(name: str, feature: AnyFeature) -> None:
    check_feature(feature, world(name))


@pytest.mark.parametrize(("name", "behavior"), BEHAVIORS)
def test_behavior(name: str, behavior: Behavior) -> None:
    check_behavior(behavior, world(name))
    assert behavior.doc


def test_a_world_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(read_scenario_text("patrol").replace("limit_s = 600", "limit_s = 60"))
    assert find_scenario("mine.toml").limit_s == find_scenario(Path("mine.toml")).limit_s == 60
    Path("bad.toml").write_text("x = 1")
    with pytest.raises(FileError, match=r"bad\.toml at understudy: is missing"):
        find_scenario("bad.toml")


@pytest.mark.parametrize("name", ["none.toml", "no/where", Path("moon")])
def test_a_file_that_is_not_there(name: str | Path) -> None:
    with pytest.raises(FileError, match="there is no such file"):
        find_scenario(name)


def test_a_name_that_is_none() -> None:
    with pytest.raises(UnknownName, match="no world 'moon'; it has arena, boxes, forage"):
        find_scenario("moon")


def test_a_builtin_scenario_is_found_without_other_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    """All installed packages would have to be searched for what they offer."""

    def refuse(group: str) -> list[str]:
        raise AssertionError(group)

    monkeypatch.setattr(catalog, "list_entry_points", refuse)
    assert find_scenario("forage").name == "forage"
    with pytest.raises(AssertionError, match=r"understudy\.worlds"):
        find_scenario("orchard")
