"""Measure the exported forager beside the one written by hand: python -m tests.export.measure_times."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.export.exports import open_fixture

from understudy.addons.export.export_automaton import export_automaton

SOURCES = Path(__file__).parent / "forager"
CORTEX_M3 = (
    "arm-none-eabi-gcc", "-mcpu=cortex-m3", "-mthumb", "-DSINGLE", "-Os", "-std=gnu99", "--specs=nano.specs",
    "--specs=rdimon.specs", "-nostartfiles",
)  # fmt: skip
QEMU = (
    "qemu-system-arm", "-M", "lm3s6965evb", "-cpu", "cortex-m3", "-nographic", "-monitor", "none", "-serial", "none",
    "-semihosting-config", "enable=on,target=native", "-icount", "shift=10,sleep=off", "-kernel",
)  # fmt: skip
AVR = ("avr-gcc", "-mmcu=atmega328p", "-DF_CPU=16000000UL", "-DSINGLE", "-Os", "-std=gnu99")


NATIVE = ("gcc", "-std=c99")


def write_program(folder: Path, *compiler: str, single: bool) -> list[str]:
    """Write the program that measures the forager; return the command that compiles it there."""
    library, body = open_fixture()
    export_automaton(library, "forage", folder / "out", to="c99", body=body, single_precision=single)
    shutil.copytree(SOURCES, folder, dirs_exist_ok=True)
    board = ("out/cortex-m3/start.c", "-T", "out/cortex-m3/m3.ld") if compiler[0] == CORTEX_M3[0] else ()
    return [*compiler, "-I.", "-Iout", "times.c", "by_hand.c", "out/forage.c", *board, "-lm", "-o", "times"]


def main() -> None:
    """Build and run for this computer, an emulated ATmega328P (cycles), and an emulated Cortex-M3 (instructions)."""
    for what, compiler, run in (
        ("gcc -O2", (*NATIVE, "-O2"), ()),
        ("gcc -Os", (*NATIVE, "-Os"), ()),
        ("ATmega328P", AVR, ("simavr", "-m", "atmega328p", "-f", "16000000")),
        ("Cortex-M3", CORTEX_M3, QEMU),
    ):
        with tempfile.TemporaryDirectory() as name:
            subprocess.run(write_program(Path(name), *compiler, single=bool(run)), cwd=name, check=True)
            done = subprocess.run([*run, f"{name}/times"], capture_output=True, text=True, check=False)
            lines = [line for line in (done.stdout + done.stderr).splitlines() if "exported" in line]
            sys.stdout.write(f"{what}: {lines}\n")


if __name__ == "__main__":
    main()
