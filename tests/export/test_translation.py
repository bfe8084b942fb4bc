"""Python functions of features and behaviors: simple arithmetic is translated, anything else is said."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.export.exports import count_mismatches, load_python, make, need, read_counts, write_job

from understudy.export.body_interface import BodyInterface
from understudy.export.export_automaton import export_automaton, prepare_export
from understudy.export.expressions import Number, Operation, ReadingValue, translate_function
from understudy.export.target_files import ExportJob
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import behavior
from understudy.model.binding import Binding, Target
from understudy.model.features import BoundFeature, feature
from understudy.model.kinds import BOOLEAN, Continuous, Toroidal
from understudy.model.library import Kit, Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.runtime.body import Channel, Reading

RADIUS = 0.1


@feature(Continuous(), unit="m")
def gap(robot: Any, target: Any) -> Any:
    """Distance to the target's rim."""
    limited = np.minimum(target.distance, 5.0)
    return np.where(np.isnan(limited), -1.0, limited - RADIUS)


@feature(Toroidal())
def behind(robot: Any, target: Any) -> Any:
    """Direction opposite to the target."""
    return target.bearing + math.pi


@feature(BOOLEAN)
def near(robot: Any, target: Any) -> Any:
    """Whether the target is near for its speed."""
    return target.distance / abs(robot.speed) < 2.0


@feature(Continuous())
def strange(robot: Any) -> Any:
    """Something else."""
    return np.cumsum(robot.speed)


@behavior
def approach(robot: Any, target: Any) -> Any:
    """Drive to the target, slower when near."""
    return {"drive": 0.5 * np.maximum(target.distance, 0.0) / 3.0 - np.sqrt(abs(robot.speed)), "turn": -0.25}


KIT = Kit.from_parts(gap, behind, near, strange, approach, Target("ball"))
BODY = BodyInterface(
    (
        Reading("distance", Continuous(), "m", of_targets=True),
        Reading("bearing", Toroidal(), "rad", of_targets=True),
        Reading("speed", Continuous()),
    ),
    (Channel("drive"), Channel("turn", 0.125)),
)
TO_BALL = Binding(target="ball")


def draw(*features: BoundFeature, nodes: tuple[Node, ...]) -> Library:
    """A library whose automaton approaches the ball, or not, by these features."""
    leaves = (make_leaf(0), make_leaf(1))
    tree = Tree((*nodes, *leaves))
    states = (START, State("approach", "approach", TO_BALL))
    automaton = Automaton("a", states, features, transitions={"start": tree, "approach": tree})
    return Library.from_automata(KIT, automaton)


LIBRARY = draw(
    BoundFeature(gap, TO_BALL),
    BoundFeature(behind, TO_BALL),
    BoundFeature(near, TO_BALL),
    nodes=(
        Node(TestKind.BELOW, 0, high=0.9, yes=4, no=1, absent=3),
        Node(TestKind.ARC, 1, 5.0, 1.0, 4, 2, 3),
        Node(TestKind.LABEL, 2, branches=(3, 4), absent=3),
    ),
)


def prepare(to: str, *, single: bool = False) -> ExportJob:
    job, _ = prepare_export(
        LIBRARY, "a", to=to, binding={}, body=BODY, fingerprint="drawn", single_precision=single
    )
    assert job.hierarchy.functions_to_write == ()
    return job


def test_translated_functions_compute_the_same_in_python() -> None:
    job = prepare("python")
    ticks, mismatches = count_mismatches(load_python(job), job)
    assert ticks > 100
    assert mismatches == 0


@pytest.mark.parametrize("single", [False, True], ids=["double", "single"])
def test_translated_functions_compute_the_same_in_c(single: bool, tmp_path: Path) -> None:
    need("gcc")
    job = prepare("c99", single=single)
    assert read_counts(make(write_job(tmp_path, job, to="c99"), "test")) == (len(job.conformance.ticks), 0)


def test_translated_functions_compute_the_same_in_the_reader(tmp_path: Path) -> None:
    need("node")
    folder = write_job(tmp_path, prepare("json"), to="json")
    ticks, mismatches = read_counts(make(folder, "test"))
    assert ticks > 100
    assert mismatches == 0


def _loops(robot: Any) -> Any:
    for _ in range(3):
        pass
    return robot.speed


def _branches(robot: Any) -> Any:
    return robot.speed if robot.speed > 0 else 0.0


def _sums(robot: Any) -> Any:
    return np.sum(robot.speed)


