"""Parts of an experiment: their rows, gathered, are those of one run, byte for byte; kills lose nothing."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import msgspec
import pytest
from tests.lab.test_study import PLAN, make_study
from tests.processes import end_with_tests
from tests.ui.cli.commands import run as run_command

from understudy.errors import SettingError
from understudy_lab.results import NAME, RowCache, differences, load_published
from understudy_lab.runner import JobFailed, Part, PartJob, PartsUnfinished, gather, run, run_on_cluster
from understudy_lab.study import StudyPlan, find_experiment


@pytest.mark.parametrize(
    ("text", "expected"), [("1/3", Part(1, 3)), ("3/3", Part(3, 3)), ("1/1", Part(1, 1))]
)
def test_a_part_is_read(text: str, expected: Part) -> None:
    assert Part.parse(text) == expected
    assert str(expected) == text


@pytest.mark.parametrize("text", ["4/3", "0/3", "1/0", "1", "a/b", "-1/3", "1/3/5", ""])
def test_what_is_no_part_is_refused(text: str) -> None:
    with pytest.raises(SettingError, match="such as 1/3"):
        Part.parse(text)


def test_every_task_is_in_one_part() -> None:
    tasks = [{"seed": seed} for seed in range(10)]
    parts = [Part(number, 3).select(tasks) for number in (1, 2, 3)]
    assert [len(part) for part in parts] == [4, 3, 3]
    assert sorted(task["seed"] for part in parts for task in part) == list(range(10))


def test_gathered_rows_are_those_of_one_run(tmp_path: Path) -> None:
    experiment = make_study([])
    run(experiment, PLAN, RowCache("forage", tmp_path / "whole"))
    for number in (2, 1, 3):
        part = Part(number, 3)
        run(experiment, PLAN, RowCache("forage", tmp_path / "parts", part.file_name), part=part)
    gather(experiment, PLAN, tmp_path / "parts")
    assert (tmp_path / "parts" / NAME).read_bytes() == (tmp_path / "whole" / NAME).read_bytes()


def test_gathering_names_the_parts_that_have_not_ended(tmp_path: Path) -> None:
    experiment = make_study([])
    with pytest.raises(PartsUnfinished, match="has no part"):
        gather(experiment, PLAN, tmp_path)
    for number in (1, 3):
        part = Part(number, 3)
        run(experiment, PLAN, RowCache("forage", tmp_path, part.file_name), part=part)
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(PartsUnfinished, match="run --part 2/3 again"):
        gather(experiment, PLAN, tmp_path)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


NAME_OF_REAL = "servoing"
SEEDS = find_experiment(NAME_OF_REAL).seeds[:1]
REAL = StudyPlan(SEEDS)


KILLED = """
import os, signal
from understudy.ui.cli import run_command_line
from understudy_lab.results import RowCache
keep = RowCache.keep

def keep_and_die(cache, row):
    keep(cache, row)
    os.kill(os.getpid(), signal.SIGKILL)

RowCache.keep = keep_and_die
run_command_line()
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kills with SIGKILL")
@pytest.mark.long
def test_a_part_that_is_killed_goes_on_and_gives_what_was_published(tmp_path: Path) -> None:
    asked = ["experiment", NAME_OF_REAL, "--out", str(tmp_path)]
    asked += ["--seeds", f"{SEEDS.start}:{SEEDS.stop}", "--jobs", "1"]
    file = tmp_path / Part(1, 2).file_name
    words = end_with_tests([sys.executable, "-c", KILLED, *asked, "--part", "1/2"])
    job = subprocess.run(words, check=False, capture_output=True)
    assert job.returncode == -signal.SIGKILL, job.stderr
    left = file.read_bytes()
    assert left.count(b"\n") == 2, "its head, and one row"
    for number in (1, 2):
        assert run_command(*asked, "--part", f"{number}/2").exit_code == 0
    assert file.read_bytes().startswith(left[: left.rindex(b"\n")])  # nothing was computed again
    found = run_command(*asked, "--gather", "--json")
    experiment, known = find_experiment(NAME_OF_REAL), load_published(NAME_OF_REAL)
    assert known is not None
    assert differences(msgspec.json.decode(found.stdout)["result"]["rows"], known, experiment) == []


@pytest.mark.long
def test_jobs_of_a_cluster_give_what_was_published(tmp_path: Path) -> None:
    """With submitit's jobs on this computer."""
    run_on_cluster(NAME_OF_REAL, REAL, tmp_path, cluster="local", parts=2, parameters={"timeout_min": 5})
    experiment, known = find_experiment(NAME_OF_REAL), load_published(NAME_OF_REAL)
    assert known is not None
    rows = [gather(experiment, REAL, tmp_path)[task] for task in experiment.tasks(REAL)]
    assert differences(rows, known, experiment) == []


def test_a_preempted_job_goes_on_as_the_same_job(tmp_path: Path) -> None:
    job = PartJob(NAME_OF_REAL, REAL, Part(1, 2), tmp_path)
    assert job.checkpoint().function == job


@pytest.mark.parametrize(
    ("cluster", "parameters"), [("slurn", {}), ("local", {"no_such_parameter": 3}), ("slurm", {})]
)
def test_a_cluster_that_cannot_be_used_is_one_sentence(
    tmp_path: Path, cluster: str, parameters: dict[str, Any]
) -> None:
    with pytest.raises(JobFailed, match="--cluster"):
        run_on_cluster(NAME_OF_REAL, REAL, tmp_path, cluster=cluster, parts=1, parameters=parameters)


def test_a_job_that_fails_is_named_with_its_error(tmp_path: Path) -> None:
    with pytest.raises(JobFailed, match="part 1/1 of forrage failed as job"):
        run_on_cluster("forrage", REAL, tmp_path, cluster="local", parts=1)
