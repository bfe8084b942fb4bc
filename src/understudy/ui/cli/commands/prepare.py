"""Command `understudy prepare`: compile kernels ahead of time."""

from __future__ import annotations

from time import perf_counter

import typer

from understudy.addons.bridges.environments.body_maker import find_world
from understudy.jit.cache import find_cache_folder
from understudy.jit.settings import compile_on_first_call
from understudy.learning.tree_growth import compile_tree_kernels
from understudy.sim.catalog import compile_world_kernels
from understudy.sim.scenario.files import list_builtin_scenarios
from understudy.sim.scenario.schema import Scenario
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import format_count
from understudy.ui.cli.progress_bar import show_progress
from understudy.ui.cli.run_options import PrepareOptions


def prepare(options: PrepareOptions) -> None:
    """Compile the learner and the kernels of scenarios ahead of time, for images and classrooms."""
    opened = [find_world(name) for name in options.scenarios or list_builtin_scenarios()]
    worlds = [world for world in opened if isinstance(world, Scenario)]  # nothing is compiled for a body
    compile_on_first_call()
    began = perf_counter()
    with show_progress("Prepared", quiet=options.as_json) as report:
        report(0, len(worlds) + 1)
        compile_tree_kernels()
        for done, world in enumerate(worlds, start=1):
            report(done, len(worlds) + 1)
            compile_world_kernels(world)
    seconds, folder = perf_counter() - began, find_cache_folder()
    if options.as_json:
        print_json({"worlds": [world.name for world in worlds], "seconds": seconds, "folder": folder})
    else:
        scenarios_done = format_count(len(worlds), "scenario")
        typer.echo(f"Prepared {scenarios_done} in {seconds:.0f} s; compiled kernels are in {folder}")
