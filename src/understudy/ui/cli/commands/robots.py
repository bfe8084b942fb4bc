"""Commands `understudy robots`: check real robots before they move, stop them, and list their stops."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.ui.cli.commands import robots_color, robots_layout, robots_simulate
from understudy.ui.cli.options import Json

if TYPE_CHECKING:
    from understudy.robots.diagnostics import ConnectionReport


RobotOf = Annotated[Path, typer.Argument(metavar="FILE", help="File of the robot.", show_default=False)]


def stop_robots(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="File of a robot or a team.", show_default=False)
    ],
    as_json: Json = False,
) -> None:
    """Stop a robot or a team, whatever program is driving it.

    The stop command is sent for two seconds, and an Understudy program that drives the robot is disarmed. The exit
    code is 1 if no message came from a robot.

    [dim]understudy robots stop rover.toml[/]
    """
    from concurrent.futures import ThreadPoolExecutor

    from understudy.robots.robot_file import list_robot_files, load_robot
    from understudy.robots.safety import emergency_stop
    from understudy.ui.cli.output import make_console, print_json

    def stopped(path: Path) -> RobotStopResult:
        robot = load_robot(path)
        heard = emergency_stop.send_emergency_stop(robot, path=path, by="robots stop")
        return RobotStopResult(robot.name, robot.domain, robot.topic(robot.commands.topic), heard)

    files = list_robot_files(file)
    with ThreadPoolExecutor(
        len(files)
    ) as all_at_once:  # a file that is wrong keeps no other from being stopped
        stops = [all_at_once.submit(stopped, each) for each in files]
    found, out = [each.result() for each in stops], make_console()
    if as_json:
        print_json({"robots": found})
    for each in () if as_json else found:
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


def show_stops(
    file: RobotOf,
    last: Annotated[int, typer.Option(help="Number of stops to show, newest last.", min=1)] = 20,
    as_json: Json = False,
) -> None:
    """Show when and why a robot stopped itself or was stopped.

    [dim]understudy robots stops rover.toml[/]
    """
    from understudy.robots.robot_file import load_robot
    from understudy.robots.safety.stop_log import find_stop_log, read_stops
    from understudy.ui.cli.output import make_console, make_table, print_json

    robot = load_robot(file)
    log = find_stop_log(robot, file)
    found = [each for each in read_stops(log) if each.robot == robot.name][-last:]
    if as_json:
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


NOTHING = 1e-6
"""Magnitude below which values are shown as 0, to hide rounding errors."""

app = typer.Typer(
    no_args_is_help=True, help="Check and stop real robots, calibrate their cameras, and simulate them."
)


@app.callback()
def introduce_robots() -> None:
    """Check and stop real robots, calibrate their cameras, and simulate them."""


app.command("color")(robots_color.calibrate_color)
app.command("simulate")(robots_simulate.simulate_robots)


@app.command("check")
def check_robots(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="File of a robot or a team.", show_default=False)
    ],
    seconds: Annotated[float, typer.Option(help="Time to listen, in seconds.", min=0.1, max=600.0)] = 3.0,
    as_json: Json = False,
) -> None:
    """Connect to robots and show which readings arrive, their rate and age, and what is missing.

    No robot moves. The exit code is 1 if there is a problem.

    [dim]understudy robots check rover.toml[/]
    """
    from time import sleep

    from understudy.robots.diagnostics import diagnose_connection
    from understudy.robots.fleet import connect_robot, connect_team
    from understudy.robots.robot_file import is_team_file
    from understudy.ui.cli.output import print_json

    team = is_team_file(file)
    with connect_team(file) if team else connect_robot(file) as fleet:
        sleep(seconds)
        found = [diagnose_connection(robot, seconds=seconds) for robot in fleet]
    if as_json:
        print_json({"robots": found} if team else found[0])
    else:
        for each in found:
            _show(each)
    if any(each.problems for each in found):
        raise typer.Exit(1)


app.command("layout")(robots_layout.write_layout)
app.command("stop")(stop_robots)
app.command("stops")(show_stops)


def _show(found: ConnectionReport) -> None:
    from understudy.errors import join_names
    from understudy.ui.cli.output import make_console, make_table

    made = make_table("reading", "#rate", "#age", "~value", "~topic", title=found.name)
    for each in found.arrivals:
        made.add_row(
            each.name + "*" * each.required,
            _measured(each.rate_hz, "Hz"),
            _measured(each.age_s, "s"),
            _values(each.values, each.unit),
            each.topic,
        )
    out = make_console()
    out.print(made)
    if any(each.required for each in found.arrivals):
        out.print("* required: the robot stops without it.", markup=False)
    for problem in found.problems:
        out.print(problem, markup=False)
    if found.lacks:
        out.print(f"Lessons that ask for {join_names(found.lacks)} find that absent.", markup=False)
    if not found.problems:
        out.print(f"{found.name}: all is there.", markup=False)


def _values(values: Mapping[str, float], unit: str) -> str:
    """Format one value with its unit, or the present values grouped by target: ball x 80, size 120 px."""
    if len(values) == 1:
        return _measured(next(iter(values.values())), unit)
    seen: dict[str, list[str]] = {}
    for name, value in values.items():
        if not isnan(value):
            what, _, target = name.removesuffix(")").partition("(")
            seen.setdefault(target, []).append(f"{what.removeprefix('blob_')} {value:.3g}")
    return (
        ", ".join(f"{name} {', '.join(each)} {unit}" for name, each in seen.items())
        or "detects no known color"
    )


def _measured(value: float, unit: str) -> str:
    if isnan(value):
        return "absent"
    return f"{0.0 if abs(value) < NOTHING else value:.3g} {unit}".rstrip()
