"""Orders of a person to arm robots. Arming takes a while, and a stop that comes after the order cancels it."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack

from understudy.addons.robots.robot import Robot
from understudy.addons.robots.safety.guard import ArmingRefused


class ArmingOrder:
    """The order of the person `by` to arm robots, at the moment at which it is made.

    It may be carried out in another thread than stops are given in: a stop of one of the robots since that moment
    wins, whether arming has begun or not.
    """

    def __init__(self, robots: Sequence[Robot], by: str) -> None:
        self._robots, self._by = tuple(robots), by
        self._stop_counts = [robot.stop_count for robot in robots]

    def carry_out(self) -> None:
        """Arm all robots, or none: if one raises an exception, the others are disarmed and it is raised.

        They are prepared first, in parallel.
        """
        with ThreadPoolExecutor(len(self._robots)) as side_by_side:
            for each in [side_by_side.submit(robot.prepare) for robot in self._robots]:
                each.result()
        try:
            for robot, count in zip(self._robots, self._stop_counts, strict=True):
                robot.arm(self._by, stop_count=count)
        except BaseException:
            with ExitStack() as each_one:
                for robot in reversed(self._robots):
                    each_one.callback(robot.disarm, "another robot of the team could not be armed")
            raise

    def refuse_overtaken(self) -> None:
        """Raise ArmingRefused if one of the robots was stopped since the order."""
        for robot, count in zip(self._robots, self._stop_counts, strict=True):
            if robot.stop_count != count:
                problem, remedy = "it was stopped meanwhile", "arm again"
                raise ArmingRefused(robot=robot.file.name, problem=problem, remedy=remedy)
