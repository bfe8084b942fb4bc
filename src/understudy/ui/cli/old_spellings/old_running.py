"""Old spellings: `run` on robots or over a recording, `falsify` on a body of one's own, and `export data`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from understudy.addons.bridges.environments.body_maker import find_world
from understudy.errors import SettingError
from understudy.sim.scenario.schema import Scenario
from understudy.ui.cli.commands.export_data import export_dataset, export_table
from understudy.ui.cli.commands.falsify import (
    check_settings,
    falsify_in_scenario,
    find_tested_property,
    report_search,
)
from understudy.ui.cli.commands.falsify_body import falsify_body
from understudy.ui.cli.commands.replay import replay_recording
from understudy.ui.cli.commands.run import run_behavior
from understudy.ui.cli.commands.run_robot import run_on_twin
from understudy.ui.cli.export_options import ExportDatasetOptions, ExportTableOptions, TableName
from understudy.ui.cli.falsify_options import FalsifyBodyOptions, FalsifyOptions, GoalName
from understudy.ui.cli.old_spellings import OldOptions, RobotFileOption, TeamFileOption
from understudy.ui.cli.options import WORLD, CommandOptions, NoRecording, choose_options
from understudy.ui.cli.robot_connection import connect_twin, find_robots_file
from understudy.ui.cli.run_options import ReplayOptions, RobotRunOptions, SimulatedRunOptions

OF_WORLDS = ("seed", "speed", "trace")
"""Options that do not apply to real robots; their files name their worlds."""
NOT_OF_RECORDINGS = (
    "scenario", "world", "seed", "seconds", "speed", "record", "trace", "robot", "team", "no_record",
)  # fmt: skip
"""Options that do not apply to recordings; of several that are given, the first is refused."""


class OldRunOptions(OldOptions, SimulatedRunOptions):
    """Run a behavior in a world or on real robots, or decide again over a recording."""

    replay: Annotated[Path | None, typer.Option("--replay", metavar="FILE.mcap")] = None
    robot: RobotFileOption = None
    team: TeamFileOption = None
    no_record: NoRecording = False


def old_run(options: OldRunOptions) -> None:
    """Run a behavior in a world or on real robots, or decide again over a recording."""
    if options.replay is not None:
        remedy = "leave it out"
        problem = "is not used with --replay"
        options.refuse_given(NOT_OF_RECORDINGS, where="run", problem=problem, remedy=remedy)
        library = options.library if options.is_given("library") else None
        replay_recording(choose_options(ReplayOptions, options, recording=options.replay, library=library))
        return
    file = find_robots_file(options.robot, options.team, world=options.scenario or options.world)
    if file is None:
        run_behavior(choose_options(SimulatedRunOptions, options))
        return
    options.refuse_given(
        OF_WORLDS, where="run", problem="is not used with real robots", remedy="leave it out"
    )
    record, recorded = options.record, not options.no_record
    with connect_twin(options.robot, options.team, record=record, recorded=recorded) as twin:
        run_on_twin(twin, choose_options(RobotRunOptions, options, file=file, record=None))


class OldFalsifyOptions(FalsifyOptions):
    """Look for worlds in which a behavior fails, in a scenario or on a body of the user's own."""

    goal: GoalName = None


def old_falsify(options: OldFalsifyOptions) -> None:
    """Look for worlds in which a behavior fails, in a scenario or on a body of the user's own."""
    check_settings(options)
    subject = find_tested_property(options)
    named = options.world or (WORLD if subject is None else subject.start.world)
    opened = find_world(named)
    if isinstance(opened, Scenario):
        if options.goal is not None:
            problem = f"is {options.goal!r:.60}, and a scenario has a goal of its own"
            remedy = "leave it out, or name a property of the library's file with --property"
            raise _refuse("--goal", problem, remedy)
        report_search(falsify_in_scenario(options, opened, named, subject), as_json=options.as_json)
    if options.tested is not None:
        problem = f"is {options.tested!r:.60}, and properties are those of scenarios"
        raise _refuse("--property", problem, "name a flag or a reading with --goal")
    if options.vary:
        problem = f"is given, and {opened.name} makes a body whose worlds are known by their seeds only"
        raise _refuse("--vary", problem, "leave it out")
    of_body = choose_options(FalsifyBodyOptions, options, world=named)
    report_search(falsify_body(of_body, opened), as_json=options.as_json)


def _refuse(option: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where="falsify", setting=option, problem=problem, remedy=remedy)


class OldExportDataOptions(CommandOptions):
    """Export the data of a lesson, a session or a run as a table, or of runs as a data set of demonstrations."""

    sources: Annotated[list[Path], typer.Argument(metavar="SOURCE...")]
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE")]
    table: TableName = None
    to: Annotated[str | None, typer.Option("--to", metavar="FORMAT")] = None


def old_export_data(options: OldExportDataOptions) -> None:
    """Export the data of a lesson, a session or a run as a table, or of runs as a data set of demonstrations."""
    sources, out, as_json = options.sources, options.out, options.as_json
    if options.to is not None:
        if options.table is not None:
            problem, remedy = "does not go with --to, which writes whole episodes", "leave out one of them"
            raise SettingError(where="export data", setting="--table", problem=problem, remedy=remedy)
        export_dataset(ExportDatasetOptions(sources=sources, to=options.to, out=out, as_json=as_json))
        return
    if len(sources) > 1:
        problem, remedy = "is one source too many for a table", "name one, or give --to for a data set"
        raise SettingError(where="export data", setting=str(sources[1]), problem=problem, remedy=remedy)
    export_table(ExportTableOptions(source=sources[0], out=out, table=options.table, as_json=as_json))
