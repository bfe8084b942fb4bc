"""Scenarios, kits and experiments of other packages, by entry points, and of the user's own modules, by place."""

from __future__ import annotations

from pathlib import Path
from shutil import copy

import pytest
from tests.make.packages import PLUGIN, install_entry_points, install_project
from tests.ui.cli.commands import run, run_json

from understudy import Library, evaluate
from understudy.entry_points import STUDIES, list_entry_points
from understudy.errors import SettingError
from understudy.sim.catalog import find_scenario, list_scenarios, locate_scenario
from understudy.ui.cli.named_inputs import find_kit
from understudy_lab.study import find_experiment, list_questions

MODULE = """
def make_nothing():
    return 7


def fail():
    raise RuntimeError("no apples today")
"""


@pytest.fixture
def site_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Install the package of the fixtures, and one whose world and study cannot be used."""
    install_project(PLUGIN, tmp_path, monkeypatch)
    (tmp_path / "mistakes_of_tests.py").write_text(MODULE)
    groups = {
        "understudy.worlds": {"swamp": "mistakes_of_tests:fail"},
        STUDIES: {"orchard": "orchard.kit:kit"},
    }
    install_entry_points("mistakes", groups, tmp_path, monkeypatch)
    return tmp_path


@pytest.mark.parametrize("name", ["orchard", "orchard.world:make_orchard"])
def test_a_scenario_of_another_package(site_folder: Path, name: str) -> None:
    assert find_scenario(name).name == "orchard"
    assert locate_scenario(name) == name


def test_it_is_listed_and_shown(site_folder: Path) -> None:
    assert "orchard" in list_scenarios()
    assert "orchard" in [row["name"] for row in run_json("worlds")["worlds"]]
    assert "'swamp' raised RuntimeError: no apples today" in " ".join(run("worlds").stderr.split())
    (site_folder / "copy.toml").write_text(run("worlds", "orchard").stdout)
    assert find_scenario(site_folder / "copy.toml") == find_scenario("orchard")


def test_a_module_of_the_working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    copy(PLUGIN / "orchard" / "world.py", tmp_path / "ownlab_of_tests.py")
    copy(PLUGIN / "orchard" / "orchard.toml", tmp_path)
    monkeypatch.chdir(tmp_path)
    assert find_scenario("ownlab_of_tests:make_orchard").name == "orchard"


def test_it_is_evaluated_as_its_file_is(site_folder: Path) -> None:
    library = Library(find_kit("orchard", "forage"))
    one, other = (
        evaluate(library, "creep", world, range(4), limit_s=5.0)
        for world in (PLUGIN / "orchard" / "orchard.toml", "orchard")
    )
    assert (one.world, other.world) == ("orchard", "orchard")
    assert one.success == other.success


def test_a_kit_by_its_entry_point(site_folder: Path) -> None:
    assert list(find_kit("orchard", "forage").behaviors) == ["creep"]
    assert find_kit("orchard.kit:kit", "forage") is find_kit("orchard", "forage")


def test_an_experiment_of_another_package(site_folder: Path) -> None:
    assert sorted(list_entry_points(STUDIES)) == ["grazing", "orchard"]
    assert find_experiment("grazing").work({"seed": 1}) == {"grass_kg": 4.0}
    with pytest.raises(SettingError, match="'orchard' is a Kit; let the entry point name a Study"):
        find_experiment("orchard")
    assert list_questions()["grazing"] == "How much grass is left?"
    assert "'orchard' is a Kit" in list_questions()["orchard"]


MISTAKES = [
    ("mistakes_of_tests:make_nothing", "returned a int; name a function"),
    ("mistakes_of_tests:fail", "raised RuntimeError: no apples today; name a function"),
    ("mistakes_of_tests:nothing", "cannot be imported: AttributeError"),
    ("no_such_module:make", "cannot be imported: ModuleNotFoundError"),
]


@pytest.mark.parametrize(("name", "says"), MISTAKES)
def test_what_is_no_scenario_is_one_sentence(site_folder: Path, name: str, says: str) -> None:
    result = run("eval", "--world", name, "--library", site_folder)
    assert result.exit_code == 2
    assert says in " ".join(result.stderr.split())
    assert "Traceback" not in result.stderr
