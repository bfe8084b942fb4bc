"""Where a flag was raised, beside where it was pressed: a rate by the robot's own word says so."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.falsification.test_lesson_score import FORAGE, teach_distances
from tests.sim.patrollers import ROBOTS, SCENARIO
from tests.ui.cli.commands import run, run_json

from understudy.judging.comparison import compare
from understudy.judging.evaluate import evaluate
from understudy.judging.properties.condition_examples import ConditionExample, list_condition_examples
from understudy.judging.properties.run_property import run_property
from understudy.learning.fit import learn_automaton
from understudy.model.binding import Binding
from understudy.model.lesson import Example, ExampleKind
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.property import Property, PropertyKind, SeededWorlds
from understudy.sim.world import World
from understudy.storage.library_folder import save_automaton
from understudy.training.lesson_design import new_lesson

STATION = {"A": "station"}
SEEDS = range(5, 15)
"""Worlds in which goto says done at 0.29 m, since it goes on until it is nearer than 0.3 m."""


def test_the_flag_is_raised_where_it_was_shown() -> None:
    found = evaluate(teach_distances(0.1, 0.2, 0.3, beside=0.5), "goto", FORAGE, SEEDS, binding=STATION)
    assert found.raised is not None
    assert found.raised.elsewhere == 0
    low, high = found.raised.find_ends() or (0.0, 0.0)
    assert 0.25 < low <= high < 0.3
    assert found.raised.describe().startswith("done where distance_to(A) is 0.2")
    assert found.raised.describe().endswith(", shown at 0.10 to 0.30 m")


def test_elsewhere_it_is_said_in_how_many_worlds() -> None:
    found = evaluate(teach_distances(0.01, 0.02, 0.03, beside=0.05), "goto", FORAGE, SEEDS, binding=STATION)
    assert found.success == 1.0
    assert found.raised is not None
    assert found.raised.elsewhere == 10
    assert found.raised.describe().endswith("; elsewhere in 10 of 10 worlds")


BEYOND = [  # the nearest value, m, at which something else was right, elsewhere, beyond, said
    (0.5, 0, 5, "; beyond that in 5 of 10 worlds"),
    (0.05, 10, 0, "; elsewhere in 10 of 10 worlds"),
]


@pytest.mark.parametrize(("beside", "elsewhere", "beyond", "ending"), BEYOND)
def test_beyond_what_was_shown_it_is_said_although_nothing_says_that_it_is_wrong(
    beside: float, elsewhere: int, beyond: int, ending: str
) -> None:
    """Pressed at 0.01 to 0.03 m of 5 m, raised at 0.25 to 0.30 m: half of it by more than a twentieth farther away."""
    found = evaluate(teach_distances(0.01, 0.02, 0.03, beside=beside), "goto", FORAGE, SEEDS, binding=STATION)
    assert found.raised is not None
    assert (found.raised.elsewhere, found.raised.beyond) == (elsewhere, beyond)
    assert found.raised.leaves_shown
    assert found.raised.describe().endswith(ending)


def test_wherever_a_rate_by_a_flag_is_shown_its_range_is_beside_it() -> None:
    library = teach_distances(0.01, 0.02, 0.03, beside=0.05)
    found = evaluate(library, "goto", FORAGE, SEEDS, binding=STATION)
    assert found.raised is not None
    where = found.raised.describe()
    assert where in repr(found)
    assert where in " ".join(found.to_table().split())
    assert " ".join(compare(found, found).to_table().split()).count(where) == 2
    assert where in found._repr_html_()


ARRIVES = """understudy = "properties"
version = 1
[arrives]
behavior = "goto"
targets = { A = "station" }
world = "forage"
seeds = { first = 5, count = 10 }
always = "done is raised"
within_s = 60
"""


def test_the_test_of_a_property_says_where_its_flag_was_raised(tmp_path: Path) -> None:
    """It holds in all worlds, by the robot's own word."""
    for taught in teach_distances(0.01, 0.02, 0.03, beside=0.05).taught.values():
        save_automaton(tmp_path, taught)
    (tmp_path / "properties.toml").write_text(ARRIVES)
    text = " ".join(run("test", tmp_path).stdout.split())
    assert "arrives goto in forage: done is raised within 60 s" in text
    assert "shown at 0.01 to 0.03 m; elsewhere in 10 of 10 worlds" in text
    (row,) = run_json("test", tmp_path)["properties"]
    assert (row["verdict"], row["leaves_shown"]) == ("holds", True)


