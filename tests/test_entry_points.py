"""Scenarios, kits and experiments of other packages, by entry points, and of the user's own modules, by place."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.ui.cli.commands import run, run_json

from understudy import evaluate
from understudy.entry_points import KITS, STUDIES, WORLDS, list_entry_points
from understudy.errors import SettingError
from understudy.sim.catalog import find_scenario, list_scenarios, locate_scenario
from understudy.ui.cli.named_inputs import find_kit
from understudy_lab.study import find_experiment, list_questions

MODULE = """
from dataclasses import replace

from understudy import Behavior, Command, Kit
from understudy.sim.catalog import find_scenario
from understudy_lab.study import Study, StudyFindings


def make_meadow():
    import msgspec

    return msgspec.structs.replace(find_scenario("forage"), name="meadow")


def make_nothing():
    return 7


def fail():
    raise RuntimeError("no meadow today")


kit = Kit.from_parts(Behavior("creep", Command(drive=0.1)))
study = Study(
    "grazing",
    range(2),
    1,
    tasks=lambda plan: [{"seed": seed} for seed in plan.seeds],
    work=lambda task: {**task, "grass": 3},
    conclude=lambda rows: StudyFindings("grass"),
    draw=lambda rows: None,
    question="How much grass is left?",
)
"""
ENTRIES = f"""[{WORLDS}]
meadow = mylab_of_tests:make_meadow
swamp = mylab_of_tests:fail

[{KITS}]
mylab = mylab_of_tests:kit

[{STUDIES}]
grazing = mylab_of_tests:study
meadow = mylab_of_tests:kit
"""


@pytest.fixture
def site_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Install a package, as pip does: a module, and the list of its entry points."""
    (tmp_path / "mylab_of_tests.py").write_text(MODULE)
    about = tmp_path / "mylab_of_tests-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: mylab-of-tests\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(ENTRIES)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", ["meadow", "mylab_of_tests:make_meadow"])
def test_a_scenario_of_another_package(site_folder: Path, name: str) -> None:
    assert find_scenario(name).name == "meadow"
    assert locate_scenario(name) == name


def test_it_is_listed_and_shown(site_folder: Path) -> None:
    assert "meadow" in list_scenarios()
    assert "meadow" in [row["name"] for row in run_json("worlds")["worlds"]]
    assert "'swamp' raised RuntimeError: no meadow today" in " ".join(run("worlds").stderr.split())
    (site_folder / "meadow.toml").write_text(run("worlds", "meadow").stdout)
    assert find_scenario(site_folder / "meadow.toml") == find_scenario("meadow")


def test_a_module_of_the_working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "ownlab_of_tests.py").write_text(MODULE)
    monkeypatch.chdir(tmp_path)
    assert find_scenario("ownlab_of_tests:make_meadow").name == "meadow"


def test_it_is_evaluated_as_the_scenario_that_it_is_like(site_folder: Path) -> None:
    from understudy import Library
    from understudy.sim.forage import FORAGE_KIT

    library = Library(FORAGE_KIT)
    one, other = (
        evaluate(library, "forward", world, range(4), goal="at_station", limit_s=5.0, binding={})
        for world in ("forage", "meadow")
    )
    assert (one.world, other.world) == ("forage", "meadow")
    assert one.success == other.success


def test_a_kit_by_its_entry_point(site_folder: Path) -> None:
    assert list(find_kit("mylab", "forage").behaviors) == ["creep"]
    assert find_kit("mylab_of_tests:kit", "forage") is find_kit("mylab", "forage")


def test_an_experiment_of_another_package(site_folder: Path) -> None:
    assert list_entry_points(STUDIES) == ["grazing", "meadow"]
    assert find_experiment("grazing").work({"seed": 1}) == {"seed": 1, "grass": 3}
    with pytest.raises(SettingError, match="'meadow' is a Kit; let the entry point name a Study"):
        find_experiment("meadow")
    assert list_questions()["grazing"] == "How much grass is left?"
    assert "'meadow' is a Kit" in list_questions()["meadow"]


MISTAKES = [
    ("mylab_of_tests:make_nothing", "returned a int; name a function"),
    ("mylab_of_tests:fail", "raised RuntimeError: no meadow today; name a function"),
    ("mylab_of_tests:nothing", "cannot be imported: AttributeError"),
    ("no_such_module:make", "cannot be imported: ModuleNotFoundError"),
]


@pytest.mark.parametrize(("name", "says"), MISTAKES)
def test_what_is_no_scenario_is_one_sentence(site_folder: Path, name: str, says: str) -> None:
    result = run("eval", "--world", name, "--library", site_folder)
    assert result.exit_code == 2
    assert says in " ".join(result.stderr.split())
    assert "Traceback" not in result.stderr
