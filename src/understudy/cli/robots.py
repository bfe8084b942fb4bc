"""`understudy robots`: real robots, looked at before they move, and stopped."""

from __future__ import annotations

from collections.abc import Mapping
from math import isnan
from pathlib import Path
from typing import Annotated

import typer

from understudy.cli import robot_color, robot_simulate, robot_stops
from understudy.cli.parts import Json

app = typer.Typer(no_args_is_help=True, help="Look at real robots and at what their cameras see; stop them.")


@app.callback()
def robots() -> None:
    """Look at real robots and at what their cameras see; stop them."""


app.command("color")(robot_color.color)
app.command("simulate")(robot_simulate.simulate)


@app.command("check")
def check(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The robot's file.", show_default=False)],
    seconds: Annotated[float, typer.Option(help="Listen so long.", min=0.1, max=600.0)] = 3.0,
    as_json: Json = False,
) -> None:
    """Connect to a robot and show what arrives, at what rate and age, and what is missing. Nothing moves.

    Ends with exit code 1 where something is wrong.

    [dim]understudy robots check rover.toml[/]
    """
    from understudy.cli.output import console, print_json, table
    from understudy.errors import listed
    from understudy.robots.body import connect
    from understudy.robots.file import load_robot
    from understudy.robots.survey import survey

    with connect(load_robot(file), path=file) as robot:
        found = survey(robot, seconds=seconds)
    if as_json:
        print_json(found)
    else:
        made = table("reading", "#rate", "#age", "~value", "~topic")
        for each in found.arrivals:
            made.add_row(
                each.name + "*" * each.required,
                _measured(each.rate_hz, "Hz"),
                _measured(each.age_s, "s"),
                _values(each.values, each.unit),
                each.topic,
            )
        out = console()
        out.print(made)
        if any(each.required for each in found.arrivals):
            out.print("* required: the robot stops without it.", markup=False)
        for problem in found.problems:
            out.print(problem, markup=False)
        if found.lacks:
            out.print(f"Lessons that ask for {listed(found.lacks)} find that absent.", markup=False)
        if not found.problems:
            out.print(f"{found.name}: all is there.", markup=False)
    if found.problems:
        raise typer.Exit(1)


app.command("stop")(robot_stops.stop)
app.command("stops")(robot_stops.stops)


def _values(values: Mapping[str, float], unit: str) -> str:
    """The one value, or each that is there with its name."""
    if len(values) == 1:
        return _measured(next(iter(values.values())), unit)
    there = [f"{name} {_measured(value, unit)}" for name, value in values.items() if not isnan(value)]
    return ", ".join(there) or "none of its colors"


def _measured(value: float, unit: str) -> str:
    return "absent" if isnan(value) else f"{value:.3g} {unit}".rstrip()
