"""Failing worlds that are run again: with the library of before each fails as it did, with a better one it passes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from msgspec.structs import replace as with_changes
from tests.falsification.kept import keep
from tests.falsification.planted import FORAGE, TOO_FAR, make_library
from tests.falsification.test_failing_world import list_failing_seeds

from understudy.addons.checks.falsification.failing_world import FailingWorld, list_failing_worlds
from understudy.addons.checks.falsification.failure_replay import compute_end_hash
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.rerun_failures import (
    find_wrong_time,
    make_failure_measure,
    rerun_failing_world,
    rerun_failing_worlds,
)
from understudy.model.library import Library
from understudy.model.property import Property, PropertyKind, SeededWorlds
from understudy.sim.forage import FORAGE_KIT

NEVER_SLOWS = 99.0
"""So far (m) nothing is in this arena: the planted idleness is gone."""


@pytest.fixture(scope="module")
def worlds(tmp_path_factory: pytest.TempPathFactory) -> tuple[FailingWorld, ...]:
    """Three worlds in which the planted forager fails."""
    folder = tmp_path_factory.mktemp("failures")
    for number, seed in enumerate(list_failing_seeds()[:3], 1):
        keep(Trial(FORAGE, seed), folder / f"forage-{number}")
    return list_failing_worlds(folder)[0]


def test_each_fails_again_as_it_did(worlds: tuple[FailingWorld, ...]) -> None:
    for result in rerun_failing_worlds(worlds, make_library(TOO_FAR)):
        facts = result.facts
        assert (result.has_failed, result.has_passed, result.problem) == (True, False, "")
        assert result.robustness == facts.robustness
        assert str(result) == f"{result.folder.name} still fails"
        assert find_wrong_time(result, make_library(TOO_FAR)) == facts.wrong_s
        measure = make_failure_measure(result, make_library(TOO_FAR))
        assert compute_end_hash(measure, result.trial) == facts.end_hash


def test_a_corrected_library_passes(worlds: tuple[FailingWorld, ...]) -> None:
    for result in rerun_failing_worlds(worlds, make_library(NEVER_SLOWS)):
        assert (result.has_failed, result.has_passed) == (False, True)
        assert find_wrong_time(result, make_library(NEVER_SLOWS)) is None
        assert 0 < result.robustness < 1
        assert str(result) == f"{result.folder.name} passes now"


def test_the_libraries_of_a_team_give_the_same(worlds: tuple[FailingWorld, ...]) -> None:
    one, team = make_library(TOO_FAR), {"forager": make_library(TOO_FAR)}
    assert rerun_failing_worlds(worlds, team) == rerun_failing_worlds(worlds, one)


def test_the_limit_is_the_one_that_was_kept(worlds: tuple[FailingWorld, ...]) -> None:
    hurried = replace(worlds[0], facts=with_changes(worlds[0].facts, limit_s=10.0))
    result = rerun_failing_world(hurried, make_library(NEVER_SLOWS))
    assert result.has_failed


MOVES = [  # the condition that must never hold, whether it fails
    ("food_stored is at least 1 units", True),
    ("distance_to(station) is above 1000 m", False),
]


@pytest.mark.parametrize(("what", "fails"), MOVES)
def test_the_property_that_failed_is_judged(worlds: tuple[FailingWorld, ...], what: str, fails: bool) -> None:
    """The library reaches its goal: only the property counts."""
    subject = Property(
        kind=PropertyKind.NEVER,
        what=what,
        start=SeededWorlds("forage", (1,)),
        name="empty",
        behavior="forage",
    )
    failing = replace(worlds[0], facts=with_changes(worlds[0].facts, property="empty"))
    result = rerun_failing_world(failing, make_library(NEVER_SLOWS), properties=[subject])
    assert (result.problem, result.has_failed) == ("", fails)
    if fails:
        wrong_s = find_wrong_time(failing, make_library(NEVER_SLOWS), properties=[subject])
        assert wrong_s is not None
        assert 0 < wrong_s < 600


def test_what_cannot_be_run_has_a_problem(worlds: tuple[FailingWorld, ...]) -> None:
    missing = rerun_failing_world(worlds[0], Library(FORAGE_KIT))
    assert "forage" in missing.problem
    assert not missing.has_failed
    assert not missing.has_passed
    assert str(missing) == f"{worlds[0].folder.name} could not be run: {missing.problem}"
    failing = replace(worlds[0], facts=with_changes(worlds[0].facts, property="stays_near"))
    result = rerun_failing_world(failing, make_library(TOO_FAR))
    folder: Path = worlds[0].folder
    assert result.problem == (
        f"{folder}: property is 'stays_near', which the library's properties.toml does not have; restore it there, or "
        "delete this folder"
    )
