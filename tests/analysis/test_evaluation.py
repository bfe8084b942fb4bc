"""The yardstick, its lower bound, and the measuring of runs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from understudy.errors import SettingError
from understudy.judging.baseline import ControllerRun
from understudy.judging.outcomes import Outcomes, measure_success
from understudy.sim.forage import Forage, ForageSettings, make_corner_cases
from understudy_lab.tasks.forage_expert import ExpertForager, lower_bound

GOLDEN = Path(__file__).parents[1] / "golden" / "hand_forager.json"


def by_hand(world: Forage, limit_s: float = 3000.0) -> Outcomes:
    forager = ExpertForager(world.agents, world.settings)
    return measure_success(ControllerRun(world, forager.decide, forager.keys), limit_s)


def test_yardstick_is_near_its_bound_on_fresh_worlds() -> None:
    world = Forage(range(50_000, 50_200))
    bound = lower_bound(world)
    outcomes = by_hand(world)
    ratio = outcomes.seconds / bound
    assert outcomes.success == 1.0
    assert np.median(ratio) <= 1 / 0.85
    assert ratio.min() > 1.0
    assert ratio.max() < 1.5


@pytest.mark.parametrize("case", make_corner_cases())
def test_yardstick_masters_the_corner_cases(case: str) -> None:
    world = Forage(range(60), make_corner_cases()[case])
    bound = lower_bound(world)
    outcomes = by_hand(world)
    assert outcomes.success == 1.0
    assert (outcomes.delivered == world.total).all()
    assert (outcomes.seconds >= bound - 1e-9).all()
    if case == "no food at all":
        assert (outcomes.seconds == 0.1).all()  # the goal is judged after a tick
        assert (outcomes.food_per_s == 0).all()


def test_bound_of_a_world_reckoned_by_hand() -> None:
    world = Forage([5], ForageSettings(sources=(1, 1), amounts=(14, 14)))
    view = world.view()
    robot = np.array([view.robots.x[0], view.robots.y[0]])
    things = np.stack([view.objects.x, view.objects.y], axis=1)
    (source,), (station,) = things[view.objects.food], things[view.objects.home]
    way, back = np.hypot(*(source - robot)), np.hypot(*(source - station))
    meters = way - 0.5 + 3 * (back - 1.0)  # there, home, there, home
    assert lower_bound(world)[0] == pytest.approx(meters / 0.5 + 14 * (1.0 + 1.0))


def test_each_world_stops_at_its_own_limit() -> None:
    alone = by_hand(Forage([0, 1, 2]))
    world = Forage([0, 1, 2])
    forager = ExpertForager(3, world.settings)
    limits = np.array([alone.seconds[0], alone.seconds[1] - 0.1, 0.0])
    outcomes = measure_success(ControllerRun(world, forager.decide, forager.keys), limits)
    assert outcomes.finished.tolist() == [True, False, False]
    assert outcomes.seconds[0] == alone.seconds[0]
    assert outcomes.delivered[2] == 0
    assert outcomes.food_per_s[0] == pytest.approx(alone.delivered[0] / alone.seconds[0])
    assert np.isnan(outcomes.food_per_s[2])


def test_a_limit_that_is_no_time() -> None:
    with pytest.raises(SettingError, match="limit_s"):
        by_hand(Forage([0]), limit_s=-1.0)


def test_yardstick_does_one_thing_at_a_time_and_does_not_chatter() -> None:
    world = Forage(range(20))
    forager = ExpertForager(20, world.settings)
    turned, switches = np.zeros(20), np.zeros(20)
    for _ in range(3000):
        commands = forager.decide(world.sense(forager.keys))
        assert (np.count_nonzero(list(commands.values()), axis=0) <= 1).all()
        switches += commands["turn"] * turned < 0
        turned = commands["turn"]
        world.act(commands)
    assert world.success().all()
    assert switches.max() == 0


def moment(world: Forage) -> dict[str, Any]:
    robots, objects = world.view().robots, world.view().objects
    counts = {"stored": int(robots.stored[0]), "delivered": int(robots.delivered[0])}
    return {
        "counts": {**counts, "amounts": objects.amount[objects.food].tolist()},
        "pose": [float(column[0]) for column in (robots.x, robots.y, robots.heading)],
    }


def test_golden_run() -> None:
    world = Forage([2011])
    forager = ExpertForager(1, world.settings)
    run: list[dict[str, Any]] = []
    for tick in range(1001):
        if tick % 100 == 0:
            run.append(moment(world))
        world.act(forager.decide(world.sense(forager.keys)))
    golden = json.loads(GOLDEN.read_text(encoding="utf-8"))
    assert [each["counts"] for each in run] == [each["counts"] for each in golden]
    for found, stored in zip(run, golden, strict=True):
        assert found["pose"] == pytest.approx(stored["pose"], abs=1e-6)
