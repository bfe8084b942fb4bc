"""Failing worlds for tests: kept in folders as the search keeps them, of the forager with a planted failure."""

from __future__ import annotations

from pathlib import Path

from tests.falsification.planted import TOO_FAR, make_library, make_measure

from understudy.falsification.failing_world import FailingWorld, FailureFacts, write_failing_world
from understudy.falsification.failure_replay import compute_end_hash, replay_failure
from understudy.falsification.joint_worlds import Trial
from understudy.falsification.simpler_worlds import strip_for_file

MEASURE = make_measure()
LIBRARIES, ROOTS = {"forager": make_library(TOO_FAR)}, {"forager": ("forage", dict[str, str]())}


def keep(trial: Trial, folder: Path) -> FailingWorld:
    """Keep a world in which the planted forager fails."""
    trial = Trial(strip_for_file(trial.scenario, name="forage", about="It fails."), trial.seed)
    results = MEASURE([trial])
    replay = replay_failure(MEASURE, trial, LIBRARIES, ROOTS, progress_s=float(results.progress_s[0]))
    facts = FailureFacts(
        behavior="forage", binding={}, seed=trial.seed, limit_s=600.0, robustness=float(results.robustness[0]),
        wrong_s=replay.wrong_s, end_hash=compute_end_hash(MEASURE, trial), found_by="random", steps=(),
        why=replay.sentences, place=replay.place, states=replay.states,
    )  # fmt: skip
    return write_failing_world(folder, trial, facts, replay, command="understudy run")
