"""Python functions of features and behaviors: simple arithmetic is translated, anything else is said."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.export.exports import (
    count_mismatches,
    load_python,
    make,
    read_counts,
    write_job,
)
from tests.export.recorded_answers import Ask

from understudy.addons.export.body_interface import BodyInterface
from understudy.addons.export.export_automaton import export_automaton, prepare_export
from understudy.addons.export.expressions import Number, Operation, ReadingValue, translate_function
from understudy.addons.export.target_files import ExportJob
from understudy.errors import FileError
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import behavior
from understudy.model.binding import Binding, Target
from understudy.model.features import BoundFeature, feature
from understudy.model.library import Kit, Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import BOOLEAN, Continuous, Toroidal
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
    job = prepare_export(
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
def test_translated_functions_compute_the_same_in_c(single: bool, ask: Ask, tmp_path: Path) -> None:
    job = prepare("c99", single=single)
    assert ask("gcc", write_job(tmp_path, job, to="c99")).counts == (len(job.conformance.ticks), 0)


def test_translated_functions_compute_the_same_in_the_reader(ask: Ask, tmp_path: Path) -> None:
    ticks, mismatches = ask("node", write_job(tmp_path, prepare("json"), to="json")).counts
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


DOUBLE = np.float64(0.1)
SINGLE = np.float32(0.1)


@feature(Continuous())
def scaled(robot: Any) -> Any:
    """Speed by a number of NumPy in double precision."""
    return robot.speed * DOUBLE


@feature(Continuous())
def rooted(robot: Any) -> Any:
    """Speed by a number that NumPy computes in double precision."""
    return robot.speed * np.sqrt(2.0) + np.where(robot.speed < 1.0, 0.1, 0.2)


@feature(Continuous())
def single(robot: Any) -> Any:
    """Speed by a number of NumPy in single precision."""
    return robot.speed * SINGLE


@behavior
def follow(robot: Any) -> Any:
    """Command a number of NumPy's."""
    return {"drive": robot.speed * DOUBLE / 3.0 - SINGLE}


@pytest.mark.parametrize("is_single", [False, True], ids=["double", "single"])
@pytest.mark.parametrize("computed", [scaled, rooted, single], ids=lambda each: str(each.name))
def test_numbers_of_numpy_compute_the_same_in_c(
    computed: Any, is_single: bool, ask: Ask, tmp_path: Path
) -> None:
    kit = Kit.from_parts(scaled, rooted, single, follow)
    tree = Tree((Node(TestKind.BELOW, 0, high=0.3, yes=1, no=2, absent=1), make_leaf(0), make_leaf(1)))
    states = (START, State("follow", "follow"))
    automaton = Automaton("a", states, (BoundFeature(computed),), transitions={"start": tree, "follow": tree})
    body = BodyInterface((Reading("speed", Continuous()),), (Channel("drive"),))
    job = prepare_export(
        Library.from_automata(kit, automaton),
        "a",
        to="c99",
        binding={},
        body=body,
        fingerprint="drawn",
        single_precision=is_single,
    )
    assert job.hierarchy.functions_to_write == ()
    assert ask("gcc", write_job(tmp_path, job, to="c99")).counts == (len(job.conformance.ticks), 0)


def _singles(robot: Any) -> Any:
    return robot.speed * (SINGLE * 3.0)


def test_constants_that_python_computes_in_single_precision_are_refused() -> None:
    """In double precision 3 times 0.1 would be another number."""
    assert translate_function(_singles, ()).problem.startswith("'SINGLE * 3.0' is not simple arithmetic")


def test_constants_are_computed_in_double_precision_as_python_does() -> None:
    """In single precision 180 divided by pi would be another number."""
    found = translate_function(_degrees, ()).results[""]
    assert found == Operation("*", (ReadingValue("speed", None), Number(180.0 / math.pi)))


@behavior
def wander(robot: Any) -> Any:
    """Do something else."""
    return {"drive": np.cumsum(robot.speed)}


WANDERING = Library.from_automata(
    Kit.from_parts(*KIT.parts, wander),
    Automaton("a", (START, State("wander", "wander")), transitions={"start": Tree((make_leaf(1),))}),
)
PEERS = {"c99": "gcc", "btcpp": "behaviortreepy"}
WRITTEN = {
    "c99": ("a_functions.h", "(?m)^#error.*$", "    commands->drive = r->speed;"),
    "python": (
        "a_functions.py",
        r"(?ms)^raise NotImplementedError.*?$(.*)pass .*",
        r"\1command['drive'] = r['speed']",
    ),
    "btcpp": ("a_functions.py", r"(?ms)^raise NotImplementedError.*?$(.*)pass", r"\1return {'drive': speed}"),
}
"""By target: the file of functions to write, and a pattern with what a person writes in its place."""


