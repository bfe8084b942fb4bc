"""Search for failing worlds: what can vary, runs side by side, at random and directed."""

from __future__ import annotations

from functools import partial
from math import inf

import numpy as np
import pytest
from msgspec.structs import replace
from tests.falsification.planted import FORAGE, make_measure

from understudy.addons.checks.falsification import random_search
from understudy.addons.checks.falsification.directed_search import search_directed
from understudy.addons.checks.falsification.disturbances import list_disturbances
from understudy.addons.checks.falsification.falsify import falsify
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.random_search import (
    RandomSearch,
    SeedBatches,
    measure_seeds,
    search_at_random,
)
from understudy.addons.checks.falsification.search_space import DISTURBANCES, PLACES, SIZES, SearchSpace
from understudy.addons.checks.falsification.trial import TrialResults
from understudy.errors import SettingError
from understudy.sim.catalog import find_scenario
from understudy.sim.scenario.files import format_scenario, list_builtin_scenarios, parse_scenario
from understudy.sim.scenario.schema import Breakdown, Scenario
from understudy.sim.world import World


def same(one: TrialResults, other: TrialResults) -> bool:
    return all(
        np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True)
        for name in ("robustness", "failed_s", "progress_s")
    )


@pytest.mark.parametrize("name", list_builtin_scenarios())
def test_every_vector_is_a_valid_world(name: str) -> None:
    scenario, rng = find_scenario(name), np.random.default_rng(5)
    space = SearchSpace(scenario)
    assert len(set(space.names)) == len(space)
    for seed in range(3):
        made = space.decode(rng.random(len(space)))
        assert parse_scenario(format_scenario(made)) == made
        World(made, [seed])
    for edge in (np.zeros(len(space)), np.full(len(space), np.nextafter(1.0, 0.0))):
        World(space.decode(edge), [0])


def test_a_world_is_found_again_from_its_vector() -> None:
    space, view = SearchSpace(FORAGE), World(FORAGE, [11]).view()
    again = World(space.decode(space.encode(view, np.random.default_rng(0))), [11]).view()
    assert np.allclose(again.robots.x, view.robots.x)
    assert np.allclose(again.robots.heading, view.robots.heading)
    assert np.allclose(again.objects.x, view.objects.x)
    assert np.allclose(again.objects.y, view.objects.y)


ASPECTS = [  # what varies, how many numbers of the forage scenario: 5 objects, 1 robot, a count and an amount
    ((PLACES,), 2 * 5 + 3),
    ((PLACES, SIZES), 2 * 5 + 3 + 2),
    ((PLACES, SIZES, DISTURBANCES), 2 * 5 + 3 + 2),  # it has no noise
]


@pytest.mark.parametrize(("vary", "numbers"), ASPECTS)
def test_what_varies(vary: tuple[str, ...], numbers: int) -> None:
    assert len(SearchSpace(FORAGE, vary)) == numbers


def test_disturbances_stay_within_their_limits() -> None:
    noisy = _make_noisy(0.3)
    space = SearchSpace(noisy, (DISTURBANCES,))
    assert space.names == ("types.forager.noise_drive", "types.forager.sensors[0].dropout")
    strongest = space.decode(np.ones(2)).types["forager"]
    assert (strongest.noise_drive, strongest.sensors[0].dropout) == (0.2, 0.6)
    most = [each.most for each in list_disturbances(_make_noisy(0.7))]
    assert most == [0.2, 0.95]


def _make_noisy(dropout: float) -> Scenario:
    kind = FORAGE.types["forager"]
    sensors = (replace(kind.sensors[0], dropout=dropout), *kind.sensors[1:])
    return replace(FORAGE, types={"forager": replace(kind, noise_drive=0.1, sensors=sensors)})


