"""Commands for the files of robots that import little: `understudy robots stop`, `stops` and `layout`."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import typer

from understudy.addons.robots.robot_file import list_robot_files, load_robot
from understudy.addons.robots.safety import emergency_stop
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import make_console
from understudy.ui.cli.robots_options import RobotsStopOptions


def stop_robots(options: RobotsStopOptions) -> None:
    """Stop a robot or a team, whatever program is driving it."""

    def stopped(path: Path) -> RobotStopResult:
        robot = load_robot(path)
        heard = emergency_stop.send_emergency_stop(robot, path=path, by="robots stop")
        return RobotStopResult(robot.name, robot.domain, robot.topic(robot.commands.topic), heard)

    files = list_robot_files(options.file)
    with ThreadPoolExecutor(
        len(files)
    ) as all_at_once:  # a file that is wrong keeps no other from being stopped
        stops = [all_at_once.submit(stopped, each) for each in files]
    found, out = [each.result() for each in stops], make_console()
    if options.as_json:
        print_json({"robots": found})
    for each in () if options.as_json else found:
        out.print(f"{each.name}: stop was sent on {each.topic}.", markup=False)
        if not each.heard:
            out.print("Nothing was heard of the robot: look whether it stands.", markup=False)
    if not all(each.heard for each in found):
        raise typer.Exit(1)


@dataclass(frozen=True, slots=True)
class RobotStopResult:
    """Record that a stop was sent to a robot; `heard` is True if any message came from the robot."""

    name: str
    domain: int
    topic: str
    heard: bool
