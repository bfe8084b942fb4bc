"""What holds of every experiment, and how one is run: kept, cut off, gone on with, compared with what was published."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import msgspec
import pytest
from tests.docs import experiments as docs

from understudy.errors import UnknownName
from understudy_lab.results import NAME, RowCache, differences, list_uncompared, load_published, read, save
from understudy_lab.runner import run
from understudy_lab.servoing.trials import HAND
from understudy_lab.study import (
    QUESTIONS,
    Row,
    Study,
    StudyFindings,
    StudyPlan,
    Task,
    find_experiment,
    folder_of,
)


@pytest.mark.parametrize("name", QUESTIONS)
def test_every_experiment_is_whole(name: str) -> None:
    experiment, known = find_experiment(name), load_published(name)
    assert experiment.name == name
    assert known is not None
    assert known.question == QUESTIONS[name]
    assert known is not None
    assert not known.quick
    readme = (folder_of(name) / "README.md").read_text(encoding="utf-8")
    assert all(f"**{part}" in readme for part in ("Question", "Method", "Result"))
    quick = experiment.tasks(StudyPlan(experiment.seeds[: experiment.quick], quick=True))
    assert len({msgspec.json.encode(task, order="sorted") for task in quick}) == len(quick) > 0
    published_tasks = {msgspec.json.encode(row["task"], order="sorted") for row in known.rows}
    assert all(msgspec.json.encode(task, order="sorted") in published_tasks for task in quick)


@pytest.mark.parametrize("name", QUESTIONS)
def test_what_follows_from_the_published_rows_is_what_was_published(name: str) -> None:
    known = load_published(name)
    assert known is not None
    found = find_experiment(name).conclude(known.rows)
    assert msgspec.json.decode(msgspec.json.encode(found)) == msgspec.json.decode(
        msgspec.json.encode(known.findings)
    )


def test_the_page_says_what_was_published() -> None:
    assert docs.PAGE.read_text(encoding="utf-8") == docs.page()


def test_an_unknown_one_is_named() -> None:
    with pytest.raises(UnknownName, match="forage"):
        find_experiment("forrage")


# One of our own, to run and to cut off


def make_study(worked: list[Task], *, until: int = 99, value: float = 0.5) -> Study:
    """Squares of numbers, until it is cut off."""

    def work(task: Task) -> Row:
        if len(worked) == until:
            raise KeyboardInterrupt
        worked.append(task)
        return {"square": task["seed"] ** 2, "share": value, "absent": float("nan")}

    return Study(
        name="forage",
        seeds=range(4),
        quick=1,
        tasks=lambda plan: [{"seed": seed} for seed in plan.seeds],
        work=work,
        conclude=lambda rows: StudyFindings("Found."),
        draw=lambda rows: None,  # type: ignore[arg-type,return-value]
    )


PLAN = StudyPlan(range(4))


def test_tasks_in_real_time_run_one_after_the_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr("understudy.judging.process_pool.open_process_pool")
    worked: list[Task] = []
    timed = replace(make_study(worked), in_real_time=True)
    assert len(run(timed, PLAN, RowCache("forage", tmp_path), jobs=4)) == 4
    with pytest.raises(NameError):
        run(replace(timed, in_real_time=False), PLAN, RowCache("forage", tmp_path / "other"), jobs=4)


def test_a_run_that_is_cut_off_goes_on(tmp_path: Path) -> None:
    worked: list[Task] = []
    with pytest.raises(KeyboardInterrupt):
        run(make_study(worked, until=2), PLAN, RowCache("forage", tmp_path))
    with (tmp_path / NAME).open("ab") as file:
        file.write(b'{"task": {"seed": 2}, "squa')  # killed in the middle of a line
    rows = run(make_study(worked), PLAN, RowCache("forage", tmp_path))
    assert [task["seed"] for task in worked] == [0, 1, 2, 3]
    assert [row["square"] for row in rows] == [0, 1, 4, 9]
    assert rows == run(make_study([], until=0), PLAN, RowCache("forage", tmp_path))
    assert rows[0]["absent"] is None


def test_rows_of_another_version_are_put_aside(tmp_path: Path) -> None:
    (tmp_path / NAME).write_text(
        '{"experiment": "forage", "source": "old"}\n{"task": {"seed": 0}, "square": 7}\n'
    )
    kept = RowCache("forage", tmp_path)
    assert kept.put_aside
    assert len(kept) == 0
    assert "7" in (tmp_path / "rows.former.jsonl").read_text()


def test_what_differs_from_the_published_is_said() -> None:
    experiment = make_study([])
    rows = run(experiment, PLAN, RowCache("forage"))
    known = load_published("forage")
    assert known is not None
    known = replace(known, rows=rows)
    assert differences(rows, known, experiment) == []
    assert (
        differences(run(make_study([], value=0.5 + 1e-9), PLAN, RowCache("forage")), known, experiment) == []
    )
    other = run(make_study([], value=0.6), PLAN, RowCache("forage"))
    assert differences(other, known, experiment)[0] == "0: share is 0.6, published was 0.5"


def test_what_varies_is_compared_by_its_medians() -> None:
    known = load_published("forage")
    assert known is not None
    plan, new = StudyPlan(range(10)), StudyPlan(range(12))
    varying = replace(make_study([]), varies=("share",))
    known = replace(known, rows=run(varying, plan, RowCache("forage")))
    near, far = (run(make_study([], value=value), new, RowCache("forage")) for value in (0.65, 0.75))
    assert differences(near, known, varying) == []
    assert differences(far, known, varying) == ["all: median of share is 75%, published was 50%"]
    assert list_uncompared(far, known, varying) == ["2 pieces were not published, and not compared."]
    assert differences(far[:9], known, varying) == []
    assert "fewer than 10 seeds" in list_uncompared(far[:9], known, varying)[0]


def test_processes_side_by_side_find_the_same(tmp_path: Path) -> None:
    """Work that teaches nothing: the trials of the hand-written robot."""
    experiment, known = find_experiment("servoing"), load_published("servoing")
    assert known is not None
    by_hand = [{"method": HAND, "seed": seed} for seed in experiment.seeds[:3]]
    experiment = replace(experiment, tasks=lambda _: by_hand)
    rows = run(experiment, StudyPlan(experiment.seeds[:3]), RowCache("servoing", tmp_path), jobs=2)
    assert differences(rows, known, experiment) == []
    assert [row["task"] for row in rows] == by_hand


def test_a_result_reads_back_as_it_was(tmp_path: Path) -> None:
    known = load_published("forage")
    assert known is not None
    save(known, tmp_path / "result.json")
    assert read(tmp_path / "result.json") == known


def test_what_goes_wrong_in_another_process_is_said_as_it_is(tmp_path: Path) -> None:
    """As where an extra is missing, which is found out by whoever works."""
    experiment = replace(find_experiment("small"), tasks=lambda _: [{"behavior": "a"}, {"behavior": "b"}])
    kept = RowCache("small", tmp_path)
    with pytest.raises(KeyError):
        run(experiment, StudyPlan(range(2), quick=True), kept, jobs=2)
