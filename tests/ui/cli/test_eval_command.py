"""What eval measures, compares and prints for papers."""

from __future__ import annotations

import csv
import json
from io import StringIO
from pathlib import Path

import pytest
from tests.ui.cli.commands import run, run_json
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.model.library import TrainedAutomaton
from understudy.storage.library_folder import save_automaton

GOTO = ("--behavior", "goto", "--bind", "A=station", "--seeds", "0:8")


@pytest.fixture
def other(tmp_path: Path) -> Path:
    """A second library with the same automata."""
    for automaton in AUTOMATA:
        save_automaton(tmp_path / "other_1", TrainedAutomaton(automaton))
    return tmp_path / "other_1"


def test_goals_and_metrics_by_name(library: Path) -> None:
    plain = run_json("eval", "-l", library, *GOTO)
    told = run_json("eval", "-l", library, *GOTO, "--goal", "at_station", "--metric", "distance_to(A)")
    assert (plain["goal"], told["goal"], told["success"]) == (None, "at_station", 1.0)
    assert told["median_s"] < plain["median_s"]
    assert told["success_interval"] == pytest.approx([0.025 ** (1 / 8), 1.0])
    metric = told["metrics"]["distance_to(A)"]
    assert metric["low"] < metric["median"] < metric["high"]
    assert metric["count"] == 8
    text = run("eval", "-l", library, *GOTO, "--goal", "at_station", "--metric", "distance_to(A)").stdout
    assert "at_station in time  100%" in text
    assert f"distance_to(A)      {metric['median']:.2f} (median; 95 % interval [" in text


def test_json_is_a_format(library: Path) -> None:
    """--json is the old spelling of it; errors are printed as JSON, too."""
    options = ("-l", library, *GOTO, "--limit", "5")
    old, new = run_json("eval", *options), json.loads(run("eval", *options, "--format", "json").stdout)
    assert {**old, "seconds": 0} == {**new, "seconds": 0}
    assert run("eval", *options, "--format", "json", "--json").exit_code == 0
    assert "--json" not in run("eval", "--help").stdout


@pytest.mark.parametrize("words", [("--format", "json"), ("--format=json",), ("--json",)])
def test_an_error_in_any_spelling_of_json(
    words: tuple[str, ...], library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = run("eval", "-l", library, "--behavior", "nothing", *words, monkeypatch=monkeypatch)
    assert json.loads(result.stdout)["error"]["type"] == "UnknownName"


def test_a_time_limit(library: Path) -> None:
    told = run_json("eval", "-l", library, *GOTO, "--limit", "5", "--each", "--metric", "distance_to(A)")
    assert 0 < told["success"] < 1
    for row in told["results"]:
        assert row["success"] == (row["seconds"] is not None)
        assert row["success"] == (row["metrics"]["distance_to(A)"] < 0.5)


@pytest.mark.long
def test_processes_find_the_same(library: Path) -> None:
    one, two = (
        run_json("eval", "-l", library, *GOTO, "--jobs", jobs, "--each", "--metric", "distance_to(A)")
        for jobs in ("1", "2")
    )
    assert one["results"] == two["results"]


def test_two_libraries_are_compared_pair_by_pair(library: Path, other: Path) -> None:
    told = run_json("eval", "-l", library, *GOTO, "--against", other)["comparison"]
    assert told["against"] == str(other)
    assert (told["success"]["difference"], told["success"]["p"]) == (0.0, 1.0)
    assert told["metrics"]["seconds"]["test"]["equal"] == 8
    text = run("eval", "-l", library, *GOTO, "--against", other).stdout
    assert "success             100 % and 100 %, difference 0 % [" in text


def test_two_behaviors_are_compared_pair_by_pair(library: Path) -> None:
    arguments = (
        "-l",
        library,
        *GOTO,
        "--goal",
        "at_station",
        "--metric",
        "distance_to(station)",
        "--limit",
        60,
    )
    told = run_json("eval", *arguments, "--against-behavior", "rotate_left")["comparison"]
    assert told["success"]["only_first"] == 8
    assert told["success"]["p"] == 2 / 2**8
    assert told["metrics"]["distance_to(station)"]["test"]["rank_biserial"] == 1.0
    text = run("eval", *arguments, "--against-behavior", "rotate_left").stdout
    assert "goto and rotate_left in the same worlds" in text
    assert "time to finish (s)  in no world do both have it" in text


def test_tables_for_papers(library: Path, other: Path) -> None:
    arguments = ("eval", "-l", library, *GOTO, "--metric", "distance_to(A)")
    markdown = run(*arguments, "--format", "markdown").stdout
    assert markdown.startswith("| measure | value | 95 % interval | worlds |\n| --- | ---: | ---: | ---: |\n")
    assert "| success | 100 % | [63.1 %, 100 %] | 8 |\n" in markdown
    anywhere = "(done counts wherever it is raised: nothing shown says where it is right)"
    assert f"goto in 8 worlds of forage; success is done in time {anywhere}." in " ".join(markdown.split())
    latex = run(*arguments, "--against", other, "--format", "latex").stdout
    assert latex.isascii()
    assert r"& " + str(other).replace("_", r"\_") + " & difference" in latex
    rows = list(csv.DictReader(StringIO(run(*arguments, "--format", "csv", "--each").stdout)))
    assert [row["seed"] for row in rows] == [str(seed) for seed in range(8)]
    assert all(float(row["distance_to(A)"]) < 0.5 for row in rows)


def test_absent_values_are_notes(library: Path) -> None:
    result = run("eval", "-l", library, *GOTO, "--metric", "distance_to(nearest_marker)", "--format", "csv")
    assert result.exit_code == 0
    notes = result.stderr.splitlines()
    assert notes[0] == ("Note: in the world of seed 0, metric 'distance_to(nearest_marker)' is absent (NaN).")
    assert (len(notes), notes[-1]) == (4, "Note: 8 values are absent in all.")
    assert result.stdout.endswith("distance_to(nearest_marker),,,,0\n")