def test_the_values_are_those_at_which_it_was_raised_however_many_ticks_run_at_once() -> None:
    """With a metric, worlds run tick by tick."""
    library = teach_distances(0.1, 0.2, 0.3, beside=0.5)
    fast = evaluate(library, "goto", FORAGE, SEEDS, binding=STATION)
    slow = evaluate(library, "goto", FORAGE, SEEDS, binding=STATION, metrics=["distance_to(A)"])
    assert fast.raised is not None
    assert slow.raised is not None
    assert np.array_equal(fast.raised.values, slow.raised.values)
    assert np.array_equal(slow.raised.values[:, 0], slow.metrics["distance_to(A)"])
    assert fast.taught.seconds.tolist() == slow.taught.seconds.tolist()


def teach_obstacles() -> Library:
    """Return a library of four robots that drive around; done was pressed at an obstacle less than 1 m ahead."""
    lesson = new_lesson(
        ROBOTS, "roam", states=["forwards"], flags=["done"], features=["sonar_front_left"], live=False
    )
    done, go = (("done", ExampleKind.DIRECTIVE), ("forwards", ExampleKind.CONFIRMATION))
    shown = [(0.8, *done), (0.7, *done), (0.9, *done), (1.1, *go), (1.2, *go), (2.0, *go), (3.0, *go)]
    rows = [("start", 2.0, "forwards", ExampleKind.DIRECTIVE), *(("forwards", *each) for each in shown)]
    examples = tuple(
        Example(number, state, (meters,), following, kind)
        for number, (state, meters, following, kind) in enumerate(rows, 1)
    )
    taught = replace(lesson, examples=examples)
    return ROBOTS.with_automaton(TrainedAutomaton(learn_automaton(taught), taught))


@pytest.mark.parametrize(
    "way", [{}, {"metrics": ["sonar_front_left"]}, {"metrics": {"zero": lambda run: 0.0}}]
)
def test_robots_that_drive_past_later_change_nothing(way: dict[str, Any]) -> None:
    """The first robot that has raised the flag waits, and others come and go before it until the world ends."""
    found = evaluate(teach_obstacles(), "roam", SCENARIO, range(500, 510), **way).raised
    assert found is not None
    assert found.raised.any()
    assert found.elsewhere == 0
    assert np.nanmax(found.values) < 1.1


def test_worlds_in_processes_are_joined() -> None:
    library = teach_distances(0.1, 0.2, 0.3, beside=0.5)
    parts = [evaluate(library, "goto", FORAGE, seeds, binding=STATION) for seeds in ([5, 6], [7])]
    whole = evaluate(library, "goto", FORAGE, [5, 6, 7], binding=STATION)
    assert whole.raised is not None
    values = [each.raised.values for each in parts if each.raised is not None]
    assert np.array_equal(np.concatenate(values), whole.raised.values)


@pytest.mark.parametrize(("beside", "elsewhere"), [(0.5, 0), (0.05, 10)])
def test_eval_prints_it(tmp_path: Path, beside: float, elsewhere: int) -> None:
    presses = (0.1, 0.2, 0.3) if elsewhere == 0 else (0.01, 0.02, 0.03)
    for taught in teach_distances(*presses, beside=beside).taught.values():
        save_automaton(tmp_path, taught)
    arguments = ("eval", "-l", tmp_path, "--behavior", "goto", "--bind", "A=station", "--seeds", "5:15")
    found = run_json(*arguments)
    assert found["raised"]["feature"] == "distance_to(A)"
    assert found["raised"]["elsewhere"] == elsewhere
    text = run(*arguments)
    assert found["raised"]["text"] in text.stdout
    both = run(*arguments, "--against-behavior", "goto").stdout
    assert both.count(found["raised"]["text"]) == 3, "of the first alone, and of both"


def test_what_was_shown_is_offered_as_a_condition_and_can_be_tested() -> None:
    """It holds where done is raised nearer than 0.5 m, and fails where that is to be nearer than 0.05 m."""
    for presses, beside, failures in (((0.1, 0.2, 0.3), 0.5, 0), ((0.01, 0.02, 0.03), 0.05, 5)):
        library = teach_distances(*presses, beside=beside)
        first = list_condition_examples(World(FORAGE, [0]), library, ["done"], "goto")[0]
        assert first == ConditionExample(
            "As it was shown", f"done is raised and distance_to(A) is below {beside} m"
        )
        subject = Property(
            kind=PropertyKind.ALWAYS,
            what=first.text,
            seconds=60.0,
            start=SeededWorlds("forage", tuple(SEEDS[:5])),
            behavior="goto",
            targets=Binding(STATION),
        )
        assert run_property(subject, library, FORAGE).failures == failures
