"""`understudy learn drive` takes pairs of readings, says so, and keeps them in the library."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.segmentation.drives import follow
from tests.segmentation.test_propose_pairs import RULES, draw_readings
from tests.ui.cli.commands import run, run_json

from understudy.learning.fit import learn_automaton
from understudy.model.lesson import Example, ExampleKind
from understudy.model.library import Library, TrainedAutomaton
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.storage.library_folder import save_automaton
from understudy.training.lesson_design import new_lesson

MAP = """
format = "understudy-recording-map/1"
time = "time_s"
tick_s = 0.1
readings = [{column = "gap", unit = "m"}, {column = "speed", unit = "m/s"}]
commands = [{column = "command.drive", channel = "drive"}]
[behaviors.forward]
drive = 0.8
[behaviors.back]
drive = -0.4
"""


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Drives of a driver who goes back where the gap is closed in two seconds, and the mapping file."""
    folder = tmp_path_factory.mktemp("drives")
    (folder / "map.toml").write_text(MAP)
    paths = []
    for number in range(6):
        readings = draw_readings(number)
        back = RULES["time"](readings)
        commands = follow([(-0.4 if each else 0.8,) for each in back], gain=1.0, seed=number)[:, 0]
        columns = (np.arange(len(back)) / 10, readings["gap", None], readings["speed", None], commands)
        rows = (",".join(f"{value:.5f}" for value in row) for row in zip(*columns, strict=True))
        paths.append(folder / f"{number}.csv")
        paths[-1].write_text("\n".join(["time_s,gap,speed,command.drive", *rows]) + "\n")
    return paths


def learn(drives: list[Path], *more: str | Path) -> tuple[str | Path, ...]:
    return ("learn", "drive", *drives, "--map", drives[0].with_name("map.toml"), *more)


def test_a_pair_is_taken_and_said(drives: list[Path]) -> None:
    found = run_json(*learn(drives))
    (taken,) = found["pairs"]["taken"]
    assert (taken["pairs"], taken["instead_of"]) == (["gap / speed"], ["gap", "speed"])
    assert (
        taken["repeated_before"] < taken["repeated"] == found["pairs"]["repeated"] <= found["pairs"]["ticks"]
    )
    assert found["pairs"]["left_out"] == "drives"
    assert any("gap / speed" in line for line in found["states"]["forward"]["conditions"])
    shown = run(*learn(drives)).stdout
    assert "Of 1 pair of readings with fitting units, 1 was tried." in shown
    assert "gap / speed is a feature instead of gap and speed: with that, " in shown
    assert "Without them: --no-pairs" in shown
    assert "back when gap / speed is " in shown


def test_pairs_are_left_out_on_demand(drives: list[Path]) -> None:
    found = run_json(*learn(drives, "--no-pairs"))
    assert "pairs" not in found
    assert "gap / speed" not in json.dumps(found["states"])
    assert "pair" not in run(*learn(drives, "--no-pairs")).stdout


def test_a_pair_is_a_feature_by_its_name(drives: list[Path]) -> None:
    found = run_json(*learn(drives, "--features", "gap / speed", "--no-pairs"))
    assert any("gap / speed" in line for line in found["states"]["forward"]["conditions"])
    wrong = run(*learn(drives, "--features", "gap - speed"))
    assert wrong.exit_code == 2
    assert "gap is in m, and speed in m/s" in " ".join(wrong.stderr.split())


def test_a_pair_is_kept_in_the_library(drives: list[Path], tmp_path: Path) -> None:
    library = tmp_path / "library"
    assert run(*learn(drives, "--library", library, "--name", "driven")).exit_code == 0
    document = json.loads((library / "driven.json").read_text())
    (feature,) = document["automaton"]["features"]
    assert (feature["name"], feature["unit"], feature["pair"]["term"]) == ("gap / speed", "s", "quotient")
    assert "gap / speed" in run("show", "driven", "--library", library).stdout


def test_why_reads_a_pair(tmp_path: Path) -> None:
    """In a world of which the kit has both readings."""
    library = Library(make_scenario_kit(find_scenario("forage")))
    nearer = "distance_to(nearest_food) - distance_to(station)"
    lesson = new_lesson(library, "go", states=["forward"], features=[nearer])
    examples = (
        Example(1, "start", (1.0,), "forward", ExampleKind.DIRECTIVE),
        Example(2, "start", (-1.0,), "start", ExampleKind.CONFIRMATION),
        Example(3, "forward", (-1.0,), "start", ExampleKind.DIRECTIVE),
        Example(4, "forward", (1.0,), "forward", ExampleKind.CONFIRMATION),
    )
    lesson = replace(lesson, examples=examples)
    save_automaton(tmp_path / "library", TrainedAutomaton(learn_automaton(lesson), lesson))
    trace = tmp_path / "run.jsonl"
    ran = run(
        "run",
        "forage",
        "--behavior",
        "go",
        "--library",
        tmp_path / "library",
        "--seconds",
        2,
        "--trace",
        trace,
    )
    assert ran.exit_code == 0, ran.stderr
    said = " ".join(run("why", trace, "--time", 1).stdout.split())
    assert f"because {nearer} is below 0 m" in said
    assert f"it read {nearer} = −" in said