def test_robots_that_fail_are_varied_within_their_ranges() -> None:
    """Of two robots none or one fails, from 10 s to 50 s; the third number chooses how many, the fourth when."""
    group = replace(FORAGE.robots[0], count=2, fails=(Breakdown(at_s=(10.0, 50.0), count=(0, 1)),))
    space = SearchSpace(replace(FORAGE, robots=(group,)), (DISTURBANCES,))
    assert space.names == ("robots[0].fails[0].count", "robots[0].fails[0].at_s")
    made = [space.decode(np.array(each)).robots[0].fails[0] for each in ((0.0, 0.0), (0.6, 0.5), (0.4, 1.0))]
    assert [(each.count, each.at_s) for each in made] == [(0, 10.0), (1, 30.0), (0, 50.0)]
    world = World(space.scenario, [3])
    again = space.decode(space.encode(world.view(), np.random.default_rng(0))).robots[0].fails[0]
    ticks = world.failure_ticks[world.failure_ticks >= 0]
    assert again.count == len(ticks)
    if len(ticks):
        assert again.at_s == pytest.approx(ticks[0] * 0.1, abs=0.1)


def test_worlds_whose_robots_fail_differently_run_side_by_side() -> None:
    measure = make_measure()
    group = replace(FORAGE.robots[0], count=2)
    fails = [(), (Breakdown(at_s=0.0, robots=(0, 1)),), (Breakdown(at_s=60.0, robots=(1,)),)]
    trials = [Trial(replace(FORAGE, robots=(replace(group, fails=each),)), 5) for each in fails]
    together = measure(trials)
    assert same(together, TrialResults.concatenate([measure([trial]) for trial in trials]))
    assert together.robustness[1] == -1.0, "none moves"
    assert together.robustness[0] > together.robustness[2], "alone it takes longer"


def test_a_scenario_in_which_nothing_varies() -> None:
    fixed = replace(FORAGE, objects=(), robots=(replace(FORAGE.robots[0], at=((1.0, 1.0, 0.0),)),), goal=None)
    with pytest.raises(SettingError, match="nothing that can be varied"):
        SearchSpace(fixed, (DISTURBANCES,))


def test_worlds_side_by_side_are_as_alone() -> None:
    """Bit for bit, though their scenarios have other places, numbers and amounts."""
    space, rng, measure = SearchSpace(FORAGE), np.random.default_rng(3), make_measure()
    trials = [Trial(space.decode(rng.random(len(space))), seed) for seed in range(12)]
    trials += [Trial(FORAGE, seed) for seed in range(3)]
    assert same(measure(trials), TrialResults.concatenate([measure([trial]) for trial in trials]))


def test_robustness() -> None:
    """Above 0 for success, the share of the limit that is left; below 0 for failure, what was missing."""
    seeds = [Trial(FORAGE, seed) for seed in range(40)]
    good, planted = make_measure(99.0)(seeds), make_measure()(seeds)
    assert (good.robustness > 0).all()
    assert np.isnan(good.failed_s).all()
    assert np.allclose(good.robustness, 1 - good.progress_s / 600.0)
    assert 0 < planted.failed.sum() < 20
    assert (planted.failed_s[planted.failed] == 600.0).all()
    assert ((planted.robustness >= -1) & (planted.progress_s < 600.0))[planted.failed].all()
    assert all(states == {"start"} for states in planted.last_states[planted.failed])
    hurried = make_measure(99.0, limit_s=60.0)(seeds)
    assert set(np.flatnonzero(hurried.failed)) == set(np.flatnonzero(good.progress_s > 60.0))


def test_batches_fit_the_time_that_worlds_take() -> None:
    now = 0.0
    batches = SeedBatches(1000, None, end=60.0, clock=lambda: now)
    sizes = []
    for s_per_world in (0.1, 0.01, 0.01, 0.02, 0.02, 0.1, 0.2, 0.2, 0.2, 0.2):
        seeds = batches.take()
        sizes.append(len(seeds))
        now += len(seeds) * s_per_world
        batches.note(len(seeds), len(seeds) * s_per_world)
    # At first 20. Then what 5 s suffice for, such as 50 worlds of 0.1 s, but no more than ten times as many as before.
    # At 57.5 s and at 59.9 s what is left suffices for 12 worlds and for less than one.
    assert sizes == [20, 50, 500, 500, 250, 250, 50, 12, 1, 0]


