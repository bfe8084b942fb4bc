"""`understudy robots stop` and `robots stops`: stop a robot from anywhere; when and why it stopped."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from understudy.ui.cli.options import Json

RobotOf = Annotated[Path, typer.Argument(metavar="FILE", help="The robot's file.", show_default=False)]


def stop(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="The file of a robot, or of a team.", show_default=False)
    ],
) -> None:
    """Stop a robot, or a team, whoever drives it: stop is sent for two seconds, and a program of ours that drives it is
    disarmed.

    Ends with exit code 1 where nothing was heard of a robot.

    [dim]understudy robots stop rover.toml[/]
    """
    from concurrent.futures import ThreadPoolExecutor

    from understudy.robots.robot_file import load_robot, robots_in
    from understudy.robots.safety import emergency_stop
    from understudy.ui.cli.output import console

    def stopped(path: Path) -> tuple[str, bool]:
        robot = load_robot(path)
        there = emergency_stop.halt(robot, path=path, by="robots stop")
        return f"{robot.name}: stop was sent on {robot.topic(robot.commands.topic)}.", there

    files = robots_in(file)
    with ThreadPoolExecutor(
        len(files)
    ) as all_at_once:  # a file that is wrong keeps no other from being stopped
        stops = [all_at_once.submit(stopped, each) for each in files]
    out = console()
    for said, there in [each.result() for each in stops]:
        out.print(said, markup=False)
        if not there:
            out.print("Nothing was heard of the robot: look whether it stands.", markup=False)
    if not all(each.result()[1] for each in stops):
        raise typer.Exit(1)


def stops(
    file: RobotOf,
    last: Annotated[int, typer.Option(help="Show so many, the newest.", min=1)] = 20,
    as_json: Json = False,
) -> None:
    """Show when a robot stopped by itself or was stopped, and why.

    [dim]understudy robots stops rover.toml[/]
    """
    from understudy.robots.robot_file import load_robot
    from understudy.robots.safety.stop_log import log_path, read_stops
    from understudy.ui.cli.output import console, print_json, table

    robot = load_robot(file)
    log = log_path(robot, file)
    found = [each for each in read_stops(log) if each.robot == robot.name][-last:]
    if as_json:
        print_json(found)
        return
    out = console()
    if not found:
        out.print(f"{log}: {robot.name} has never been stopped.", markup=False)
        return
    made = table("time", "by", "~cause")
    for each in found:
        made.add_row(f"{each.time.astimezone():%Y-%m-%d %H:%M:%S}", each.by, each.cause)
    out.print(made)
