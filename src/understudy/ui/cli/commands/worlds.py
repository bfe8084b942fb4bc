"""Command `understudy worlds`: list the built-in scenarios, or print the file of one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.ui.cli.options import Json

if TYPE_CHECKING:
    from understudy.sim.scenario.schema import Scenario


def list_worlds(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[SCENARIO]", help="Print the file of this scenario.", show_default=False),
    ] = None,
    as_json: Json = False,
) -> None:
    """List the built-in scenarios and those of installed packages, or print the file of one to copy and change.

    [dim]understudy worlds patrol > mine.toml[/]
    """
    from understudy.errors import UnderstudyError
    from understudy.sim.catalog import is_function, list_scenarios
    from understudy.sim.scenario.files import format_scenario, read_scenario_text
    from understudy.ui.cli.options import open_scenario
    from understudy.ui.cli.output import make_console, make_table, print_json

    if name is not None:
        scenario = open_scenario(name)
        if as_json:
            print_json(scenario)
        else:
            typer.echo(format_scenario(scenario) if is_function(name) else read_scenario_text(name), nl=False)
        return
    rows = []
    for each in list_scenarios():
        try:
            rows.append(_summarize(open_scenario(each)))
        except UnderstudyError as error:  # a package that fails does not hide the other scenarios
            typer.echo(str(error), err=True)
    if as_json:
        print_json({"worlds": rows})
        return
    made = make_table("scenario", "#robots", "about")
    made.columns[-1].no_wrap = False
    for row in rows:
        made.add_row(row.name, str(row.robots), row.about)
    make_console().print(made)
    make_console().print("[dim]A file of your own: understudy worlds forage > mine.toml[/]")


@dataclass(frozen=True, kw_only=True)
class WorldSummary:
    """Summary of a scenario: its purpose, and the features, behaviors and targets of its robots."""

    name: str
    robots: int
    about: str
    goal: bool
    """Whether the scenario has a goal."""
    limit_s: float
    features: tuple[str, ...]
    behaviors: tuple[str, ...]
    targets: tuple[str, ...]


def _summarize(scenario: Scenario) -> WorldSummary:
    from understudy.sim.kit import make_scenario_kit
    from understudy.sim.params import make_world_params

    kit = make_scenario_kit(scenario)
    return WorldSummary(
        name=scenario.name,
        robots=make_world_params(scenario).robots,
        about=scenario.about,
        goal=scenario.goal is not None,
        limit_s=scenario.limit_s,
        features=tuple(kit.features),
        behaviors=tuple(kit.behaviors),
        targets=tuple(kit.targets),
    )
