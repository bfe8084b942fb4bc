"""Statecharts decide as the interpreter, in interpreters of statecharts that differ from each other."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from tests.export import test_memory, test_translation
from tests.export.exports import draw_job, open_fixture, write_job
from tests.export.recorded_answers import Ask, hash_text
from tests.export.test_odd_names import export as export_with_names

from understudy.addons.export.body_interface import ORDER_CHANNELS, BodyInterface
from understudy.addons.export.conformance import Conformance
from understudy.addons.export.export_automaton import export_automaton, prepare_export
from understudy.addons.export.statechart import MOST_STATES
from understudy.addons.export.target_files import ExportJob
from understudy.errors import DefinitionError, FileError
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import Behavior, Command
from understudy.model.features import BoundFeature, Feature, FlagFeature
from understudy.model.library import Kit, Library
from understudy.model.squad import Assignment, Order
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Continuous
from understudy.runtime.body import Channel, Reading

RUNNERS = {"scion": "scxml", "qt": "scxml", "xstate": "xstate"}
"""What runs the statecharts of which target."""
TICKS_IN_QT = 1200
"""Of more rows, Qt runs only the first: it takes up to a millisecond for a tick."""


def check(ask: Ask, folder: Path, job: ExportJob, runner: str) -> None:
    """Check that the export of a job decides as the interpreter."""
    if runner == "qt":
        ticks = job.conformance.ticks[:TICKS_IN_QT]
        job = replace(job, conformance=Conformance(ticks, 0, (0, 0), (0, 0)))
    write_job(folder, job, to=RUNNERS[runner])
    assert ask(runner, folder).counts == (len(job.conformance.ticks), 0)


@pytest.mark.parametrize("runner", RUNNERS)
def test_the_forager(runner: str, ask: Ask, tmp_path: Path) -> None:
    library, body = open_fixture()
    result = export_automaton(library, "forage", tmp_path, to=RUNNERS[runner], body=body)
    assert ask(runner, tmp_path).counts == (result.ticks, 0)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("runner", RUNNERS)
def test_random_libraries(runner: str, seed: int, ask: Ask, tmp_path: Path) -> None:
    check(ask, tmp_path, draw_job(seed, to=RUNNERS[runner]), runner)


@pytest.mark.parametrize("stateless", [False, True], ids=["by state", "stateless"])
@pytest.mark.parametrize("runner", RUNNERS)
def test_counters_and_timers(runner: str, stateless: bool, ask: Ask, tmp_path: Path) -> None:
    check(ask, tmp_path, test_memory.prepare(RUNNERS[runner], stateless=stateless), runner)


@pytest.mark.parametrize("runner", RUNNERS)
def test_translated_functions(runner: str, ask: Ask, tmp_path: Path) -> None:
    """Commands that are computed follow the readings of every tick, not only of that of the entry."""
    check(ask, tmp_path, test_translation.prepare(RUNNERS[runner]), runner)


@pytest.mark.parametrize("runner", RUNNERS)
def test_orders_of_a_coordinator(runner: str, ask: Ask, tmp_path: Path) -> None:
    """An order is issued in one tick, and stands until the next."""
    target = RUNNERS[runner]
    gather = Feature("gathered", Continuous(), "share", fresh=0.0)
    orders = [Behavior(name, order=Order((Assignment(name),))) for name in ("gather", "leave")]
    states = (START, State("gather", "gather"), State("leave", "leave"), State("done", flag="done"))
    tree = Tree((
        Node(TestKind.BELOW, 0, high=0.5, yes=2, no=1, absent=4),
        Node(TestKind.BELOW, 0, high=2.0, yes=3, no=4, absent=3),
        *map(make_leaf, (1, 2, 3)),
    ))  # fmt: skip
    automaton = Automaton(
        "a",
        states,
        (BoundFeature(gather),),
        transitions={"start": tree, "gather": tree, "leave": tree},
    )
    body = BodyInterface((Reading("share", Continuous()),), ORDER_CHANNELS)
    library = Library.from_automata(Kit.from_parts(gather, *orders), automaton)
    job = prepare_export(library, "a", to=target, binding={}, body=body, fingerprint="drawn")
    assert {tick.expected.commands[1] for tick in job.conformance.ticks} == {0.0, 1.0}
    check(ask, tmp_path, job, runner)


NAMES = [
    {"name": "failed"},
    {"name": 'say "hi" & <b> ]]>'},
    {"name": "constructor"},
    {"state": "to.String('"},
    {"reading": "now"},
    {"reading": "a<b && c"},
    {"channel": "left,wheel"},
    {"behavior": "idle"},
    {"labels": ('a"', "b-->", "c")},
]


@pytest.mark.parametrize("names", NAMES, ids=str)
@pytest.mark.parametrize("runner", ["scion", "xstate"])
def test_odd_names(names: dict[str, str], runner: str, ask: Ask, tmp_path: Path) -> None:
    folder = export_with_names(tmp_path, RUNNERS[runner], **names)  # type: ignore[arg-type]
    assert ask(runner, folder).counts[1] == 0


def test_the_configuration_is_a_machine_without_its_module(ask: Ask, tmp_path: Path) -> None:
    """As visualizers take it; its innermost states are those that the numbers are given of."""
    library, body = open_fixture()
    export_automaton(library, "forage", tmp_path, to="xstate", body=body)
    program = """
        import { readFileSync, writeFileSync } from "node:fs";
        import { createMachine } from "xstate";
        const list = (node) => Object.values(node.states).flatMap((each) => [each, ...list(each)]);
        const nodes = list(createMachine(JSON.parse(readFileSync("machine.json", "utf8"))).root);
        const innermost = nodes.filter(({ states }) => !Object.keys(states).length).map(({ id }) => id);
        writeFileSync("innermost.json", JSON.stringify(innermost.sort()));
    """
    command = ("node", "--input-type=module", "--eval", program)
    answer = ask("xstate", tmp_path, command=command, hashes="innermost.json")
    described = json.loads((tmp_path / "states.json").read_bytes())
    assert answer.said == hash_text(json.dumps(sorted(described["states"]), separators=(",", ":")).encode())


@pytest.mark.parametrize("runner", RUNNERS)
def test_a_function_to_write_runs_once_it_is_written(runner: str, ask: Ask, tmp_path: Path) -> None:
    target = RUNNERS[runner]
    kit = Kit.from_parts(*test_translation.KIT.parts, test_translation.wander)
    automaton = Automaton(
        "a", (START, State("wander", "wander")), transitions={"start": Tree((make_leaf(1),))}
    )
    result = export_automaton(
        Library.from_automata(kit, automaton), "a", tmp_path, to=target, body=test_translation.BODY
    )
    assert [what for what, _, _ in result.untranslated] == ["behavior wander"]
    finds = "cannot begin" if runner == "qt" else "could not be translated"
    assert not ask(runner, tmp_path, finds=finds).succeeded
    source = tmp_path / {"scxml": "a.scxml", "xstate": "machine.mjs"}[target]
    text = re.sub("(?m)^ *throw new Error.*$", "", source.read_text())
    source.write_text(text.replace("return {drive: 0,", "return {drive: readings.speed,"))
    assert ask(runner, tmp_path).counts[1] == 0


@pytest.mark.parametrize("runner", RUNNERS)
def test_a_condition_that_cannot_be_evaluated_is_no_decision(runner: str, ask: Ask, tmp_path: Path) -> None:
    """In SCXML it would count as false; the statechart ends in a state that says so instead."""
    target = RUNNERS[runner]
    library, body = open_fixture()
    result = export_automaton(library, "forage", tmp_path, to=target, body=body)
    source = tmp_path / {"scxml": "forage.scxml", "xstate": "machine.mjs"}[target]
    source.write_text(source.read_text().replace("return x !== x;", "return nothing(x);"))
    answer = ask(runner, tmp_path)
    assert not answer.succeeded
    assert answer.counts[1] > result.ticks * 0.9


CHAIN_KIT = Kit.from_parts(FlagFeature("done"), Behavior("go", Command(drive=1.0)))


def chain(length: int) -> Library:
    """A chain of automata, each of which runs the one before in two states."""
    automata = []
    for number in range(length):
        runs = f"a{number - 1}" if number else "go"
        states = (START, State("one", runs), State("two", runs))
        trees = {"start": Tree((make_leaf(1),)), "one": Tree((make_leaf(2),))}
        automata.append(Automaton(f"a{number}", states, transitions=trees))
    return Library.from_automata(CHAIN_KIT, *automata)


def test_a_statechart_that_would_be_too_large_is_refused(tmp_path: Path) -> None:
    body = BodyInterface((), (Channel("drive"),))
    with pytest.raises(DefinitionError, match=f"as a statechart it has 49149 states.*at most {MOST_STATES}"):
        export_automaton(chain(14), "a13", tmp_path / "out", to="scxml", body=body)
    assert not (tmp_path / "out").exists()
    export_automaton(chain(10), "a9", tmp_path / "out", to="scxml", body=body)


def test_what_npm_makes_is_replaced_with_an_export(tmp_path: Path) -> None:
    library, body = open_fixture()
    folder = tmp_path / "out"
    for _ in range(2):
        export_automaton(library, "forage", folder, to="xstate", body=body)
        (folder / "node_modules" / "xstate").mkdir(parents=True)
        (folder / "node_modules" / "xstate" / "package.json").write_text("{}")
        (folder / "package-lock.json").write_text("{}")
    (folder / "src").mkdir()
    (folder / "src" / "mine.js").write_text("mine")
    with pytest.raises(FileError, match=r"src/mine\.js is there"):
        export_automaton(library, "forage", folder, to="xstate", body=body)
