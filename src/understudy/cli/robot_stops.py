"""`understudy robots stop` and `robots stops`: stop a robot from anywhere; when and why it stopped."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from understudy.cli.parts import Json

RobotOf = Annotated[Path, typer.Argument(metavar="FILE", help="The robot's file.", show_default=False)]


def stop(file: RobotOf) -> None:
    """Stop a robot, whoever drives it: stop is sent for two seconds, and a program of ours that drives it is disarmed.

    Ends with exit code 1 where nothing was heard of the robot.

    [dim]understudy robots stop rover.toml[/]
    """
    from understudy.cli.output import console
    from understudy.robots.file import load_robot
    from understudy.robots.halt import halt

    robot = load_robot(file)
    there = halt(robot, path=file, by="robots stop")
    topic, out = robot.topic(robot.commands.topic), console()
    out.print(f"{robot.name}: stop was sent on {topic}.", markup=False)
    if not there:
        out.print("Nothing was heard of the robot: look whether it stands.", markup=False)
        raise typer.Exit(1)


def stops(
    file: RobotOf,
    last: Annotated[int, typer.Option(help="Show so many, the newest.", min=1)] = 20,
    as_json: Json = False,
) -> None:
    """Show when a robot stopped by itself or was stopped, and why.

    [dim]understudy robots stops rover.toml[/]
    """
    from understudy.cli.output import console, print_json, table
    from understudy.robots.file import load_robot
    from understudy.robots.stops import log_path, read_stops

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
