"""Exports of a taught foraging robot, run where they are made for."""

from __future__ import annotations

import ast
import shutil
import sys
from pathlib import Path

import msgspec
import pytest
from tests.export.exports import make, open_fixture, read_counts
from tests.export.measure_times import NATIVE, write_program
from tests.export.peers import MICROPYTHON, ROOT
from tests.export.recorded_answers import Ask, hash_text

from understudy.addons.export.export_automaton import ExportResult, export_automaton
from understudy.storage.library_schema import make_document_schema

HEADERS = Path(__file__).parent / "headers"
"""The headers of Arduino and Zephyr are not at hand: these declare what the programs call."""

IN_MICROPYTHON = """
const { loadMicroPython } = await import(process.env.NODE_PEERS + "/%s/micropython.mjs");
import { readFileSync } from "node:fs";
const micropython = await loadMicroPython({
  stdout: (line) => console.log(line), linebuffer: true, heapsize: 64 * 1024 * 1024,
});
for (const file of ["forage.py", "conformance.py", "conformance.csv"])
  micropython.FS.writeFile("/" + file, readFileSync(file));
micropython.runPython("import os, sys; sys.path.append('/'); os.chdir('/'); import conformance; conformance.main()");
"""
TRACERS = {"c99": "gcc", "json": "node", "scxml": "scion", "xstate": "xstate", "btcpp": "behaviortreepy"}
"""What writes the traces of exports to targets other than Python; the node of ROS 2 publishes its states instead."""


def export(folder: Path, to: str, *, single: bool = False) -> ExportResult:
    library, body = open_fixture()
    return export_automaton(library, "forage", folder, to=to, body=body, single_precision=single)


@pytest.mark.parametrize("peer", ["gcc", "clang", "sanitizers"])
def test_c_is_clean_with_every_compiler(peer: str, ask: Ask, tmp_path: Path) -> None:
    result = export(tmp_path, "c99")
    assert ask(peer, tmp_path).counts == (result.ticks, 0)


@pytest.mark.parametrize("single", [False, True], ids=["double", "single"])
def test_c_on_a_cortex_m3(single: bool, ask: Ask, tmp_path: Path) -> None:
    export(tmp_path, "c99", single=single)
    ticks, mismatches = ask("cortex-m3", tmp_path).counts
    assert ticks > 100
    assert mismatches == 0


def test_c_on_an_avr(ask: Ask, tmp_path: Path) -> None:
    export(tmp_path, "c99", single=True)
    ticks, mismatches = ask("avr", tmp_path).counts
    assert ticks > 100
    assert mismatches == 0


def test_the_forager_is_small(ask: Ask, tmp_path: Path) -> None:
    """At most 4 kB of flash on both; the state takes at most 128 B."""
    export(tmp_path, "c99", single=True)
    judge = 'print $NF, ($1 <= 4096 && $2 + $3 <= 128 ? "fits" : "is too large")'
    command = ("sh", "-c", f"make sizes | awk '$1 + 0 > 0 && $NF ~ /[.]o$/ {{ {judge} }}'")
    answer = ask("sizes", tmp_path, command=command, finds=r"(?m)^forage-.*")
    assert answer.said.splitlines() == ["forage-m3.o fits", "forage-avr.o fits"]


@pytest.mark.parametrize("single", [False, True], ids=["double", "single"])
def test_sketch_and_zephyr_program_compile_with_stand_in_headers(
    single: bool, ask: Ask, tmp_path: Path
) -> None:
    export(tmp_path / "out", "c99", single=single)
    shutil.copytree(HEADERS, tmp_path / "headers")
    strict = ("-fsyntax-only", "-Wall", "-Wextra", "-Werror", "-Iheaders")
    sketch = ("-x", "c++", "-include", "Arduino.h", "out/arduino/forage/forage.ino")
    assert ask("g++", tmp_path, command=("g++", *strict, *sketch), finds="").succeeded
    program = ("-std=c99", "-Iout", "out/zephyr/src/main.c")
    assert ask("gcc", tmp_path, command=("gcc", *strict, *program), finds="").succeeded


def test_python_runs_here_and_reads_as_python_3_9(tmp_path: Path) -> None:
    result = export(tmp_path, "python")
    assert read_counts(make(tmp_path, "test")) == (result.ticks, 0)
    for file in ("forage.py", "conformance.py"):
        tree = ast.parse((tmp_path / file).read_text(), feature_version=(3, 9))
        names = {
            alias.name
            for node in ast.walk(tree)
            if isinstance(node, ast.Import | ast.ImportFrom)
            for alias in node.names
        }
        assert names <= {"math", "sys", "forage"}


def test_python_runs_in_micropython(ask: Ask, tmp_path: Path) -> None:
    result = export(tmp_path, "python")
    (tmp_path / "run.mjs").write_text(IN_MICROPYTHON % MICROPYTHON)
    assert ask("micropython", tmp_path, command=("node", "run.mjs")).counts == (result.ticks, 0)


@pytest.mark.parametrize("target", TRACERS)
def test_all_targets_write_the_same_trace(target: str, ask: Ask, tmp_path: Path) -> None:
    export(tmp_path / "python", "python")
    make(tmp_path / "python", "trace", PYTHON=sys.executable)
    trace = (tmp_path / "python" / "trace.csv").read_bytes()
    export(tmp_path / target, target)
    assert ask(TRACERS[target], tmp_path / target, "trace", hashes="trace.csv").said == hash_text(trace)


def test_documents_are_those_of_the_library_without_lessons(tmp_path: Path) -> None:
    export(tmp_path, "json")
    assert {path.stem for path in (tmp_path / "library").iterdir()} == {
        "deposit",
        "forage",
        "goto",
        "harvest",
    }
    assert all(
        msgspec.json.decode(path.read_bytes())["lesson"] is None for path in (tmp_path / "library").iterdir()
    )
    reader = (tmp_path / "reader.mjs").read_text()
    assert len(reader.splitlines()) < 200


def test_the_schema_in_the_documents_is_up_to_date() -> None:
    """If not: write make_document_schema() there, indented by 2."""
    kept = msgspec.json.decode((ROOT / "docs" / "reference" / "library.schema.json").read_bytes())
    assert kept == make_document_schema()


def test_the_forager_by_hand_decides_as_the_exported_one(ask: Ask, tmp_path: Path) -> None:
    """So that the times which the documents compare are those of the same decisions."""
    command = " ".join(write_program(tmp_path, *NATIVE, "-O2", single=False))
    finds = r"; \d+ decided otherwise"
    answer = ask("gcc", tmp_path, command=("sh", "-c", f"{command} && ./times"), finds=finds)
    assert answer.said == "; 0 decided otherwise"