@pytest.mark.parametrize("to", PEERS)
def test_a_behavior_to_write_runs_once_it_is_written_and_is_kept(to: str, ask: Ask, tmp_path: Path) -> None:
    export_automaton(WANDERING, "a", tmp_path, to=to, body=BODY)
    assert not ask(PEERS[to], tmp_path, finds=r"#error|NotImplementedError").succeeded
    name, stub, by_hand = WRITTEN[to]
    written = re.sub(stub, by_hand, (tmp_path / name).read_text())
    (tmp_path / name).write_text(written)
    assert ask(PEERS[to], tmp_path).counts[1] == 0
    for _ in range(2):
        result = export_automaton(WANDERING, "a", tmp_path, to=to, body=BODY)
        assert (tmp_path / name).read_text() == written
        assert result.files[name] == len(written.encode())
        assert ask(PEERS[to], tmp_path).counts[1] == 0


def test_a_behavior_to_write_in_python_runs_once_it_is_written(tmp_path: Path) -> None:
    out = tmp_path / "out"
    export_automaton(WANDERING, "a", out, to="python", body=BODY)
    with pytest.raises(AssertionError, match="NotImplementedError"):
        make(out, "test", PYTHON=sys.executable)
    name, stub, by_hand = WRITTEN["python"]
    written = re.sub(stub, by_hand, (out / name).read_text())
    (out / name).write_text(written)
    result = export_automaton(WANDERING, "a", out, to="python", body=BODY)
    assert (out / name).read_text() == written
    assert result.files[name] == len(written.encode())
    assert read_counts(make(out, "test", PYTHON=sys.executable))[1] == 0


def test_a_changed_function_is_compiled_again(ask: Ask, tmp_path: Path) -> None:
    export_automaton(WANDERING, "a", tmp_path, to="c99", body=BODY)
    name, stub, by_hand = WRITTEN["c99"]
    written = re.sub(stub, by_hand, (tmp_path / name).read_text())
    (tmp_path / name).write_text(written)
    (tmp_path / "changed").write_text(written.replace("r->speed", "r->speed + 1.0"))
    change = f"cp changed {name} && touch -d @{2**31} {name}"
    command = ("sh", "-c", f"make test CC=gcc && {change} && make test CC=gcc")
    answer = ask(
        "gcc", tmp_path, command=command, finds=r"\d+ ticks, 0 mismatches|line 2 .* is decided otherwise"
    )
    assert not answer.succeeded
    assert [line.split()[2:] for line in answer.said.splitlines()] == [
        ["0", "mismatches"],
        ["of", "conformance.csv", "is", "decided", "otherwise"],
    ]


def test_the_reader_refuses_a_behavior_to_write(ask: Ask, tmp_path: Path) -> None:
    export_automaton(WANDERING, "a", tmp_path, to="json", body=BODY)
    assert not ask(
        "node", tmp_path, finds="wander is computed by code that could not be translated"
    ).succeeded


def test_an_export_without_the_written_functions_is_refused(tmp_path: Path) -> None:
    """A file as it was exported has nothing to lose."""
    export_automaton(WANDERING, "a", tmp_path, to="c99", body=BODY)
    export_automaton(WANDERING, "a", tmp_path, to="python", body=BODY)
    (tmp_path / "a_functions.py").write_text("mine")
    with pytest.raises(FileError, match=r"a_functions\.py has functions that you wrote"):
        export_automaton(WANDERING, "a", tmp_path, to="c99", body=BODY)
    assert (tmp_path / "a_functions.py").read_text() == "mine"


def test_a_written_file_gets_the_functions_that_it_lacks(tmp_path: Path) -> None:
    export_automaton(WANDERING, "a", tmp_path, to="c99", body=BODY)
    (tmp_path / "a_functions.h").write_text("/* mine */\n")
    export_automaton(WANDERING, "a", tmp_path, to="c99", body=BODY)
    for name in ("a_functions.h", "arduino/a/a_functions.h"):
        text = (tmp_path / name).read_text()
        assert text.startswith("/* mine */\n")
        assert "behavior_wander" in text


def test_a_function_to_write_does_not_compile_and_is_listed(ask: Ask, tmp_path: Path) -> None:
    library = draw(BoundFeature(strange), nodes=(Node(TestKind.BELOW, 0, high=0.5, yes=2, no=1, absent=1),))
    result = export_automaton(library, "a", tmp_path / "c", to="c99", body=BODY)
    assert [(name, readings) for name, readings, _ in result.untranslated] == [
        ("feature strange", ("speed",))
    ]
    finds = '#error "feature strange of speed could not be translated'
    assert not ask("gcc", tmp_path / "c", finds=finds).succeeded
    export_automaton(library, "a", tmp_path / "python", to="python", body=BODY)
    with pytest.raises(AssertionError, match="NotImplementedError: feature strange of speed could not be"):
        make(tmp_path / "python", "test")
