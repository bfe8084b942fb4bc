"""Measure the exported forager beside the one written by hand: python -m tests.export.measure_times."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from tests.export.exports import open_fixture

from understudy.export.export_automaton import export_automaton

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


def build_times(folder: Path, *compiler: str, single: bool) -> Path:
    """Export the forager, and build the program that measures it."""
    library, body = open_fixture()
    export_automaton(library, "forage", folder / "out", to="c99", body=body, single_precision=single)
    files = [str(SOURCES / "times.c"), str(SOURCES / "by_hand.c"), str(folder / "out" / "forage.c")]
    if compiler[0] == CORTEX_M3[0]:
        board = folder / "out" / "cortex-m3"
        files += [str(board / "start.c"), "-T", str(board / "m3.ld")]
    program = folder / "times"
    includes = [f"-I{SOURCES}", f"-I{folder / 'out'}"]
    subprocess.run([*compiler, *includes, *files, "-lm", "-o", str(program)], check=True)
    return program


def main() -> None:
    """Build and run for this computer, an emulated ATmega328P (cycles), and an emulated Cortex-M3 (instructions)."""
    for what, compiler, run in (
        ("gcc -O2", ("gcc", "-std=c99", "-O2"), ()),
        ("gcc -Os", ("gcc", "-std=c99", "-Os"), ()),
        ("ATmega328P", AVR, ("simavr", "-m", "atmega328p", "-f", "16000000")),
        ("Cortex-M3", CORTEX_M3, QEMU),
    ):
        with tempfile.TemporaryDirectory() as name:
            program = build_times(Path(name), *compiler, single=bool(run))
            done = subprocess.run([*run, str(program)], capture_output=True, text=True, check=False)
            lines = [line for line in (done.stdout + done.stderr).splitlines() if "exported" in line]
            sys.stdout.write(f"{what}: {lines}\n")


if __name__ == "__main__":
    main()
