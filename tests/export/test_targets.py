"""Exports of a taught foraging robot, run where they are made for."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest
from tests.export.exports import (
    link_node_packages,
    make,
    need,
    need_behavior_trees,
    need_node_packages,
    open_fixture,
    read_counts,
)
from tests.export.measure_times import build_times

from understudy.export.export_automaton import TARGETS, ExportResult, export_automaton
from understudy.storage.schema import make_document_schema

ROOT = Path(__file__).parents[2]
MICROPYTHON = (
    ROOT / "build" / "micropython" / "node_modules" / "@micropython" / "micropython-webassembly-pyscript"
)

IN_MICROPYTHON = """
import { loadMicroPython } from "%s/micropython.mjs";
import { readFileSync } from "node:fs";
const micropython = await loadMicroPython({
  stdout: (line) => console.log(line), linebuffer: true, heapsize: 64 * 1024 * 1024,
});
for (const file of ["forage.py", "conformance.py", "conformance.csv"])
  micropython.FS.writeFile("/" + file, readFileSync(file));
micropython.runPython("import os, sys; sys.path.append('/'); os.chdir('/'); import conformance; conformance.main()");
"""

ARDUINO = """
#include <stdint.h>
unsigned long millis(void);
"""
ZEPHYR = """
#include <stdint.h>
uint32_t k_uptime_get_32(void);
int64_t k_uptime_get(void);
int32_t k_msleep(int32_t ms);
"""


def export(folder: Path, to: str, *, single: bool = False) -> ExportResult:
    library, body = open_fixture()
    return export_automaton(library, "forage", folder, to=to, body=body, single_precision=single)


def test_c_is_clean_with_every_compiler(tmp_path: Path) -> None:
    need("gcc", "clang")
    result = export(tmp_path, "c99")
    for compiler in ("gcc", "clang"):
        assert read_counts(make(tmp_path, "clean", "test", CC=compiler)) == (result.ticks, 0)
    assert read_counts(make(tmp_path, "sanitize", CC="gcc")) == (result.ticks, 0)


@pytest.mark.parametrize("single", [False, True], ids=["double", "single"])
def test_c_on_a_cortex_m3(single: bool, tmp_path: Path) -> None:
    need("arm-none-eabi-gcc", "qemu-system-arm")
    export(tmp_path, "c99", single=single)
    ticks, mismatches = read_counts(make(tmp_path, "test-cortex-m3").replace("Timer with period zero", ""))
    assert ticks > 100
    assert mismatches == 0


def test_c_on_an_avr(tmp_path: Path) -> None:
    need("avr-gcc", "simavr")
    export(tmp_path, "c99", single=True)
    ticks, mismatches = read_counts(make(tmp_path, "test-avr"))
    assert ticks > 100
    assert mismatches == 0


def test_the_forager_is_small(tmp_path: Path) -> None:
    """At most 4 kB of flash on both; the state takes at most 128 B."""
    need("avr-gcc", "arm-none-eabi-gcc")
    export(tmp_path, "c99", single=True)
    rows = [line.split() for line in make(tmp_path, "sizes").splitlines() if line.strip().endswith(".o")]
    sizes = {row[-1]: (int(row[0]), int(row[1]) + int(row[2])) for row in rows if row[0].isdigit()}
    assert set(sizes) == {"forage-m3.o", "forage-avr.o"}
    assert all(text <= 4096 and data <= 128 for text, data in sizes.values())


def check_syntax(compiler: str, source: Path, include: Path, *flags: str) -> None:
    command = [compiler, "-fsyntax-only", "-Wall", "-Wextra", "-Werror", f"-I{include}", *flags, str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("single", [False, True], ids=["double", "single"])
def test_sketch_and_zephyr_program_compile_with_stand_in_headers(single: bool, tmp_path: Path) -> None:
    """The headers of Arduino and Zephyr are not at hand: these declare what the programs call."""
    need("gcc", "g++")
    export(tmp_path / "out", "c99", single=single)
    headers = tmp_path / "headers"
    (headers / "zephyr").mkdir(parents=True)
    (headers / "Arduino.h").write_text(ARDUINO)
    (headers / "zephyr" / "kernel.h").write_text(ZEPHYR)
    sketch = tmp_path / "out" / "arduino" / "forage" / "forage.ino"
    check_syntax("g++", sketch, headers, "-x", "c++", "-include", "Arduino.h")
    program = tmp_path / "out" / "zephyr" / "src" / "main.c"
    check_syntax("gcc", program, headers, "-std=c99", f"-I{tmp_path / 'out'}")


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


def test_python_runs_in_micropython(tmp_path: Path) -> None:
    need("node")
    if not MICROPYTHON.exists():
        assert not os.environ.get("CI"), "MicroPython is missing"
        pytest.skip("needs MicroPython: see .ci/run")
    result = export(tmp_path, "python")
    (tmp_path / "run.mjs").write_text(IN_MICROPYTHON % MICROPYTHON)
    command = ["node", "run.mjs"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert read_counts(done.stdout) == (result.ticks, 0)


def test_all_targets_write_the_same_trace(tmp_path: Path) -> None:
    need("gcc", "node")
    need_node_packages("@scion-scxml/scxml", "xstate")
    need_behavior_trees()
    traces = set()
    for target in TARGETS:
        if target == "ros2":  # its node has no trace: it publishes its states
            continue
        export(tmp_path / target, target)
        if target in ("scxml", "xstate"):
            link_node_packages(tmp_path / target)
        make(tmp_path / target, "trace", PYTHON=sys.executable)
        traces.add((tmp_path / target / "trace.csv").read_text())
    assert len(traces) == 1


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


def test_the_forager_by_hand_decides_as_the_exported_one(tmp_path: Path) -> None:
    """So that the times which the documents compare are those of the same decisions."""
    need("gcc")
    program = build_times(tmp_path, "gcc", "-std=c99", "-O2", single=False)
    assert (
        "; 0 decided otherwise"
        in subprocess.run([program], capture_output=True, text=True, check=True).stdout
    )
