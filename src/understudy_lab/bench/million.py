"""That a million robots run, and what memory they take."""

from __future__ import annotations

import sys
from pathlib import Path

from understudy_lab.bench import programs, standard_task
from understudy_lab.bench.harness import Goal, Row, result, seconds
from understudy_lab.bench.understudy_case import Ours

MILLION_ROBOTS, MILLION_THREADS, TICKS = 1_000_000, 2, 10
MOST_BYTES = 1000.0


def run_million(robots: int = MILLION_ROBOTS, ticks: int = TICKS) -> Row:
    """The full task at full size. Memory is the process's peak less what it held before the world was made."""
    Ours(
        standard_task.make_full_scenario(1_000),
        programs.make_full_library(),
        programs.FULL,
        threads=MILLION_THREADS,
    ).run(5)  # compiles
    before = held()
    subject = Ours(
        standard_task.make_full_scenario(robots),
        programs.make_full_library(),
        programs.FULL,
        threads=MILLION_THREADS,
    )
    subject.run(1)
    speed = robots * ticks / seconds(subject, ticks)
    row = {
        "task": "full",
        "robots": robots,
        "threads": MILLION_THREADS,
        "robot_ticks_per_s": speed,
        "ticks": ticks,
        "bytes_per_robot": (peak() - before) / robots,
    }
    return result([row], [Goal("bytes per robot", lambda rows: rows[0]["bytes_per_robot"], most=MOST_BYTES)])


def held() -> int:
    """Bytes of memory that the process holds now; its peak where the system does not say."""
    try:
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize()
    except (ImportError, OSError):
        return peak()


def peak() -> int:
    """Bytes of memory that the process has held at most; 0 where the system does not say (Windows)."""
    try:
        import resource
    except ImportError:
        return 0
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else most * 1024
