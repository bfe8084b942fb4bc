"""Command `understudy worlds`: list the built-in scenarios, print the file of one, or describe a body of one's own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import typer
from rich.markup import escape

from understudy.addons.bridges.environments.body_maker import find_world
from understudy.errors import UnderstudyError
from understudy.model.library import Kit
from understudy.runtime.body import close_body
from understudy.sim.catalog import find_scenario, is_function, list_bodies, list_scenarios
from understudy.sim.kit import make_scenario_kit
from understudy.sim.params import make_world_params
from understudy.sim.scenario.files import format_scenario, read_scenario_text
from understudy.sim.scenario.schema import Scenario
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import format_count, make_console, make_table
from understudy.ui.cli.run_options import WorldsOptions

if TYPE_CHECKING:
    from understudy.addons.bridges.environments.body_maker import BodyMaker


def list_worlds(options: WorldsOptions) -> None:
    """List the built-in scenarios and those of installed packages, or print the file of one to copy and change."""
    if options.name is not None:
        scenario = find_world(options.name)
        if not isinstance(scenario, Scenario):
            summary = _summarize_body(scenario)
            if options.as_json:
                print_json(summary)
            else:
                _show_body(summary)
            return
        if options.as_json:
            print_json(scenario)
        else:
            typer.echo(
                format_scenario(scenario) if is_function(options.name) else read_scenario_text(options.name),
                nl=False,
            )
        return
    rows = []
    for each in list_scenarios():
        try:
            rows.append(_summarize(find_scenario(each)))
        except UnderstudyError as error:  # a package that fails does not hide the other scenarios
            typer.echo(str(error), err=True)
    if options.as_json:
        print_json({"worlds": rows})
        return
    made = make_table("scenario", "#robots", "about")
    made.columns[-1].no_wrap = False
    for row in rows:
        made.add_row(row.name, str(row.robots), row.about)
    make_console().print(made)
    for body in list_bodies():
        make_console().print(f"[dim]A body of an installed package: understudy worlds {body}[/]")
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


@dataclass(frozen=True, kw_only=True)
class BodySummary:
    """Summary of a body of one's own; `features` and `behaviors` are those of its kit, none if it has no kit."""

    name: str
    robots: int
    tick_s: float
    readings: tuple[PartSummary, ...]
    channels: tuple[PartSummary, ...]
    targets: tuple[str, ...]
    features: tuple[str, ...]
    behaviors: tuple[str, ...]


@dataclass(frozen=True)
class PartSummary:
    """A reading or a channel of a body; `of_targets` is true for a reading of each target."""

    name: str
    unit: str
    about: str
    of_targets: bool = False


def _summarize_body(maker: BodyMaker) -> BodySummary:
    """Make a body and describe what it offers."""
    body = maker(0)
    try:
        kit = getattr(body, "kit", None)
        return BodySummary(
            name=maker.name,
            robots=body.agents,
            tick_s=body.tick_s,
            readings=tuple(
                PartSummary(each.name, each.unit, each.doc, each.of_targets) for each in body.readings
            ),
            channels=tuple(PartSummary(each.name, each.unit, each.doc) for each in body.channels),
            targets=tuple(body.targets),
            features=tuple(kit.features) if isinstance(kit, Kit) else (),
            behaviors=tuple(kit.behaviors) if isinstance(kit, Kit) else (),
        )
    finally:
        close_body(body)


def _show_body(body: BodySummary) -> None:
    """Print what a body offers as a table."""
    out, table = make_console(), make_table("", "name", "unit", "about")
    table.columns[-1].no_wrap = False
    for reading in body.readings:
        table.add_row(
            "reading",
            f"{reading.name}(…)" if reading.of_targets else reading.name,
            reading.unit,
            reading.about,
        )
    for channel in body.channels:
        table.add_row("channel", channel.name, channel.unit, escape(channel.about))
    for sort, names in (("target", body.targets), ("feature", body.features), ("behavior", body.behaviors)):
        for name in names:
            table.add_row(sort, name, "", "")
    out.print(
        f"[bold]{body.name}[/]: {format_count(body.robots, 'robot')}, a tick of {body.tick_s:g} s",
        soft_wrap=True,
    )
    out.print(table)
    if not body.behaviors:
        out.print(
            "[dim]It has no kit of features and behaviors: give one with --kit MODULE:NAME[/]", soft_wrap=True
        )
