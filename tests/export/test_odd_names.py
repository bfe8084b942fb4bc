"""Names, units and labels of all sorts: what is exported runs on its rows, or one sentence says why not."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.export.exports import make, read_counts
from tests.export.recorded_answers import Ask, hash_text

from understudy.addons.export.body_interface import BodyInterface
from understudy.addons.export.export_automaton import export_automaton
from understudy.addons.export.exported_trace import read_exported_trace
from understudy.errors import DefinitionError
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import Behavior, Command
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Kit, Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Categorical, Continuous, Kind
from understudy.runtime.body import Channel, Reading


def export(
    folder: Path,
    to: str,
    *,
    name: str = "a",
    state: str = "go",
    reading: str = "speed",
    unit: str = "m",
    channel: str = "drive",
    behavior: str = "go",
    labels: tuple[str, ...] = (),
    single: bool = False,
) -> Path:
    """Export an automaton of two states that has these names."""
    kind: Kind = Categorical(labels) if labels else Continuous()
    feature = Feature("f", kind, reading)
    kit = Kit.from_parts(feature, Behavior(behavior, Command(**{channel: 1.0})))
    question = Node(TestKind.BELOW, 0, high=0.5, yes=1, no=2, absent=2)
    if labels:
        question = Node(TestKind.LABEL, 0, branches=(1, *[2] * (len(labels) - 1)), absent=2)
    tree = Tree((question, make_leaf(0), make_leaf(1)))
    automaton = Automaton(
        name,
        (START, State(state, behavior)),
        (BoundFeature(feature),),
        transitions={"start": tree, state: tree},
    )
    body = BodyInterface((Reading(reading, kind, unit),), (Channel(channel, 0.0, unit),))
    library = Library.from_automata(kit, automaton)
    export_automaton(library, name, folder, to=to, body=body, single_precision=single)
    return folder


IN_C = [
    {"name": "a*/b"},
    {"name": "math"},
    {"state": "what??/"},
    {"unit": "m*/s"},
    {"unit": "m\\"},
    {"labels": ("a*/", "b/*", "c")},
    {"reading": "NAN"},
    {"reading": "INFINITY"},
    {"reading": "NULL"},
    {"reading": "requires"},
    {"channel": "constexpr"},
]


@pytest.mark.parametrize("names", IN_C, ids=str)
def test_c_compiles_whatever_the_names(names: dict[str, str], ask: Ask, tmp_path: Path) -> None:
    folder = export(tmp_path, "c99", **names)  # type: ignore[arg-type]
    assert ask("gcc", folder).counts[1] == 0
    header = next(path for path in folder.glob("*.h") if path.name != "embedded_rows.h")
    program = f'#include <stdio.h>\n#include "{header.name}"\n'
    command = ("g++", "-std=c++20", "-Wall", "-Werror", "-I.", "-fsyntax-only", "-x", "c++", "-")
    assert ask("g++", folder, command=command, given=program, finds="").succeeded
    source = header.with_suffix(".c").name
    as_in_zephyr = ("gcc", "-std=c99", "-I.", "-fsyntax-only", source)
    assert ask("gcc", folder, command=as_in_zephyr, finds="").succeeded


@pytest.mark.parametrize("name", ['say "hi"', "Tür", "back\\slash", "why??/", "a;b, c=d 100%3B"])
def test_all_targets_name_the_automaton_in_a_trace_as_the_library_does(
    name: str, ask: Ask, tmp_path: Path
) -> None:
    folder = export(tmp_path / "python", "python", name=name)
    make(folder, "trace")
    trace = folder / "trace.csv"
    assert read_exported_trace(trace).name == name
    for target, peer in (("c99", "gcc"), ("json", "node")):
        answer = ask(peer, export(tmp_path / target, target, name=name), "trace", hashes="trace.csv")
        assert answer.said == hash_text(trace.read_bytes())


@pytest.mark.parametrize("names", [{"behavior": "a in go"}, {"behavior": "idle"}], ids=str)
def test_constants_that_become_one_are_refused(names: dict[str, str], tmp_path: Path) -> None:
    with pytest.raises(DefinitionError, match="both become"):
        export(tmp_path / "out", "c99", **names)  # type: ignore[arg-type]
    assert not (tmp_path / "out").exists()


IN_PYTHON = [
    {"name": "time"},
    {"name": "machine"},
    {"name": '"""'},
    {"name": "back\\Nslash\\"},
    {"channel": "left,wheel"},
    {"channel": "left  wheel"},
    {"state": "None"},
    {"behavior": "idle"},
]


@pytest.mark.parametrize("names", IN_PYTHON, ids=str)
def test_python_runs_whatever_the_names(names: dict[str, str], tmp_path: Path) -> None:
    folder = export(tmp_path, "python", **names)  # type: ignore[arg-type]
    assert read_counts(make(folder, "test"))[1] == 0
    assert not {"time.py", "machine.py"} & {path.name for path in folder.iterdir()}


IN_JAVASCRIPT = [
    {"behavior": "idle"},
    {"behavior": "constructor"},
    {"state": "toString"},
    {"channel": "left,wheel"},
    {"name": "constructor"},
]


@pytest.mark.parametrize("names", IN_JAVASCRIPT, ids=str)
def test_the_reader_runs_whatever_the_names(names: dict[str, str], ask: Ask, tmp_path: Path) -> None:
    folder = export(tmp_path, "json", **names)  # type: ignore[arg-type]
    assert ask("node", folder).counts[1] == 0
