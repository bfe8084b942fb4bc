"""Failing worlds for tests: kept in folders as the search keeps them, of the forager with a planted failure."""

from __future__ import annotations

from pathlib import Path

from tests.falsification.planted import TOO_FAR, make_library, make_measure

from understudy.addons.checks.falsification.failing_world import FailingWorld
from understudy.addons.checks.falsification.falsify import keep_failure
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.shrink import Shrinking
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
    found = Shrinking(trial, measure([trial]))
    assert found.results.failed.all()
    roots = {"forager": ("forage", dict[str, str]())}
    libraries = {"forager": library}
    return keep_failure(folder, found, measure, libraries, roots, about="It fails.", command="understudy run")
