"""A program that drives the rover of `tests.robots.skill_rigs` by its skill, until it is killed or frozen.

python -m tests.robots.skill_decider FILE

On a busy machine, its guard or its watchdog may stop the robot: then the program begins again.
"""

from __future__ import annotations

import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np

from understudy.addons.robots.robot import connect_robot_body
from understudy.addons.robots.robot_file import load_robot
from understudy.addons.robots.safety.guard import ArmingRefused


def main(path: str) -> None:
    with connect_robot_body(load_robot(path), path=Path(path)) as robot:
        number, issued = float(robot.index_skill("go_to", {"A": "dock"})), 1.0
        while robot.senses.find_missing(robot.now_s) or robot.skills.find_problems():
            time.sleep(0.02)
        while True:
            if not robot.armed:
                with suppress(ArmingRefused):  # its sensors were not heard for a while
                    robot.arm("a test")
            robot.sense([])
            if not robot.skills.drives:
                issued += 1
            robot.act({"skill": np.array([number]), "issued": np.array([issued])})
            time.sleep(robot.tick_s)


if __name__ == "__main__":
    main(*sys.argv[1:])
