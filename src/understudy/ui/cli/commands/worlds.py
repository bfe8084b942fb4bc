"""Command `understudy worlds`: list the built-in scenarios, print the file of one, or describe a body of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

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
    from understudy.runtime.body import Channel, Reading


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
        made.add_row(row["name"], str(row["robots"]), row["about"])
    make_console().print(made)
    for body in list_bodies():
        make_console().print(f"[dim]A body of an installed package: understudy worlds {body}[/]")
    make_console().print("[dim]A file of your own: understudy worlds forage > mine.toml[/]")


def _summarize(scenario: Scenario) -> dict[str, Any]:
    """Summarize a scenario: its purpose, and the features, behaviors and targets of its robots."""
    kit = make_scenario_kit(scenario)
    return {
        "name": scenario.name,
        "robots": make_world_params(scenario).robots,
        "about": scenario.about,
        "goal": scenario.goal is not None,
        "limit_s": scenario.limit_s,
        "features": list(kit.features),
        "behaviors": list(kit.behaviors),
        "targets": list(kit.targets),
    }


def _summarize_body(maker: BodyMaker) -> dict[str, Any]:
    """Make a body and summarize what it offers; features and behaviors are those of its kit, none if it has no kit."""
    body = maker(0)
    try:
        kit = getattr(body, "kit", None)
        kit = kit if isinstance(kit, Kit) else Kit.from_parts()
        return {
            "name": maker.name,
            "robots": body.agents,
            "tick_s": body.tick_s,
            "readings": [_describe_part(each, of_targets=each.of_targets) for each in body.readings],
            "channels": [_describe_part(each, of_targets=False) for each in body.channels],
            "targets": list(body.targets),
            "features": list(kit.features),
            "behaviors": list(kit.behaviors),
        }
    finally:
        close_body(body)


def _describe_part(part: Reading | Channel, *, of_targets: bool) -> dict[str, Any]:
    return {"name": part.name, "unit": part.unit, "about": part.doc, "of_targets": of_targets}


def _show_body(body: Mapping[str, Any]) -> None:
    """Print what a body offers as a table."""
    out, table = make_console(), make_table("", "name", "unit", "about")
    table.columns[-1].no_wrap = False
    for each in body["readings"]:
        name = f"{each['name']}(…)" if each["of_targets"] else each["name"]
        table.add_row("reading", name, each["unit"], each["about"])
    for each in body["channels"]:
        table.add_row("channel", each["name"], each["unit"], escape(each["about"]))
    for sort in ("target", "feature", "behavior"):
        for name in body[f"{sort}s"]:
            table.add_row(sort, name, "", "")
    robots = format_count(body["robots"], "robot")
    out.print(f"[bold]{body['name']}[/]: {robots}, a tick of {body['tick_s']:g} s", soft_wrap=True)
    out.print(table)
    if not body["behaviors"]:
        out.print(
            "[dim]It has no kit of features and behaviors: give one with --kit MODULE:NAME[/]", soft_wrap=True
        )
