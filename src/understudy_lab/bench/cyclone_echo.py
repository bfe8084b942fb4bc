"""A program in C on Cyclone DDS that answers ranges with commands: built from `echo.c` where the library is there."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

PEER = "Cyclone DDS in C (cyclonedds-dev, cyclonedds-tools and gcc on Debian)"
"""What has to be installed for it."""


def build_program(folder: Path) -> Path | None:
    """The program, built in a folder; None where that cannot be here."""
    here = Path(__file__).parent
    compiler, generator = shutil.which("gcc"), shutil.which("idlc")
    if compiler is None or generator is None:
        return None
    program = folder / "echo"
    commands = (
        [generator, "-o", str(folder), str(here / "echo.idl")],
        [compiler, "-O2", f"-I{folder}", str(here / "echo.c"), str(folder / "echo.c"), "-o", str(program)],
    )
    for command in (commands[0], [*commands[1], "-lddsc"]):
        if subprocess.run(command, capture_output=True, check=False).returncode:
            return None
    return program
