"""Bodies of one's own, teams, and goals and metrics of one's own, whose every number can be checked by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from tests.analysis.own_bodies import (
    KIT,
    LIBRARY,
    Carts,
    Frozen,
    divide_by_seed,
    give_text,
    is_close,
    make_approach,
    make_cart_but_the_third,
    make_number,
    make_pair,
    measure_way,
    raise_error_after_2_m,
)
from tests.sim.patrollers import SCENARIO, make_libraries
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.errors import SettingError, UnderstudyError, UnknownName
from understudy.judging.evaluate import evaluate
from understudy.judging.evaluation_task import EvaluationFailed
from understudy.judging.world_run import WorldRun
from understudy.model.library import Library
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT

FORAGE = find_scenario("forage")
FORAGERS = Library.from_automata(FORAGE_KIT, *AUTOMATA)
SEEDS = range(1, 5)


def evaluate_carts(**options: Any) -> Any:
    return evaluate(LIBRARY, "approach", Carts, SEEDS, **{"limit_s": 7.0, **options})


def test_a_body_of_ones_own_runs_until_its_flag() -> None:
    """From 3 m away it drives 0.5 m a tick of 0.5 s: 6 ticks to 0 m; at 0 m it is done a tick later."""
    found = evaluate_carts()
    assert found.taught.seconds[:3].tolist() == [1.5, 2.5, 3.5]
    assert (found.flag, found.goal, found.world, found.simulated) == ("done", None, "Carts", False)
    assert found.success == 1.0
    assert evaluate_carts(limit_s=3.0).taught.finished.tolist() == [True, True, False, False]


def test_the_limit_is_included() -> None:
    assert evaluate_carts(limit_s=2.5).taught.finished.tolist() == [True, True, False, False]
    assert evaluate_carts(limit_s=2.4).taught.finished.tolist() == [True, False, False, False]


GOALS = [  # a goal, and when a cart that starts 1, 2, 3 or 4 m away reaches it
    ("near", [0.0, 0.5, 1.5, 2.5]),
    (is_close, [0.5, 1.5, 2.5, 3.5]),
    ("done", [1.5, 2.5, 3.5, 4.5]),
]


@pytest.mark.parametrize(("goal", "seconds"), GOALS)
def test_goals_of_ones_own(goal: Any, seconds: list[float]) -> None:
    found = evaluate_carts(goal=goal)
    assert found.taught.seconds.tolist() == seconds
    names = (None, "done") if goal == "done" else (getattr(goal, "__name__", goal), None)
    assert (found.goal, found.flag) == names


def test_a_goal_is_that_of_all_agents() -> None:
    found = evaluate(LIBRARY, "approach", make_pair, SEEDS, goal="near", limit_s=9.0)
    assert found.taught.seconds.tolist() == [0.5, 1.5, 2.5, 3.5]  # the second cart is 1 m behind


def test_metrics_of_ones_own() -> None:
    found = evaluate(
        LIBRARY,
        "approach",
        make_pair,
        SEEDS,
        goal="near",
        limit_s=9.0,
        metrics={"far": "far", "way": measure_way},
        record=["far"],
    )
    assert found.metrics["far"].tolist() == [1.0] * 4  # 0.5 and 1.5 m: the mean of the two
    assert found.metrics["way"].tolist() == [1.0, 3.0, 5.0, 7.0]
    assert list(found.columns) == ["seed", "success", "seconds", "limit_s", "far", "way"]


PROBLEMS = [
    ({"a": "load"}, [0, 1, 2], "metric 'a' is absent (NaN)"),
    ({"a": divide_by_seed}, [0], "metric 'a' raised ZeroDivisionError: division by zero"),
    ({"a": give_text}, [0, 1, 2], "metric 'a' gave 'far', which is not one number"),
]


@pytest.mark.parametrize(("metrics", "seeds", "problem"), PROBLEMS)
def test_a_metric_that_cannot_be_computed_is_absent(
    metrics: dict[str, Any], seeds: list[int], problem: str
) -> None:
    found = evaluate(LIBRARY, "approach", Carts, range(3), limit_s=7.0, metrics=metrics | {"far": "far"})
    assert found.problems == tuple(f"in the world of seed {seed}, {problem}" for seed in seeds)
    assert np.flatnonzero(np.isnan(found.metrics["a"])).tolist() == seeds
    assert found.success == 1.0
    assert not np.isnan(found.metrics["far"]).any()


def test_a_body_is_closed_at_its_end() -> None:
    made = list[Carts]()

    def make(seed: int) -> Carts:
        made.append(Carts(seed))
        return made[-1]

    evaluate(LIBRARY, "approach", make, SEEDS, limit_s=7.0)
    with pytest.raises(
        UnderstudyError, match=r"^the world of seed 4: goal raise_error_after_2_m raised ValueError"
    ):
        evaluate(LIBRARY, "approach", make, [4], limit_s=7.0, goal=raise_error_after_2_m, metrics={})
    assert [each.is_closed for each in made] == [True] * 5


def test_what_was_done_before_an_error_is_kept() -> None:
    with pytest.raises(
        EvaluationFailed, match=r"^the world of seed 3 ended with RuntimeError: no cart is left; "
    ) as it:
        evaluate(LIBRARY, "approach", make_cart_but_the_third, SEEDS, limit_s=7.0)
    assert it.value.part is not None
    assert it.value.part.seeds == (1, 2)
    assert it.value.part.taught.seconds.tolist() == [1.5, 2.5]


MISTAKES: list[tuple[dict[str, Any], str]] = [
    ({"limit_s": None}, "limit_s is missing for a body of your own; give the time limit in s"),
    ({"limit_s": -1.0}, "limit_s is -1.0; give a time in s"),
    ({"world": make_number}, r"what make_number made is a int without 'agents'; let it return a body"),
    ({"world": Frozen}, "time_s stood still at 100.0 s during a tick; let `act` advance it"),
    ({"goal": "far"}, "goal 'far' is continuous; name one that is yes or no, or give a function"),
    ({"goal": "nere"}, "has no flag, feature or reading 'nere'; did you mean 'near'"),
    ({"goal": raise_error_after_2_m}, r"goal raise_error_after_2_m raised ValueError: too near after 0\.0 s"),
    ({"metrics": ["lode"]}, "has no feature or reading 'lode'; did you mean 'load'"),
    ({"metrics": ["far(ball)"]}, r"reading 'far' takes no target|far: it is given 1 of its 0 parameters"),
    ({"metrics": "far"}, "metrics are 'far'; give names and what they mean"),
    ({"metrics": {"seconds": "far"}}, "metric 'seconds' has the name of another result"),
    ({"metrics": {"a": 3}}, "metrics 'a' is 3; give the name of a reading, or a function"),
    ({"jobs": 0}, "jobs is 0; give the number of processes, at least 1"),
    ({"jobs": 2, "goal": lambda run: True}, r"goal <lambda> cannot be sent to another process .*top level"),
    ({"library": {"robot": LIBRARY}}, "library is that of a team; a body of your own takes one library"),
]


@pytest.mark.parametrize(("options", "message"), MISTAKES)
def test_mistakes_are_one_sentence(options: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {"library": LIBRARY, "world": Carts, "limit_s": 7.0} | options
    library, world = given.pop("library"), given.pop("world")
    with pytest.raises(UnderstudyError, match=message) as found:
        evaluate(library, "approach", world, SEEDS, **given)
    assert "\n" not in str(found.value)


def test_a_behavior_without_a_flag_needs_a_goal() -> None:
    with pytest.raises(SettingError, match="goal is missing; name a flag or a reading that is yes or no"):
        evaluate(LIBRARY, "forward", Carts, SEEDS, limit_s=7.0)
    assert evaluate(LIBRARY, "forward", Carts, SEEDS, limit_s=7.0, goal="near").success == 1.0


def read_stored(run: WorldRun) -> float:
    return float(run.read("food_stored")[0])


def test_side_by_side_as_one_by_one() -> None:
    """Names are read from worlds side by side, many ticks at once; functions from one world at a time."""
    plain = evaluate(FORAGERS, "forage", FORAGE, range(4), limit_s=150.0)
    names = evaluate(FORAGERS, "forage", FORAGE, range(4), limit_s=150.0, metrics=["food_stored"])
    functions = evaluate(
        FORAGERS, "forage", FORAGE, range(4), limit_s=150.0, metrics={"food_stored": read_stored}
    )
    assert 0 < plain.success < 1
    assert len(set(names.metrics["food_stored"].tolist())) > 1
    for found in (names, functions):
        assert np.array_equal(found.taught.seconds, plain.taught.seconds, equal_nan=True)
        assert found.taught.delivered.tolist() == plain.taught.delivered.tolist()
        assert found.metrics["food_stored"].tolist() == names.metrics["food_stored"].tolist()
        assert np.array_equal(found.relative, plain.relative)


def is_at_station(run: WorldRun) -> bool:
    return bool(run.read("at_station")[0] == 1)


def test_a_reading_or_a_function_is_the_goal_in_a_scenario() -> None:
    given: dict[str, Any] = {"binding": {"A": "station"}, "metrics": ["distance_to(A)"]}
    flag, reading, function = (
        evaluate(FORAGERS, "goto", FORAGE, range(4), goal=goal, **given)
        for goal in (None, "at_station", is_at_station)
    )
    assert (flag.flag, reading.goal, function.goal) == ("done", "at_station", "is_at_station")
    assert reading.taught.seconds.tolist() == function.taught.seconds.tolist()
    assert (reading.taught.seconds < flag.taught.seconds).all()
    assert reading.metrics["distance_to(A)"].tolist() == function.metrics["distance_to(A)"].tolist()
    assert reading.expert is None


def test_a_goal_of_ones_own_replaces_a_missing_one() -> None:
    """A world that has neither a goal nor a flag can be evaluated by a reading, and a wrong name is refused at once."""
    aimless = replace(FORAGE, goal=None)
    assert evaluate(FORAGERS, "forage", aimless, range(2), goal="at_station", limit_s=300.0).success == 1.0
    with pytest.raises(UnknownName, match="no flag, feature or reading 'there'; it has distance_to"):
        evaluate(FORAGERS, "forage", aimless, range(2), goal="there")


def read_seen(run: WorldRun) -> float:
    return float(run.read("none_sees(intruder)")[0])


def test_a_team_with_goals_and_metrics() -> None:
    """Statistics that no program uses are sensed as well, and readings of robots that coordinators do not have."""
    libraries = make_libraries()
    given: dict[str, Any] = {"limit_s": 4.0, "goal": "all_done"}
    named = evaluate(
        libraries, "lead", SCENARIO, range(2), metrics=["none_sees(intruder)", "sonar_rear"], **given
    )
    computed = evaluate(libraries, "patrol/lead", SCENARIO, range(2), metrics={"none": read_seen}, **given)
    assert named.metrics["none_sees(intruder)"].tolist() == computed.metrics["none"].tolist()
    assert (named.metrics["sonar_rear"] > 0).all()
    assert (named.behavior, named.success) == ("lead", 0.0)
    other = evaluate(libraries, "lead", SCENARIO, range(2), goal="none_sees(intruder)", limit_s=4.0)
    assert other.goal == "none_sees(intruder)"


def test_the_robots_of_a_team_are_evaluated_as_before() -> None:
    library = Library.from_automata(FORAGE_KIT, *AUTOMATA)
    one = evaluate(library, "forage", FORAGE, range(2))
    of_team = evaluate(dict.fromkeys(FORAGE.types, library), "forage", FORAGE, range(2))
    assert one.taught.seconds.tolist() == of_team.taught.seconds.tolist()


def test_another_approach_of_the_kit() -> None:
    slow = Library.from_automata(KIT, make_approach(1.5))
    assert evaluate(slow, "approach", Carts, [3], limit_s=9.0).taught.seconds.tolist() == [2.5]
