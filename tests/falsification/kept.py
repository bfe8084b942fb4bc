"""Failing worlds for tests: kept in folders as the search keeps them, of the forager with a planted failure."""

from __future__ import annotations

from pathlib import Path

from tests.falsification.planted import TOO_FAR, make_library, make_measure

from understudy.addons.checks.falsification.failing_world import (
    FailingWorld,
    FailureFacts,
    write_failing_world,
)
from understudy.addons.checks.falsification.failure_replay import compute_end_hash, replay_failure
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.simpler_worlds import strip_for_file
from understudy.addons.checks.falsification.trial import GoalMeasure
from understudy.judging.evaluate import make_evaluation_task
from understudy.model.library import Library

MEASURE = make_measure()


def keep(
    trial: Trial, folder: Path, *, library: Library | None = None, limit_s: float = 600.0
) -> FailingWorld:
    """Keep a world in which the forager of a library fails, by default the planted one."""
    library = library or make_library(TOO_FAR)
    measure = GoalMeasure(make_evaluation_task(library, "forage", trial.scenario), limit_s)
    trial = Trial(strip_for_file(trial.scenario, name="forage", about="It fails."), trial.seed)
    results = measure([trial])
    assert results.failed.all()
    roots = {"forager": ("forage", dict[str, str]())}
    replay = replay_failure(
        measure, trial, {"forager": library}, roots, progress_s=float(results.progress_s[0])
    )
    facts = FailureFacts(
        behavior="forage", binding={}, seed=trial.seed, limit_s=limit_s, robustness=float(results.robustness[0]),
        wrong_s=replay.wrong_s, end_hash=compute_end_hash(measure, trial), found_by="random", steps=(),
        why=replay.sentences, place=replay.place, states=replay.states,
    )  # fmt: skip
    return write_failing_world(folder, trial, facts, replay, command="understudy run")
