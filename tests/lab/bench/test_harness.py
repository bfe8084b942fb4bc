"""Measuring itself: turns, medians, goals; and what is measured is what the issue of speeds is about."""

from __future__ import annotations

from functools import partial
from math import isnan, nan

import pytest

from understudy.model.library import Library
from understudy.runtime.link import link
from understudy_lab.bench import harness, patrol, standard_task, swarm
from understudy_lab.bench.harness import BenchCase, BenchGoal, PeerMissing, Row, measure, result, speed


class Fake:
    """Ten robots whose runs take what a list says, in order."""

    robots = 10

    def __init__(self, name: str, turns: list[str]) -> None:
        self.name, self.turns = name, turns

    def reset(self) -> None:
        self.turns.append(f"reset {self.name}")

    def run(self, ticks: int) -> None:
        self.turns.append(f"run {self.name}")


def never() -> Fake:
    raise PeerMissing(peer="Nobody")


def test_cases_take_turns_and_the_first_round_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    times = iter([99.0, 99.0, 1.0, 10.0, 2.0, 10.0, 4.0, 10.0])
    monkeypatch.setattr(harness, "seconds", lambda subject, ticks: (subject.run(ticks), next(times))[1])
    turns: list[str] = []
    cases = [BenchCase(name, partial(Fake, name, turns), threads=1, ticks=8) for name in ("one", "other")]
    rows = measure([*cases, BenchCase("missing", never, threads=1, ticks=8)], rounds=3)
    assert turns == ["reset one", "run one", "reset other", "run other"] * 4
    assert [row["task"] for row in rows] == ["one", "other"]
    assert rows[0] == {
        "task": "one",
        "robots": 10,
        "threads": 1,
        "robot_ticks_per_s": 40.0,
        "spread": 1.5,
        "slowest": 20.0,
        "fastest": 80.0,
        "ticks": 8,
        "rounds": 3,
    }


GOALS = [  # value, least, most, reached
    (4.0, 4.0, None, True),
    (3.9, 4.0, None, False),
    (2.0, None, 2.0, True),
    (2.1, None, 2.0, False),
    (nan, 4.0, None, None),
    (nan, None, 2.0, None),
]


@pytest.mark.parametrize(("value", "least", "most", "reached"), GOALS)
def test_a_goal(value: float, least: float | None, most: float | None, reached: bool | None) -> None:
    told = result([], [BenchGoal("speed", lambda rows: value, least, most)])
    assert told["passed"] is (reached is not False)
    assert told["goals"][0]["passed"] is reached


def test_a_row_that_was_not_measured_has_no_speed() -> None:
    rows: list[Row] = [
        {"task": "full", "robots": 10, "threads": threads, "robot_ticks_per_s": 5.0 * threads}
        for threads in (1, 2)
    ]
    assert speed(rows, "full", 10, threads=1) == 5.0
    assert speed(rows, "full", 10) == 10.0
    assert isnan(speed(rows, "base", 10))


def test_goals_of_the_swarm_find_their_rows() -> None:
    """With every row there at a speed of 1, every rate is 1 and every ratio is 1."""
    robots = {swarm.BASE_EACH: 10_000, swarm.VMAS_EACH: 10_000, swarm.VMAS: 100}
    rows: list[Row] = [
        {
            "task": case.task,
            "robots": robots.get(case.task, size),
            "threads": case.threads,
            "robot_ticks_per_s": 1.0,
        }
        for case in (case for group in swarm.groups() for case in group)
        for size in (100, 1_000, 10_000, 100_000)
    ]
    assert [goal.of(rows)["value"] for goal in swarm.GOALS] == [1.0] * 8
    assert swarm.list_missing_peers(rows) == []
    assert {row["of_by_hand"] for row in swarm.fractions(rows)} == {1.0}


LIBRARIES = [  # library, root, levels, states, nodes
    (standard_task.make_base_library(), standard_task.BASE, 1, 5, 95),
    (standard_task.make_full_library(), standard_task.FULL, 3, 23, 125),
    (patrol.library(), "patrol", 2, 13, 74),
]


@pytest.mark.parametrize(("library", "root", "levels", "states", "nodes"), LIBRARIES)
def test_programs_are_as_large_as_they_say(
    library: Library, root: str, levels: int, states: int, nodes: int
) -> None:
    link(library, root)
    automata = [taught.automaton for taught in library.taught.values()]
    trees = [tree for automaton in automata for tree in automaton.transitions.values()]
    assert _levels(library, root) == levels
    assert sum(len(automaton.states) for automaton in automata) == states
    assert sum(len(getattr(tree, "nodes", ())) for tree in trees) == nodes


def _levels(library: Library, name: str) -> int:
    if name not in library.taught:
        return 0
    return 1 + max(_levels(library, state.behavior or "") for state in library.automaton(name).states)


def test_density_is_the_same_at_every_size() -> None:
    for robots in (100, 10_000, 1_000_000):
        width, height = standard_task.make_full_scenario(robots).size
        assert robots / (width * height) == pytest.approx(0.25)
