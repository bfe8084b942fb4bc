"""Command `understudy robots stops`: show when and why a robot was stopped."""

from __future__ import annotations

from understudy.addons.robots.robot_file import load_robot
from understudy.addons.robots.safety.stop_log import find_stop_log, read_stops
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import make_console, make_table
from understudy.ui.cli.robots_options import RobotStopsOptions


def show_stops(options: RobotStopsOptions) -> None:
    """Show when and why a robot stopped itself or was stopped."""
    robot = load_robot(options.file)
    log = find_stop_log(robot, options.file)
    found = [each for each in read_stops(log) if each.robot == robot.name][-options.last :]
    if options.as_json:
        print_json({"robot": robot.name, "log": log, "stops": found})
        return
    out = make_console()
    if not found:
        out.print(f"{log}: {robot.name} has never been stopped.", markup=False)
        return
    made = make_table("time", "by", "~cause")
    for each in found:
        made.add_row(f"{each.time.astimezone():%Y-%m-%d %H:%M:%S}", each.by, each.cause)
    out.print(made)
