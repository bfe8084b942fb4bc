"""Exports of libraries into folders, and what runs them there."""

from __future__ import annotations

import os
import re
import subprocess
from dataclasses import replace
from functools import cache, lru_cache
from math import nan
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any

from tests.runtime import random_libraries
from tests.runtime.random_libraries import Played, draw_library

from understudy.addons.export.body_interface import BodyInterface
from understudy.addons.export.export_automaton import prepare_export
from understudy.addons.export.target_files import ExportJob
from understudy.addons.export.targets.target_table import TARGETS
from understudy.learning.fit import learn as learn_from
from understudy.model.behaviors import Behavior, Command, increment, reset_timer, set_timer
from understudy.model.features import Feature
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.model.tree import TestKind, Tree
from understudy.model.value_kinds import BOOLEAN, Continuous
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import list_readings, make_channels, make_scenario_kit
from understudy.storage.library_folder import open_library

FIXTURE = Path(__file__).parents[1] / "fixtures" / "v0_1_0" / "library"
BODY = BodyInterface(Played.readings, Played.channels, 0.1)
FRESH = (
    Feature("seen_since_entry", BOOLEAN, "seen", fresh=1.0),
    Feature("load_since_entry", Continuous(), "load", fresh=0.0),
)
"""Features such as those of coordinators, which a switch resets."""
KIT = Kit.from_parts(*random_libraries.kit.parts, *FRESH)
WHOLE_KIT = Kit.from_parts(
    *(part for part in KIT.parts if part.name not in ("slip", "unclick")),
    Behavior("slip", Command(), (increment("falls", -1.0), increment("laps", 2.0), set_timer("bell"))),
    Behavior("unclick", Command(), (reset_timer("watch"), increment("unread"))),
)
"""The kit of random libraries with counters that are whole numbers, as single precision asks for."""
LIVELY = 8
"""Most random automata soon end in a flag; so many leaves must be reached for a job to count."""
DRAWS = 15


def draw_job(seed: int, *, to: str, levels: int = 6, single: bool = False) -> ExportJob:
    """Draw libraries until one is lively, and prepare the export of its topmost automaton with some binding."""
    return _draw_job(seed, levels=levels, single=single, as_documents=to == "json")


@lru_cache(maxsize=16)
def _draw_job(seed: int, *, levels: int, single: bool, as_documents: bool) -> ExportJob:
    to = "json" if as_documents else "c99"  # beyond this, jobs are the same for all targets
    random, job = Random(seed), None
    for _ in range(DRAWS):
        kit = WHOLE_KIT if single else KIT
        automata = random.randint(1, levels)
        library = draw_library(random, automata=automata, depth=random.randint(0, 4), kit=kit)
        if as_documents:
            library = keep_arcs_on_circles(library)
        name = list(library.taught)[-1]
        binding = {each: random.choice(Played.targets) for each in library.parameters(name)}
        job = prepare_export(
            library, name, to=to, binding=binding, body=BODY, fingerprint="drawn", single_precision=single
        )
        if job.conformance.leaves[0] >= LIVELY:
            break
    assert job is not None
    return job


def keep_arcs_on_circles(library: Library) -> Library:
    """Replace arcs on features that lie on no circle by cuts, since documents hold none."""
    for name in library.taught:
        automaton = library.automaton(name)
        made: dict[int, Tree] = {}
        for tree in automaton.transitions.values():
            assert isinstance(tree, Tree)
            kinds = [
                None if node.feature < 0 else automaton.features[node.feature].kind for node in tree.nodes
            ]
            made[id(tree)] = Tree(
                tuple(
                    node._replace(test=TestKind.BELOW, low=nan)
                    if node.test == TestKind.ARC and isinstance(kind, Continuous)
                    else node
                    for node, kind in zip(tree.nodes, kinds, strict=True)
                )
            )
        transitions = {state: made[id(tree)] for state, tree in automaton.transitions.items()}
        library = library.with_automaton(TrainedAutomaton(replace(automaton, transitions=transitions)))
    return library


@cache
def open_fixture() -> tuple[Library, BodyInterface]:
    """Open a foraging robot's library that was taught, with its lessons."""
    scenario = find_scenario("forage")
    library = open_library(FIXTURE, make_scenario_kit(scenario), learn_from).library
    return library, BodyInterface(tuple(list_readings(scenario)), make_channels(scenario), scenario.tick_s)


def write_job(folder: Path, job: ExportJob, *, to: str) -> Path:
    """Write the files of a job without its manifest."""
    made = TARGETS[to].make_files(job)
    for name, content in {
        **made.files,
        **{name: file.write() for name, file in made.by_hand.items()},
    }.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return folder


def load_python(job: ExportJob) -> Any:
    """Load the exported Python module, without files."""
    files = TARGETS["python"].make_files(job).files
    text = next(
        content for name, content in files.items() if name.endswith(".py") and name != "conformance.py"
    )
    space: dict[str, Any] = {}
    exec(compile(text, "exported.py", "exec"), space)
    return SimpleNamespace(**space)


def count_mismatches(module: Any, job: ExportJob) -> tuple[int, int]:
    """Run an exported Python module on its conformance rows: ticks and mismatches."""
    machine, mismatches = None, 0
    names = [*module.READINGS]
    for tick in job.conformance.ticks:
        machine = machine or module.Machine(tick.time)
        if tick.starts:
            machine.start(tick.time)
        basic = machine.step(dict(zip(names, tick.readings, strict=True)), tick.time)
        states, flags = machine.path()
        found = (
            tuple(states),
            tuple(flags),
            basic,
            tuple(machine.commands[each] for each in module.CHANNELS),
        )
        expected = tick.expected
        mismatches += found != (expected.path, expected.flags, expected.basic, expected.commands)
    return len(job.conformance.ticks), mismatches


def make(folder: Path, *targets: str, **variables: str) -> str:
    """Run make in the folder of an export; what it printed."""
    done = subprocess.run(
        ["make", *targets, *(f"{name}={value}" for name, value in variables.items())],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "warning" not in done.stderr.lower(), done.stderr
    return done.stdout + done.stderr


def read_counts(printed: str) -> tuple[int, int]:
    """Read `TICKS ticks, MISMATCHES mismatches` from what an export printed."""
    found = re.search(r"(\d+) ticks, (\d+) mismatches", printed)
    assert found is not None, printed
    return int(found[1]), int(found[2])
