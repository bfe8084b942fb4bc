"""Compilation of the kernels that a measurement needs, with a word about it if it takes long."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

from understudy.learning.tree_growth import compile_tree_kernels as prepare_learner
from understudy.sim.catalog import compile_world_kernels as prepare_world
from understudy.ui.cli.output import make_console

if TYPE_CHECKING:
    from understudy.sim.scenario.schema import Scenario

SLOW_S = 2.0


def compile_once(*, learner: bool = False, world: Scenario | None = None, quiet: bool = False) -> None:
    """Compile the kernels that a measurement needs, and say so on stderr if it takes longer than 2 s."""
    out = make_console(err=True)
    out.quiet = quiet
    began = perf_counter()
    with out.status("Compiling once; the next run starts at once …"):
        if learner:
            prepare_learner()
        if world is not None:
            prepare_world(world)
    if perf_counter() - began > SLOW_S:
        out.print(f"[dim]Compiled in {perf_counter() - began:.0f} s; the next run starts at once.[/]")