LEFT = [  # worlds, the end, s; time now, s; how long the first 20 worlds took, and the 66 after them; what is left, s
    (1000, None, 9.0, (1.5,), 0.0),  # the first may have loaded kernels
    (1000, None, 9.0, (1.5, 0.66), 9.14),  # 914 worlds of 0.01 s
    (1000, None, 9.0, (22.0,), 980.0),
    (1000, 60.0, 9.0, (22.0,), 51.0),
    (None, 60.0, 9.0, (1.5, 0.66), 51.0),
    (None, None, 9.0, (1.5, 0.66), inf),
    (None, None, 9.0, (), 0.0),
]


@pytest.mark.parametrize(("worlds", "end", "now", "took_s", "left_s"), LEFT)
def test_what_is_left_is_estimated_from_what_was_run(
    worlds: int | None, end: float | None, now: float, took_s: tuple[float, ...], left_s: float
) -> None:
    batches = SeedBatches(5, worlds, end=end, clock=lambda: now)
    batch = batches.take()
    for seconds in took_s:
        batches.note(len(batch), seconds)
        batch = batches.take()
    assert batches.estimate_left_s() == pytest.approx(left_s)


@pytest.mark.long
def test_search_at_random_counts_as_running_them_all() -> None:
    measure = make_measure()
    found = search_at_random(partial(measure_seeds, measure, FORAGE), first_seed=50, most_runs=230)
    results = measure([Trial(FORAGE, seed) for seed in range(50, 280)])
    assert (found.runs, found.failed) == (230, int(results.failed.sum()))
    assert {seed for _, seed in found.failures} == {50 + int(row) for row in np.flatnonzero(results.failed)}
    low, high = found.interval
    assert low < found.failed / found.runs < high
    shared = search_at_random(partial(measure_seeds, measure, FORAGE), first_seed=50, most_runs=230, jobs=2)
    assert (shared.failed, shared.failures) == (found.failed, found.failures)


def test_no_failure_says_at_most_how_many() -> None:
    assert RandomSearch(runs=1000).interval[1] == pytest.approx(1 - 0.025**0.001)


@pytest.mark.long
def test_a_planted_failure_is_found_by_the_directed_search() -> None:
    """It is so far away (14 m) that only one of many thousands of worlds has it."""
    measure, space = make_measure(14.0), SearchSpace(FORAGE)
    found = search_directed(measure, space, seed=1, most_runs=1500)
    assert len(found.failures) == 1
    assert found.failures[0][0] < 0
    assert measure([found.failures[0][1]]).failed.all()
    at_random = search_at_random(
        partial(measure_seeds, measure, FORAGE), first_seed=0, most_runs=2 * found.runs
    )
    assert at_random.failed == 0


def test_a_search_with_one_seed_is_repeated() -> None:
    searches = [search_directed(make_measure(99.0), SearchSpace(FORAGE), seed=4, most_runs=30) for _ in "ab"]
    assert searches[0].nearest == searches[1].nearest
    assert search_directed(make_measure(99.0), SearchSpace(FORAGE), seed=5, most_runs=30) != searches[0]


def test_an_interruption_keeps_what_was_found() -> None:
    def interrupt(found: object) -> None:
        raise KeyboardInterrupt

    measure = make_measure()
    at_random = search_at_random(partial(measure_seeds, measure, FORAGE), first_seed=0, progress=interrupt)
    assert at_random.interrupted
    assert at_random.runs == random_search.FIRST_BATCH
    assert at_random.failures
    directed = search_directed(make_measure(99.0), SearchSpace(FORAGE), seed=1, progress=interrupt)
    assert directed.interrupted
    assert directed.runs > 0


def test_a_falsification_that_is_interrupted_keeps_the_failing_world() -> None:
    def interrupt(doing: str, runs: int, failed: int) -> None:
        if failed:
            raise KeyboardInterrupt

    found = falsify(make_measure(), FORAGE, report=interrupt)
    assert found.interrupted
    assert found.shrinking is not None
    assert found.shrinking.results.failed.all()
