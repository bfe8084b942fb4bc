"""Lessons with very large trees: each target writes them, or refuses them in one sentence before it writes anything."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from tests.export.exports import FIXTURE
from tests.ui.cli.commands import run

from understudy.addons.export import export_size
from understudy.addons.export.body_interface import BodyInterface
from understudy.addons.export.decisions import make_routines
from understudy.addons.export.export_automaton import export_automaton
from understudy.addons.export.export_size import measure_rules
from understudy.addons.export.targets import target_table
from understudy.errors import DefinitionError
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import Behavior, Command
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Kit, Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Categorical, Continuous
from understudy.runtime.body import Channel, Reading

X = Feature("x", Continuous(), "x")
BODY = BodyInterface((Reading("x", Continuous()),), (Channel("drive"),))
GO = Behavior("go", Command(drive=1.0))


def split_evenly(leaves: int) -> Tree:
    """A tree with that many leaves, along one feature."""
    nodes: list[Node] = []

    def add(first: int, stop: int) -> int:
        at = len(nodes)
        nodes.append(make_leaf(1 + first % 2))
        if stop - first > 1:
            middle = (first + stop) // 2
            yes, no = add(first, middle), add(middle, stop)
            nodes[at] = Node(TestKind.BELOW, 0, high=float(middle), yes=yes, no=no, absent=no)
        return at

    add(0, leaves)
    return Tree(tuple(nodes))


def split_off(depth: int) -> Tree:
    """A tree in which each question is asked where the one before was answered with yes."""
    nodes: list[Node] = []
    for level in range(depth):
        yes, no = 2 * level + 2, 2 * level + 1
        nodes += [Node(TestKind.BELOW, 0, high=float(depth - level), yes=yes, no=no, absent=no), make_leaf(1)]
    return Tree((*nodes, make_leaf(2)))


def make_library(tree: Tree, *, sharing: int = 1) -> Library:
    """An automaton in which that many states decide with a tree, and one that runs it in two states."""
    states = (START, *(State(f"s{index}", "go") for index in range(max(2, sharing))))
    trees = {state.name: tree for state in states[:sharing]}
    inner = Automaton("a", states, (BoundFeature(X),), transitions=trees)
    outer = Automaton(
        "b",
        (START, State("one", "a"), State("two", "a")),
        transitions={"start": Tree((make_leaf(1),)), "one": Tree((make_leaf(2),))},
    )
    return Library.from_automata(Kit.from_parts(X, GO), inner, outer)


def make_labels(count: int) -> Library:
    """An automaton that asks for each of many labels."""
    kind = Categorical(tuple(f"l{index}" for index in range(count)))
    color = Feature("color", kind, "color")
    node = Node(TestKind.LABEL, 0, absent=count + 1, branches=tuple(range(1, count + 1)))
    leaves = [make_leaf(1 + index % 2) for index in range(count + 1)]
    states = (START, State("one", "go"), State("two", "go"))
    trees = {"start": Tree((node, *leaves))}
    automaton = Automaton("a", states, (BoundFeature(color),), transitions=trees)
    return Library.from_automata(Kit.from_parts(color, GO), automaton)


def export(library: Library, name: str, folder: Path, to: str, body: BodyInterface = BODY) -> dict[str, int]:
    return dict(export_automaton(library, name, folder / "out", to=to, body=body).files)


def test_the_command_says_so_and_exits_with_2(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("understudy.addons.export.statechart.MOST_RULES", 20)
    out = tmp_path / "out"
    result = run("export", "forage", "--library", FIXTURE, "--to", "scxml", "--out", out)
    assert result.exit_code == 2
    assert "transitions, since every use" in " ".join(result.stderr.split())
    assert not out.exists()


TARGETS = [each for each in target_table.TARGETS if each != "ros2"]  # whose decisions are those of c99


@pytest.mark.parametrize("to", TARGETS)
def test_some_thousand_leaves_are_written(to: str, tmp_path: Path) -> None:
    assert max(export(make_library(split_evenly(3000)), "b", tmp_path, to).values()) > 100_000


SHARED = split_evenly(100)
LARGE: list[tuple[str, Library, str, str]] = [  # target, library, name, what there is too much of
    ("scxml", make_library(SHARED, sharing=200), "a", "a statechart it has 20001 transitions"),
    ("xstate", make_library(SHARED, sharing=200), "b", "a statechart it has 40005 transitions"),
    ("btcpp", make_library(SHARED, sharing=200), "b", "a behavior tree it has 40005 ends of decisions"),
    ("btcpp", make_library(split_evenly(10_001)), "b", "a behavior tree it has 20009 ends of decisions"),
    ("scxml", make_library(split_off(1000)), "a", r"a statechart it has \d+\.\d MiB of conditions"),
    ("xstate", make_library(split_off(3000)), "b", r"a statechart it has \d+ MiB of conditions"),
]


@pytest.mark.parametrize(("to", "library", "name", "has"), LARGE)
def test_what_would_be_too_large_is_refused(
    to: str, library: Library, name: str, has: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With lower limits than those of today, so that it takes less long."""
    for module in ("statechart", "targets.btcpp_tree"):
        monkeypatch.setattr(f"understudy.addons.export.{module}.MOST_RULES", 20_000)
    monkeypatch.setattr("understudy.addons.export.statechart.MOST_BYTES", 2**20)
    with pytest.raises(DefinitionError, match=f"automaton '{name}': as {has}.*; at most .* export it to c99"):
        export(library, name, tmp_path, to)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("to", ["c99", "python"])
def test_what_is_said_instead_can_be_done(to: str, tmp_path: Path) -> None:
    files = export(make_library(SHARED, sharing=200), "b", tmp_path, to)
    assert sum(files.values()) < 2**21


@pytest.mark.parametrize("to", TARGETS)
def test_many_labels(to: str, tmp_path: Path) -> None:
    library = make_labels(600)
    body = replace(BODY, readings=(Reading("color", library.kit.features["color"].kind),))
    if to == "btcpp":
        with pytest.raises(
            DefinitionError, match=r"600 questions in one another, .* at most 200 are written"
        ):
            export(library, "a", tmp_path, to, body)
    else:
        export(library, "a", tmp_path, to, body)


@pytest.mark.parametrize(("to", "module"), [("scxml", "scxml"), ("xstate", "xstate"), ("btcpp", "btcpp")])
def test_a_document_of_too_many_bytes(
    to: str, module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What its conditions do not tell: names can be long."""
    monkeypatch.setattr(export_size, "MOST_BYTES", 2**17)
    with pytest.raises(DefinitionError, match=r"it has \d+\.\d MiB; at most 0\.1 MiB are written"):
        export(make_library(split_evenly(3000)), "a", tmp_path, to)


def count_rules(node: int, tree: Tree, depth: int = 0) -> list[int]:
    """The questions that hold on the way to each answer, without counting those that do not hold."""
    if tree.nodes[node].test == TestKind.LEAF:
        return [depth]
    at = tree.nodes[node]
    return [*count_rules(at.yes, tree, depth + 1), *count_rules(at.no, tree, depth)]


@pytest.mark.parametrize("tree", [split_evenly(1), split_evenly(37), split_off(35), split_evenly(4096)])
def test_rules_are_counted(tree: Tree) -> None:
    routines = make_routines(tree, lambda feature: False)
    counted: Any = measure_rules(routines, lambda condition: 1)
    rules = count_rules(0, tree)
    assert (counted.rules, counted.weight) == (len(rules), sum(rules))
    assert counted.nested <= 10
