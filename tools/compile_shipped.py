"""Compile the kernels that a wheel for this platform carries into a folder.

    python tools/compile_shipped.py build/compiled

They are those of the learner, of the scenarios that ship, and one for all other scenarios, for the usual processors of
this kind of machine rather than for this one.
"""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

from understudy.jit.cache import SETTING, SUFFIX
from understudy.jit.settings import ALL_PARTS, COMPILED, MODE, OWN_PARTS, PARTS
from understudy.jit.stored import PROCESSOR_KINDS

ANY_SCENARIO = "forage"


def main(folder: Path) -> None:
    """Compile in other processes, which read the processor when they import Numba."""
    kind = PROCESSOR_KINDS.get(platform.machine())
    if kind is None:
        sys.exit(
            f"nothing is known of machines of the kind {platform.machine()!r}: see understudy/jit/stored.py"
        )
    shutil.rmtree(folder, ignore_errors=True)
    chosen = {
        **os.environ,
        SETTING: str(folder.resolve()),
        MODE: COMPILED,
        "NUMBA_CPU_NAME": kind.name,
        "NUMBA_CPU_FEATURES": "",
    }
    for parts, scenarios in ((OWN_PARTS, []), (ALL_PARTS, [ANY_SCENARIO])):
        command = [sys.executable, "-m", "understudy.ui.cli", "prepare", *scenarios]
        subprocess.run(command, env={**chosen, PARTS: parts}, check=True)
    files = list(folder.glob(f"*{SUFFIX}"))
    size = sum(file.stat().st_size for file in files)
    sys.stdout.write(f"{len(files)} compiled kernels for {kind.name}, {size / 1e6:.1f} MB, are in {folder}\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