def _mixes(robot: Any) -> Any:
    return (robot.speed > 0.0) + 1.0


def _made(value: float) -> Any:
    return lambda robot: robot.speed + value


def _double(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    @wraps(function)
    def doubled(robot: Any) -> Any:
        return 2.0 * function(robot)

    return doubled


@_double
def _doubled(robot: Any) -> Any:
    return robot.speed


def _enclosed(RADIUS: float) -> Callable[[Any], Any]:
    def function(robot: Any) -> Any:
        return robot.speed + RADIUS

    return function


def _defaults(robot: Any, RADIUS: float = 3.0) -> Any:
    return robot.speed + RADIUS


def _divides_by_nothing(robot: Any) -> Any:
    return robot.speed + 1.0 / 0.0


REFUSED = [
    (_doubled, "it is wrapped in another function"),
    (_enclosed(7.0), "'RADIUS' is not simple arithmetic"),
    (_defaults, "'RADIUS' is not simple arithmetic"),
    (_divides_by_nothing, "'1.0 / 0.0' is not simple arithmetic"),
    (_loops, "'for _ in range(3): pass' is not simple arithmetic"),
    (_branches, "'robot.speed if robot.speed > 0 else 0.0' is not simple arithmetic"),
    (_sums, "'np.sum(robot.speed)' is not simple arithmetic"),
    (_mixes, "'robot.speed > 0.0' is not simple arithmetic"),
    (_made(1.0), "it is not a plain function"),
    (math.sin, "its source text is not available"),
]


@pytest.mark.parametrize(("function", "problem"), REFUSED)
def test_what_is_no_simple_arithmetic_is_refused(function: Any, problem: str) -> None:
    found = translate_function(function, ())
    assert found.results == {}
    assert found.problem.startswith(problem)


def _degrees(robot: Any) -> Any:
    return robot.speed * (180.0 / math.pi)


def test_constants_are_computed_in_double_precision_as_python_does() -> None:
    """In single precision 180 divided by pi would be another number."""
    found = translate_function(_degrees, ()).results[""]
    assert found == Operation("*", (ReadingValue("speed", None), Number(180.0 / math.pi)))


@behavior
def wander(robot: Any) -> Any:
    """Do something else."""
    return {"drive": np.cumsum(robot.speed)}


def test_a_behavior_to_write_runs_once_it_is_written(tmp_path: Path) -> None:
    need("gcc", "node")
    kit = Kit.from_parts(*KIT.parts, wander)
    tree = Tree((make_leaf(1),))
    automaton = Automaton("a", (START, State("wander", "wander")), transitions={"start": tree})
    library = Library.from_automata(kit, automaton)
    export_automaton(library, "a", tmp_path / "c", to="c99", body=BODY)
    with pytest.raises(AssertionError, match="#error"):
        make(tmp_path / "c", "test")
    source = tmp_path / "c" / "a.c"
    source.write_text(re.sub("(?m)^#error.*$", "commands->drive = r->speed;", source.read_text()))
    assert read_counts(make(tmp_path / "c", "test"))[1] == 0
    export_automaton(library, "a", tmp_path / "python", to="python", body=BODY)
    module = tmp_path / "python" / "a.py"
    text = re.sub("(?m)^raise NotImplementedError.*$", "", module.read_text())
    module.write_text(text.replace("pass  # set", "command['drive'] = r['speed']  # set"))
    assert read_counts(make(tmp_path / "python", "test"))[1] == 0
    export_automaton(library, "a", tmp_path / "json", to="json", body=BODY)
    with pytest.raises(AssertionError, match="wander is computed by code that could not be translated"):
        make(tmp_path / "json", "test")


def test_a_function_to_write_does_not_compile_and_is_listed(tmp_path: Path) -> None:
    need("gcc")
    library = draw(BoundFeature(strange), nodes=(Node(TestKind.BELOW, 0, high=0.5, yes=2, no=1, absent=1),))
    result = export_automaton(library, "a", tmp_path / "c", to="c99", body=BODY)
    assert [(name, readings) for name, readings, _ in result.untranslated] == [
        ("feature strange", ("speed",))
    ]
    with pytest.raises(AssertionError, match='#error "feature strange of speed could not be translated'):
        make(tmp_path / "c", "test")
    export_automaton(library, "a", tmp_path / "python", to="python", body=BODY)
    with pytest.raises(AssertionError, match="NotImplementedError: feature strange of speed could not be"):
        make(tmp_path / "python", "test")
