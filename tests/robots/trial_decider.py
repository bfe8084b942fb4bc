"""A program that decides, for trials of stopping: armed, it drives on, whatever happens to it.

It obeys lines on standard input (`arm`; `state`; `late`: miss a few ticks; `fail`, `exit` and `leave`: end in three
ways) and answers each with a line.
"""

from __future__ import annotations

import select
import signal
import sys
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from understudy.addons.robots.robot import Robot, connect_robot_body
from understudy.addons.robots.robot_file import load_robot
from understudy.errors import UnderstudyError


def obey(robot: Robot, line: str) -> str:
    if line == "arm":
        try:
            robot.arm("a trial")
        except UnderstudyError as error:
            return f"refused {error}"
        return "armed"
    if line == "state":
        return f"{'armed' if robot.armed else 'disarmed'} {robot.stop_cause}"
    if line == "late":
        time.sleep(0.5)
        return "late"
    if line == "fail":
        raise ValueError(line)
    if line == "exit":
        sys.exit("asked to")
    raise SystemExit(line)


def main(path: str) -> None:
    # Where the tests themselves run in the background or under nohup, these signals are inherited as ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    file, keys = load_robot(path), [("sonar_ahead", None)]
    robot = connect_robot_body(file, path=Path(path))
    with ExitStack() as ending:
        ending.push(robot)
        due = time.monotonic()
        while True:
            due = max(due + file.tick_s, time.monotonic())
            while select.select([sys.stdin], [], [], max(0.0, due - time.monotonic()))[0]:
                line = sys.stdin.readline().strip()
                if line == "leave":  # as nobody should: without closing
                    ending.pop_all()
                    return
                sys.stdout.write(obey(robot, line) + "\n")
                sys.stdout.flush()
            robot.sense(keys)
            robot.act({"drive": np.array([1.0])})


if __name__ == "__main__":
    main(*sys.argv[1:])
