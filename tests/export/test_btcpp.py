"""Trees for BehaviorTree.CPP: they decide as the interpreter in the library itself, in Python and in C++."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
from tests.export.exports import draw_job, open_fixture, write_job
from tests.export.recorded_answers import Ask
from tests.export.test_translation import prepare

from understudy.addons.export.body_interface import BodyInterface
from understudy.addons.export.export_automaton import export_automaton
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import Behavior, Command
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Kit, Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Continuous
from understudy.runtime.body import Channel, Reading

PYTHON, CPP = "behaviortreepy", "behaviortree-cpp"
BUILT_IN = {
    "AlwaysFailure", "AlwaysSuccess", "IfThenElse", "ReactiveSequence", "Script", "ScriptCondition", "Sequence",
    "SubTree", *(f"Switch{cases}" for cases in range(2, 7)),
}  # fmt: skip


def export_forager(folder: Path) -> tuple[Path, int]:
    library, body = open_fixture()
    result = export_automaton(library, "forage", folder / "out", to="btcpp", body=body)
    return folder / "out", result.ticks


@pytest.mark.parametrize("peer", [PYTHON, CPP])
def test_the_forager_runs_in_behavior_tree_cpp(peer: str, ask: Ask, tmp_path: Path) -> None:
    folder, ticks = export_forager(tmp_path)
    assert ask(peer, folder).counts == (ticks, 0)


@pytest.mark.parametrize(("peer", "seed"), [*((PYTHON, seed) for seed in range(6)), (CPP, 0)])
def test_trees_decide_as_the_interpreter(peer: str, seed: int, ask: Ask, tmp_path: Path) -> None:
    job = draw_job(seed, to="btcpp")
    assert ask(peer, write_job(tmp_path, job, to="btcpp")).counts == (len(job.conformance.ticks), 0)


@pytest.mark.parametrize("peer", [PYTHON, CPP])
def test_translated_functions_compute_the_same(peer: str, ask: Ask, tmp_path: Path) -> None:
    job = prepare("btcpp")
    assert ask(peer, write_job(tmp_path, job, to="btcpp")).counts == (len(job.conformance.ticks), 0)


def draw_chain(states: int) -> tuple[Library, BodyInterface]:
    """An automaton that goes through many states and back to the first."""
    feature = Feature("speed", Continuous(), "speed")
    names = [f"s{index}" for index in range(1, states)]
    trees = {
        name: Tree(
            (
                Node(TestKind.BELOW, 0, high=0.5, yes=1, no=2, absent=2),
                make_leaf(index),
                make_leaf((index + 1) % states),
            )
        )
        for index, name in enumerate(["start", *names])
    }
    automaton = Automaton(
        "chain",
        (START, *(State(name, "go") for name in names)),
        (BoundFeature(feature),),
        transitions=trees,
    )
    library = Library.from_automata(Kit.from_parts(feature, Behavior("go", Command(drive=1.0))), automaton)
    return library, BodyInterface((Reading("speed", Continuous()),), (Channel("drive"),))


@pytest.mark.parametrize("states", [1, 2, 6, 7, 8, 13, 14])
def test_automata_may_have_more_states_than_a_switch_has_cases(states: int, ask: Ask, tmp_path: Path) -> None:
    library, body = draw_chain(states)
    result = export_automaton(library, "chain", tmp_path, to="btcpp", body=body)
    assert ask(PYTHON, tmp_path).counts == (result.ticks, 0)


def test_editors_know_every_node_with_its_ports(tmp_path: Path) -> None:
    folder, _ = export_forager(tmp_path)
    root = ElementTree.parse(folder / "forage.xml").getroot()
    assert root.get("BTCPP_format") == "4"
    trees = {tree.get("ID"): tree for tree in root.iter("BehaviorTree")}
    assert set(trees) >= {root.get("main_tree_to_execute"), "forage", "harvest", "goto_station"}
    models = root.find("TreeNodesModel")
    assert models is not None
    ports = {model.get("ID"): {port.get("name") for port in model} for model in models}
    used = [node for tree in trees.values() for node in tree.iter() if node is not tree]
    for node in used:
        if node.tag == "SubTree":
            assert node.get("ID") in trees
        elif node.tag not in BUILT_IN:
            assert set(node.attrib) - {"name"} == ports[node.tag]
    assert {"forward", "rotate_left", "IsInArc", "IsBelow"} <= {node.tag for node in used}


def test_a_name_that_is_one_of_the_library_is_made_another(ask: Ask, tmp_path: Path) -> None:
    """A behavior called like a built-in node, a channel like an attribute, a reading like a key of the export."""
    kit = Kit.from_parts(Feature("f", Continuous(), "now"), Behavior("Sequence", Command(name=1.0)))
    tree = Tree((Node(TestKind.BELOW, 0, high=0.5, yes=1, no=2, absent=2), make_leaf(0), make_leaf(1)))
    feature = BoundFeature(kit.features["f"])
    states = (START, State("速い 'x' <b>", "Sequence"), State("遅い", "Sequence"))
    automaton = Automaton(
        "Script", states, (feature,), transitions=dict.fromkeys(["start", states[1].name], tree)
    )
    body = BodyInterface((Reading("now", Continuous()),), (Channel("name"),))
    result = export_automaton(
        Library.from_automata(kit, automaton), "Script", tmp_path, to="btcpp", body=body
    )
    assert ask(PYTHON, tmp_path).counts == (result.ticks, 0)
