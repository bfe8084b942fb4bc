"""A program that decides, for trials of stopping: armed, it drives on, whatever happens to it.

It obeys lines on standard input (`arm`, `act` or `rest`: whether it keeps its ticks, `stops`: what it was stopped for)
and answers each with a line.
"""

from __future__ import annotations

import select
import sys
import time
from pathlib import Path

import numpy as np

from understudy.errors import UnderstudyError
from understudy.robots.body import Robot, connect
from understudy.robots.file import load_robot


def obey(robot: Robot, line: str) -> str:
    if line == "arm":
        try:
            robot.arm("a trial")
        except UnderstudyError as error:
            return f"refused {error}"
        return "armed"
    if line == "state":
        return f"{'armed' if robot.armed else 'disarmed'} {robot.stopped}"
    raise SystemExit(line)


def main(path: str) -> None:
    file, keys = load_robot(path), [("sonar_ahead", None)]
    with connect(file, path=Path(path)) as robot:
        due = time.monotonic()
        while True:
            due = max(due + file.tick_s, time.monotonic())
            while select.select([sys.stdin], [], [], max(0.0, due - time.monotonic()))[0]:
                line = sys.stdin.readline().strip()
                sys.stdout.write(obey(robot, line or "end") + "\n")
                sys.stdout.flush()
            robot.sense(keys)
            robot.act({"drive": np.array([1.0])})


if __name__ == "__main__":
    main(*sys.argv[1:])
