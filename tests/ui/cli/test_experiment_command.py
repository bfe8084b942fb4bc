"""`understudy experiment`: listed, run, gone on with, compared with what was published."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from tests.ui.cli.commands import run

from understudy.errors import SettingError
from understudy_lab import study
from understudy_lab.figures import Panels
from understudy_lab.results import StudyResult, save
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, Task

TABLE = ResultTable("Squares", ("", "#square"), [("of [2]", "4")])


def squares(*, share: float = 1.0) -> Study:
    """An experiment that is quick."""

    def work(task: Task) -> Row:
        return {"square": task["seed"] ** 2, "share": share}

    def conclude(rows: list[Row]) -> StudyFindings:
        held = all(row["share"] >= 1.0 for row in rows)
        return StudyFindings(
            "Squares.", [TABLE], [StudyGoal("share", "1", f"{rows[0]['share']:g}", held)], ["A note."]
        )

    known = study.find_experiment("forage")
    return replace(
        known,
        seeds=range(4),
        tasks=lambda plan: [{"seed": seed} for seed in plan.seeds],
        work=work,
        conclude=conclude,  # type: ignore[arg-type]
        draw=Panels([lambda axes, rows: None]),
        worlds=(),
        needs={"no_such_module": "pip install 'understudy-robots[none]'"},
    )


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Squares, published with a share of 1, in the place of the experiment on foraging."""
    monkeypatch.chdir(tmp_path)
    use(squares(), monkeypatch)
    monkeypatch.setattr("understudy_lab.results.folder_of", lambda name: tmp_path)
    rows = [{"task": {"seed": seed}, "square": seed**2, "share": 1.0} for seed in range(4)]
    findings = squares().conclude(rows)
    save(StudyResult("forage", "?", [0, 1, 2, 3], False, findings, rows), tmp_path / "expected.json")
    return tmp_path


def use(experiment: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("understudy_lab.commands.experiment.find_experiment", lambda name: experiment)


def test_all_are_listed() -> None:
    told = json.loads(run("experiment", "list", "--json").stdout)["experiments"]
    assert [each["name"] for each in told] == list(study.QUESTIONS)


def test_as_published(here: Path) -> None:
    done = run("experiment", "forage", "--jobs", "1")
    assert done.exit_code == 0, done.output
    assert "'understudy-robots[none]'" in done.output
    assert "of [2]" in done.output
    assert {path.name for path in (here / "results" / "forage").iterdir()} == {
        "result.json", "figure.svg", "rows.jsonl",
    }  # fmt: skip


def test_what_was_done_is_not_done_again(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run("experiment", "forage", "--jobs", "1", "--quick")

    def work(task: Task) -> Row:
        raise AssertionError(task)

    use(replace(squares(), work=work), monkeypatch)
    done = run("experiment", "forage", "--jobs", "1", "--quick")
    assert done.exit_code == 0, done.output
    assert "Going on: 1 pieces" in done.output


def test_a_miss_is_named(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    use(squares(share=0.5), monkeypatch)
    done = run("experiment", "forage", "--jobs", "1")
    assert done.exit_code == 1
    assert "share: 0.5, not 1" in done.output
    assert "share is 0.5, published was 1.0" in done.output


def test_for_programs(here: Path) -> None:
    done = run("experiment", "forage", "--jobs", "1", "--json", "--seeds", "1:3")
    told = json.loads(done.stdout)
    assert told["passed"]
    assert [row["square"] for row in told["result"]["rows"]] == [1, 4]


def test_one_that_cannot_run_here_is_refused_and_left_out_of_all(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def check_machine() -> None:
        raise SettingError(where="experiment", setting="this machine", problem="has no legs", remedy="walk")

    use(replace(squares(), check_machine=check_machine), monkeypatch)
    monkeypatch.setattr("understudy_lab.commands.experiment.QUESTIONS", {"forage": "?"})
    done = run("experiment", "forage", "--quick")
    assert (done.exit_code, "has no legs" in done.output) == (2, True)
    done = run("experiment", "all", "--quick")
    assert (done.exit_code, "Skipped: " in done.output) == (0, True), done.output


def test_what_was_not_published_is_counted(here: Path) -> None:
    done = run("experiment", "forage", "--jobs", "1", "--seeds", "2:7")
    assert done.exit_code == 0, done.output
    assert "3 pieces were not published, and not compared" in done.output


def test_an_unknown_name() -> None:
    done = run("experiment", "forrage")
    assert done.exit_code == 2
    assert "forage" in done.output
