"""`understudy test --failures`: failing worlds are run again beside lessons and properties."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.falsification.kept import keep
from tests.falsification.planted import FORAGE, TOO_FAR, plant_idleness
from tests.falsification.test_failing_world import list_failing_seeds
from tests.ui.cli.commands import run, run_json

from understudy.addons.checks.falsification.failing_world import FACTS_FILE, read_failing_world
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.model.library import TrainedAutomaton
from understudy.storage.library_folder import save_automaton


def test_they_fail_until_the_library_is_corrected(library: Path, tmp_path: Path) -> None:
    for number, seed in enumerate(list_failing_seeds()[:2], 1):
        keep(Trial(FORAGE, seed), tmp_path / "failures" / f"forage-{number}")
    good = run_json("test", library, "--failures", tmp_path / "failures")
    assert good["works"]
    assert [each["verdict"] for each in good["failures"]] == ["passes", "passes"]
    assert all(each["robustness"] > 0 for each in good["failures"])
    save_automaton(library, TrainedAutomaton(plant_idleness(TOO_FAR)))
    result = run("test", library, "--failures", tmp_path / "failures", "--json")
    assert result.exit_code == 1
    rows = json.loads(result.stdout)["failures"]
    assert {(each["name"], each["behavior"], each["verdict"]) for each in rows} == {
        ("forage-1", "forage", "fails"),
        ("forage-2", "forage", "fails"),
    }
    assert all("no more progress" in each["why"] or "never any progress" in each["why"] for each in rows)
    text = run("test", library, "--failures", tmp_path / "failures")
    assert text.exit_code == 1
    assert "2 failing worlds: 0 now pass" in text.stdout
    assert run_json("test", library)["failures"] == []  # the option asks for it


def test_what_cannot_be_read_or_run(library: Path, tmp_path: Path) -> None:
    missing = run("test", library, "--failures", tmp_path / "none")
    assert missing.exit_code == 2
    assert "is not a folder" in missing.stderr
    keep(Trial(FORAGE, list_failing_seeds()[0]), tmp_path / "failures" / "forage-1")
    facts = tmp_path / "failures" / "forage-1" / FACTS_FILE
    facts.write_text(facts.read_text().replace('"behavior": "forage"', '"behavior": "soccer"'))
    broken = tmp_path / "failures" / "forage-2"
    broken.mkdir()
    (broken / FACTS_FILE).write_text("{")
    result = run("test", library, "--failures", tmp_path / "failures", "--json")
    assert result.exit_code == 1
    (row,) = json.loads(result.stdout)["failures"]
    assert (row["verdict"], row["robustness"]) == ("unknown", None)
    assert "soccer" in row["why"]
    assert "Note: a failing world is left out" in result.stderr


def test_a_world_that_failed_a_property_is_run_again_by_it(library: Path, tmp_path: Path) -> None:
    (library / "properties.toml").write_text(
        'understudy = "properties"\nversion = 1\n[light]\nbehavior = "forage"\nworld = "forage"\nseeds = 1\n'
        'never = "food_stored is at least 5 units"\n'
    )
    out = tmp_path / "failures"
    kept = run("falsify", library, "forage", "--property", "light", "--worlds", 3, "--seconds", 1, "-o", out)
    assert kept.exit_code == 1, kept.output
    found = read_failing_world(out / "forage-1")
    assert found.facts.property == "light"
    assert found.facts.place is not None
    assert found.facts.states
    (row,) = json.loads(run("test", library, "--failures", out, "--json").stdout)["failures"]
    assert (row["verdict"], row["robustness"]) == ("fails", found.facts.robustness)


@pytest.mark.long
def test_results_do_not_depend_on_the_number_of_processes(library: Path, tmp_path: Path) -> None:
    """Lessons, properties of both kinds and failing worlds, one by one or two at a time."""
    for number, seed in enumerate(list_failing_seeds()[:2], 1):
        keep(Trial(FORAGE, seed), tmp_path / "failures" / f"forage-{number}")
    save_automaton(library, TrainedAutomaton(plant_idleness(TOO_FAR)))
    (library / "properties.toml").write_text(
        'understudy = "properties"\nversion = 1\n[hurries]\nbehavior = "forage"\nworld = "forage"\nseeds = 5\n'
        'always = "goal"\nwithin_s = 30\n[mostly]\nbehavior = "forage"\nworld = "forage"\nseeds = 120\n'
        'always = "goal"\nwithin_s = 600\nat_least = 0.5\n'
    )
    one, two = (
        run("test", library, "--failures", tmp_path / "failures", "--json", "--jobs", jobs)
        for jobs in ("1", "2")
    )
    assert (one.exit_code, two.exit_code) == (1, 1), two.output
    assert one.stdout == two.stdout
    found = json.loads(two.stdout)
    assert len(found["automata"]) == 4
    assert [each["verdict"] for each in found["properties"]] == ["fails", "holds"]
    assert [each["verdict"] for each in found["failures"]] == ["fails", "fails"]
