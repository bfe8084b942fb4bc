"""Run tests again and again on a machine that is quiet, busy, or stops their workers, and list failures.

Each run is a line in a file, so that what was interrupted goes on where it was:

    .venv/bin/python tools/stress_tests.py build/stress.jsonl --busy 8 --runs 10 -- -m "not long and not timed"

What follows -- goes to pytest.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import resource
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from threading import Event, Thread
from typing import Any, TypeAlias

BUSY_LOOP = "while True: pass"
STOPPED_S = (0.5, 3.0)
BETWEEN_S = (1.0, 6.0)
FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)
Run: TypeAlias = dict[str, Any]
COUNTS = re.compile(r"(\d+) (passed|failed|errors?|skipped)")


def main() -> int:
    """Do the runs that the file lacks, and print the table of all."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("file", type=Path, help="the file of runs, JSON lines")
    parser.add_argument("--runs", type=int, default=1, help="runs in all, those of the file included")
    parser.add_argument("--busy", type=int, default=0, help="number of busy loops beside the tests")
    parser.add_argument("--stop", action="store_true", help="suspend random workers now and then")
    parser.add_argument("--workers", default="auto", help="number of workers")
    split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    asked, options = parser.parse_args(sys.argv[1:split]), sys.argv[split + 1 :]
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # no loop and no test is left behind
    condition = {"busy": asked.busy, "stop": asked.stop, "pytest": options}
    while len(list_runs(asked.file, condition)) < asked.runs:
        row = condition | run_tests(options, workers=asked.workers, busy=asked.busy, stop=asked.stop)
        asked.file.parent.mkdir(parents=True, exist_ok=True)
        with asked.file.open("a") as file:
            file.write(json.dumps(row) + "\n")
        sys.stdout.write(describe(row) + "\n")
        sys.stdout.flush()
    return int(any(row["failed"] or row["rc"] for row in list_runs(asked.file, condition)))


def list_runs(file: Path, condition: Run) -> list[Run]:
    """Return the runs of a file that were made under a condition."""
    lines = file.read_text().splitlines() if file.exists() else []
    return [row for line in lines if condition.items() <= (row := json.loads(line)).items()]


def run_tests(options: list[str], *, workers: str, busy: int, stop: bool) -> Run:
    """Run the tests once; return the exit status, the counts, the failed tests, and the times (s)."""
    loops = [subprocess.Popen([sys.executable, "-c", BUSY_LOOP]) for _ in range(busy)]
    command = [
        sys.executable,
        "-m",
        "pytest",
        "--numprocesses",
        workers,
        "--dist",
        "loadgroup",
        "-q",
        *options,
    ]
    began, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    over = Event()
    tests = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        if stop:
            Thread(target=suspend_workers, args=(tests.pid, over), daemon=True).start()
        said, _ = tests.communicate()
    finally:
        over.set()
        tests.terminate()
        after = resource.getrusage(resource.RUSAGE_CHILDREN)  # the loops have not been waited for yet
        for loop in loops:
            loop.kill()
            loop.wait()
    counts = {name: int(number) for number, name in COUNTS.findall(said.splitlines()[-1] if said else "")}
    failed = sorted(set(FAILED.findall(said)))
    if tests.returncode:
        sys.stdout.write(said[-6000:])
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    row = {"rc": tests.returncode, **counts, "failed": failed}
    return row | {"clock_s": round(time.monotonic() - began, 1), "processor_s": round(used, 1)}


def suspend_workers(tests: int, over: Event) -> None:
    """Suspend a random worker of pytest for a random time, now and then, until the tests are over."""
    draw = random.Random()
    while not over.wait(draw.uniform(*BETWEEN_S)):
        workers = list_children(tests)
        if not workers:
            continue
        chosen = draw.choice(workers)
        with suppress(ProcessLookupError):
            os.kill(chosen, signal.SIGSTOP)
            over.wait(draw.uniform(*STOPPED_S))
            os.kill(chosen, signal.SIGCONT)


def list_children(parent: int) -> list[int]:
    """Return the processes that a process started (Linux)."""
    try:
        return [int(each) for each in Path(f"/proc/{parent}/task/{parent}/children").read_text().split()]
    except OSError:
        return []


def describe(row: Run) -> str:
    """Return a run as one line."""
    failed: list[str] = row["failed"]
    kind = f"{row['busy']} busy loops" if row["busy"] else "quiet"
    kind += ", workers stopped" if row["stop"] else ""
    counts = f"{row.get('passed', 0)} passed, {len(failed)} failed, {row.get('skipped', 0)} skipped"
    times = f"{row['clock_s']} s by the clock, {row['processor_s']} s of processor time"
    return f"{kind}: exit status {row['rc']}, {counts}, {times} {' '.join(failed)}".rstrip()


if __name__ == "__main__":
    sys.exit(main())
