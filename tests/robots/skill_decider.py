"""A program that drives the rover of `tests.robots.test_skills` by its skill, until it is killed or frozen.

python -m tests.robots.skill_decider FILE
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from understudy.robots.robot import connect_robot_body
from understudy.robots.robot_file import load_robot


def main(path: str) -> None:
    with connect_robot_body(load_robot(path), path=Path(path)) as robot:
        number, issued = float(robot.index_skill("go_to", {"A": "dock"})), 1.0
        while robot.senses.find_missing(robot.now_s) or robot.skills.find_problems():
            time.sleep(0.02)
        robot.arm("a test")
        until = time.monotonic() + 60
        while time.monotonic() < until:
            robot.sense([])
            robot.act({"skill": np.array([number]), "issued": np.array([issued])})
            if not robot.skills.drives:
                break
            sys.stdout.write(".\n")
            sys.stdout.flush()
            time.sleep(robot.tick_s)


if __name__ == "__main__":
    main(*sys.argv[1:])
