"""Run exports for many ticks beside the interpreter: python -m tests.export.equality_at_scale --to c99.

Readings of a tick are drawn by a hash of its number from the values at the boundaries of the trees, in the same way
here and in C, so that nothing but a digest has to be carried over; other targets get them as rows. Libraries are random
ones, and the automata of the libraries in the folders that --demo names.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from random import Random
from time import perf_counter

import numpy as np
from tests.export.exports import count_mismatches, draw_job, load_python, read_counts, write_job
from tests.export.peers import list_peers, run_peer

from understudy.addons.export.conformance import Conformance, ConformanceTick, ReferenceRun, ReferenceTick
from understudy.addons.export.export_automaton import link_ground, prepare_export
from understudy.addons.export.target_files import ExportJob
from understudy.addons.export.targets.c99_source import CSource
from understudy.addons.export.targets.cpp_names import name_for_c
from understudy.addons.export.targets.target_table import TARGETS
from understudy.addons.export.walks import ReadingWalk
from understudy.errors import DefinitionError
from understudy.model.value_kinds import Categorical
from understudy.runtime.link import Program, link
from understudy.ui.cli.commands.export import open_library_to_export

RUN = 64
"""A behavior starts again after so many ticks."""
BLOCK = 50_000
PRIME = 16_777_619
NATIVE, QT = "native", "qt"

MAIN = """
#include <stdio.h>
#include <string.h>
#include "%(name)s.h"
#ifdef __AVR__
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
static int put_character(char c, FILE *s) { (void)s; while (!(UCSR0A & (1 << UDRE0))) {} UDR0 = (uint8_t)c; return 0; }
#define READ(table, i) pgm_read_float(&(table)[i])
#else
#define PROGMEM
#define READ(table, i) ((table)[i])
#endif
#define ABSENT ((%(name)s_real)NAN)
%(tables)s
static uint32_t mix(uint32_t x)
{
    x ^= x >> 16; x *= 0x7feb352dUL; x ^= x >> 15; x *= 0x846ca68bUL; x ^= x >> 16;
    return x;
}
static uint32_t digest = 2166136261UL;
static void add(uint8_t byte) { digest = (digest ^ byte) * 16777619UL; }
int main(void)
{
    static %(name)s_machine m;
    %(name)s_readings r;
    %(name)s_commands c;
    uint32_t tick;
#ifdef __AVR__
    static FILE out;
    fdev_setup_stream(&out, put_character, NULL, _FDEV_SETUP_WRITE);
    stdout = &out; UBRR0 = 0; UCSR0B = 1 << TXEN0;
#endif
    memset(&r, 0, sizeof r);
    for (tick = 0; tick < %(ticks)dUL; tick++) {
        uint8_t path[%(NAME)s_LEVELS], flags[%(NAME)s_LEVELS], levels, level, basic;
        const %(name)s_time now = %(now)s;
%(draw)s
        if (tick %% %(run)d == 0) %(name)s_start(&m, now);
        basic = %(name)s_step(&m, &r, now, &c);
        levels = %(name)s_path(&m, path, flags);
        add(basic); add(levels);
        for (level = 0; level < levels; level++) { add(path[level]); add(flags[level]); }
    }
    printf("digest %%lu\\n", (unsigned long)digest);
#ifdef __AVR__
    while (!(UCSR0A & (1 << TXC0))) {}
    cli(); sleep_enable(); sleep_cpu();
#endif
    return 0;
}
"""

BUILD = {
    "native": ("gcc -std=c99 -O2 {p}.c main.c -lm -o run", "./run"),
    "cortex-m3": (
        "arm-none-eabi-gcc -mcpu=cortex-m3 -mthumb -Os -std=c99 --specs=nano.specs --specs=rdimon.specs -nostartfiles "
        "-T cortex-m3/m3.ld cortex-m3/start.c {p}.c main.c -lm -o run",
        "qemu-system-arm -M lm3s6965evb -cpu cortex-m3 -nographic -monitor none -serial none "
        "-semihosting-config enable=on,target=native -kernel run",
    ),
    "avr": (
        "avr-gcc -mmcu=atmega328p -DF_CPU=16000000UL -Os -std=c99 {p}.c main.c -lm -o run",
        "simavr -m atmega328p -f 16000000 run",
    ),
}


def mix(numbers: np.ndarray) -> np.ndarray:
    """The same hash as in C."""
    x = numbers.astype(np.uint32)
    x ^= x >> np.uint32(16)
    x *= np.uint32(0x7FEB352D)
    x ^= x >> np.uint32(15)
    x *= np.uint32(0x846CA68B)
    x ^= x >> np.uint32(16)
    return x


def draw_rows(values: Sequence[Sequence[float]], ticks: int) -> Iterator[tuple[int, list[float]]]:
    """Yield the number of each tick and its readings."""
    tables = [np.array(each) for each in values]
    slots = len(tables)
    for begin in range(0, ticks, BLOCK):
        numbers = np.arange(begin, min(begin + BLOCK, ticks), dtype=np.uint64)
        columns = [
            table[mix((numbers * slots + slot) % 2**32) % np.uint32(len(table))]
            for slot, table in enumerate(tables)
        ]
        rows = np.column_stack(columns).tolist() if columns else [[] for _ in numbers]
        yield from zip(numbers.tolist(), rows, strict=True)


def draw_values(job: ExportJob) -> list[tuple[float, ...]]:
    return list(ReadingWalk(job.hierarchy, Random(0), single_precision=job.single_precision).values)


def find_time(job: ExportJob, tick: int) -> tuple[float, float]:
    """The time of a tick in s, and as the export reads it."""
    if job.single_precision:
        ms = tick * round(job.hierarchy.tick_s * 1000)
        return ms / 1000, float(ms)
    return tick * job.hierarchy.tick_s, tick * job.hierarchy.tick_s


def run_reference(job: ExportJob, program: Program, ticks: int) -> Iterator[ConformanceTick]:
    reference = ReferenceRun(program, job.hierarchy, single_precision=job.single_precision)
    for tick, row in draw_rows(draw_values(job), ticks):
        now, read = find_time(job, tick)
        if tick % RUN == 0:
            reference.start(now)
        yield ConformanceTick(tick % RUN == 0, read, tuple(row), reference.pulse(row, now))


def digest(answers: Iterator[ReferenceTick]) -> int:
    found = 2166136261
    for answer in answers:
        found = ((found ^ answer.basic) * PRIME) & 0xFFFFFFFF
        found = ((found ^ len(answer.path)) * PRIME) & 0xFFFFFFFF
        for state, flag in zip(answer.path, answer.flags, strict=True):
            found = ((found ^ state) * PRIME) & 0xFFFFFFFF
            found = ((found ^ (flag + 1)) * PRIME) & 0xFFFFFFFF
    return found


def write_main(job: ExportJob, ticks: int) -> str:
    names, hierarchy = name_for_c(job.hierarchy), job.hierarchy
    source = CSource(hierarchy, names, single_precision=job.single_precision)
    tables, draw = [], []
    for slot, (reading, values) in enumerate(zip(hierarchy.readings, draw_values(job), strict=True)):
        items = ["ABSENT" if value != value else source.write_real(value) for value in values]
        tables.append(f"static const {names.prefix}_real t{slot}[] PROGMEM = {{{', '.join(items)}}};")
        value = f"READ(t{slot}, mix(tick * {len(hierarchy.readings)}UL + {slot}UL) % {len(values)}U)"
        member = f"r.{names.readings[str(reading)]}"
        if isinstance(reading.kind, Categorical):
            cast = f"({names.prefix}_label)x"
            draw.append(f"{{ const {names.prefix}_real x = {value}; {member} = x != x ? -1 : {cast}; }}")
        else:
            draw.append(f"{member} = {value};")
    tick_ms = round(hierarchy.tick_s * 1000)
    now = f"tick * {tick_ms}UL" if job.single_precision else f"(double)tick * {hierarchy.tick_s!r}"
    return MAIN % {
        "name": names.prefix, "NAME": names.prefix.upper(), "tables": "\n".join(tables), "ticks": ticks,
        "now": now, "draw": "\n".join(draw), "run": RUN,
    }  # fmt: skip


def run_in_c(job: ExportJob, ticks: int, machine: str) -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = write_job(Path(name), job, to="c99")
        (folder / "main.c").write_text(write_main(job, ticks))
        build, run = BUILD[machine]
        subprocess.run(build.format(p=name_for_c(job.hierarchy).prefix).split(), cwd=folder, check=True)
        done = subprocess.run(run.split(), cwd=folder, capture_output=True, text=True, check=False)
        found = re.search(r"digest (\d+)", done.stdout + done.stderr)
        return int(found[1]) if found else -1


def list_jobs(arguments: argparse.Namespace) -> Iterator[tuple[str, ExportJob, Program]]:
    single = arguments.on not in (NATIVE, QT) or arguments.single
    for seed in range(arguments.first, arguments.first + arguments.random):
        job = draw_job(seed, to=arguments.to, single=single)
        yield f"random {seed}", job, link(job.library, job.hierarchy.name, job.hierarchy.binding)
    for folder in arguments.demo:
        for path in sorted(Path(folder).rglob("*.json")):
            if "versions" in path.parts:
                continue
            name = path.relative_to(folder).with_suffix("").as_posix()
            library, name, body = open_library_to_export(Path(folder), name, None, None)
            targets = list(library.kit.targets)
            binding = dict.fromkeys(library.parameters(name), targets[0]) if targets else {}
            try:
                job = prepare_export(
                    library,
                    name,
                    to=arguments.to,
                    binding=binding,
                    body=body,
                    fingerprint="",
                    single_precision=single,
                )
            except DefinitionError as error:  # it decides with a classifier
                say(f"{name}: {error}")
                continue
            yield f"{folder} {name}", job, link_ground(job.library, name, binding, body)[0]


def main() -> int:
    """Run what the options say, and report every library."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--to", choices=tuple(name for name in TARGETS if name != "ros2"), default="c99")
    parser.add_argument("--on", choices=(*BUILD, QT), default=NATIVE, help="qt: of scxml, instead of Scion")
    parser.add_argument("--single", action="store_true")
    parser.add_argument("--ticks", type=int, default=1_000_000, help="of each library")
    parser.add_argument("--random", type=int, default=10, help="number of random libraries")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--demo", action="append", default=[], help="folder of a library")
    arguments = parser.parse_args()
    total = wrong = 0
    began = perf_counter()
    for name, job, program in list_jobs(arguments):
        ticks = run_reference(job, program, arguments.ticks)
        if arguments.to == "c99":
            try:
                found = run_in_c(job, arguments.ticks, arguments.on)
            except subprocess.CalledProcessError:
                say(f"{name}: does not fit")
                continue
            equal = found == digest(tick.expected for tick in ticks)
        else:
            rows = Conformance(tuple(ticks), 0, (0, 0), (0, 0))
            made = replace(job, conformance=rows)
            equal = run_rows(made, arguments.to, arguments.on) == (arguments.ticks, 0)
        total += arguments.ticks
        wrong += not equal
        say(f"{name}: {arguments.ticks} ticks {'equal' if equal else 'DIFFER'}")
    say(f"{total} ticks, {wrong} libraries differ, {perf_counter() - began:.0f} s")
    return bool(wrong)


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def run_rows(job: ExportJob, to: str, on: str) -> tuple[int, int]:
    if to == "python":
        return count_mismatches(load_python(job), job)
    with tempfile.TemporaryDirectory() as name:
        folder = write_job(Path(name), job, to=to)
        runs = {"scxml": "scion", "xstate": "xstate", "json": "node", "btcpp": "behaviortreepy"}
        peer = list_peers()[QT if on == QT else runs[to]]
        done = run_peer(peer, folder, ("make", *peer.words), "")
        return read_counts(done.stdout + done.stderr)


if __name__ == "__main__":
    raise SystemExit(main())
