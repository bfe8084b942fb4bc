"""Compile the kernels that most tests use, before several test processes each wait for them.

Each group of kernels is compiled in a process of its own, as many at a time as there are processors. If two want the
same kernel, one compiles it and the other waits (`understudy.jit.cache.lock_kernel`).
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import tests.conftest  # noqa: F401 - chooses the parts of kernels
from tests.kernel_modes import cases

from understudy.jit.settings import pause_garbage_collection
from understudy.sim.catalog import compile_world_kernels
from understudy.sim.scenario.files import load_scenario

ONE_LAYER = "one layer of coordinators"
GROUPS = (("squads",), ("inverse", "tree 2", "pulses 2", "arena"), (ONE_LAYER,))
"""Cases with all kernels: of robots under several layers of coordinators, by themselves, and under one layer.

The second group begins with kernels that the first does not want."""


def main() -> None:
    """Compile by running the cases named, or else each group in a process of its own."""
    if named := sys.argv[1:]:
        works: dict[str, Callable[[], object]] = dict(cases())
        works[ONE_LAYER] = partial(compile_world_kernels, load_scenario("patrol"))
        with pause_garbage_collection():
            for name in named:
                works[name]()
        return
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        commands = [[sys.executable, "-m", "tests.compile_kernels", *group] for group in GROUPS]
        for done in pool.map(subprocess.run, commands):
            done.check_returncode()


if __name__ == "__main__":
    main()
