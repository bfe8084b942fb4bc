"""The transfer experiment: its first teaching beside what was published, and its conclusions from rows by hand."""

from __future__ import annotations

from math import nan
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="needs the extra mujoco")

from understudy.sim.scenario.schema import ElapsedSensor
from understudy_lab.results import differences, load_published
from understudy_lab.runner import row_of
from understudy_lab.sim_to_sim import study
from understudy_lab.sim_to_sim.study import (
    FLAT,
    GOTO,
    PATROL,
    PHYSICS,
    count_successes,
    make_physics_field,
    make_quiet_patrol_scenario,
)
from understudy_lab.tasks import soccer


@pytest.mark.retrains
def test_the_first_goto_is_as_published() -> None:
    known = load_published("transfer")
    assert known is not None
    row = row_of(study.EXPERIMENT, {"behavior": GOTO, "seed": study.SEEDS[0]})
    assert differences([row], known, study.EXPERIMENT) == []
    assert row[PHYSICS]["success"] > 0.9


def trial(behavior: str, flat: list[float | None], physics: list[float | None]) -> dict[str, Any]:
    """A row of a behavior; None where a trial failed."""
    both = {
        world: count_successes([nan if value is None else value for value in values])
        for world, values in ((FLAT, flat), (PHYSICS, physics))
    }
    return {"task": {"behavior": behavior, "seed": 1}, "examples": 30, **both}


def make_patrol_row(complete: int, cycles: int) -> dict[str, Any]:
    """A row of CollectivePatrol, whose 2-D cycles are all complete."""
    worlds = {
        world: {"complete": done, "cycles": of, "values": [5.0] * done, "success": done / of}
        for world, done, of in ((FLAT, 10, 10), (PHYSICS, complete, cycles))
    }
    return {"task": {"behavior": PATROL, "seed": 1}, "examples": 190, **worlds}


LEFT = [  # trials in 2-D and in physics, what is left of the success, whether that is enough
    ([1.0, 2.0], [1.0, 2.0], 1.0, True),
    ([1.0, 2.0], [1.0, None], 0.5, False),
    ([1.0, None], [1.0, None], 1.0, True),
    ([1.0] * 10, [1.0] * 9 + [None], 0.9, True),
]


@pytest.mark.parametrize(("flat", "physics", "left", "held"), LEFT)
def test_what_is_left(flat: list[float | None], physics: list[float | None], left: float, held: bool) -> None:
    (goal,) = study.EXPERIMENT.conclude([trial(GOTO, flat, physics)]).goals
    assert (goal.measured, goal.held) == (f"{left:.2f}", held)


@pytest.mark.parametrize(("complete", "cycles", "held"), [(8, 10, True), (7, 10, False)])
def test_cycles_are_counted_over_all(complete: int, cycles: int, held: bool) -> None:
    found = study.EXPERIMENT.conclude([make_patrol_row(complete, cycles), make_patrol_row(complete, cycles)])
    assert found.goals[0].held is held
    assert found.numbers[PATROL][PHYSICS]["of"] == 2 * cycles


def test_a_trial_without_a_value_failed() -> None:
    assert count_successes([3.0, nan, 1.0], least=2.0)["success"] == pytest.approx(1 / 3)


def test_both_worlds_begin_alike() -> None:
    body = soccer.Soccer([7, 8], soccer.ANYWHERE)
    ground = make_physics_field(body)
    for world in (0, 1):
        flat, found = body.view(world), ground.view(world)
        assert found.robots.x == pytest.approx(flat.robots.x)
        assert np.array_equal(found.objects.x, flat.objects.x)
        assert ground.arenas[world].pose(0).heading == pytest.approx(float(flat.robots.heading[0]))


def test_where_nobody_looks_nothing_is_drawn() -> None:
    assert not any(
        isinstance(each, ElapsedSensor)
        for kind in make_quiet_patrol_scenario().types.values()
        for each in kind.sensors
    )
