"""`understudy run`: watch robots do what they were taught, or draw what they did."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from understudy.ui.cli.options import (
    LIBRARY,
    BehaviorName,
    Bind,
    Json,
    KitName,
    LibraryOption,
    SameWorld,
    ScenarioName,
)
from understudy.ui.cli.robot_options import NoRecording, RobotFileOption, TeamFileOption
from understudy.ui.cli.robot_options import find_robots_file as real


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """The options that mean something in every mode of `understudy run`; those of a mode are fields of its class."""

    behavior: str | None
    bind: list[str] | None
    kit: str | None
    as_json: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedRunOptions(RunOptions):
    """The options of a run in a simulated world."""

    scenario: str | None
    world: str | None
    seed: int
    seconds: float | None
    speed: float
    record: Path | None
    trace: Path | None
    library: Path


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotRunOptions(RunOptions):
    """The options of a run on real robots."""

    REFUSAL: ClassVar[str] = "is not used with real robots"
    robot: Path | None
    team: Path | None
    record: Path | None
    no_record: bool
    seconds: float | None
    library: Path


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayOptions(RunOptions):
    """The options of deciding again over a recording; None for what is as it was recorded."""

    REFUSAL: ClassVar[str] = "is not used with --replay"
    replay: Path
    library: Path | None


def _names(*modes: type[RunOptions]) -> dict[str, None]:
    """The options of modes, each once."""
    return dict.fromkeys(each.name for mode in modes for each in fields(mode))


OPTIONS = tuple(_names(SimulatedRunOptions, RobotRunOptions, ReplayOptions))
"""All options. Of several that mean nothing in a mode, the first here is refused."""


def run_behavior(
    context: typer.Context,
    scenario: ScenarioName = None,
    behavior: BehaviorName = None,
    library: LibraryOption = LIBRARY,
    world: SameWorld = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Which world.")] = 0,
    record: Annotated[
        Path | None,
        typer.Option(
            "--record", "-r", metavar="OUT.gif|png|mcap", help="Draw it, or record it, instead of showing it."
        ),
    ] = None,
    trace: Annotated[
        Path | None,
        typer.Option("--trace", metavar="OUT.jsonl|OUT.parquet", help="Keep where robots were, doing what."),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds",
            min=0.1,
            max=86_400,
            help="End after so much simulated time, not at the scenario's limit.",
            show_default=False,
        ),
    ] = None,
    speed: Annotated[
        float, typer.Option("--speed", min=0.1, max=1000, help="Times as fast as in life.")
    ] = 8.0,
    replay: Annotated[
        Path | None,
        typer.Option(
            "--replay",
            metavar="FILE.mcap",
            help="Decide again over a recording, and show where decisions differ.",
            show_default=False,
        ),
    ] = None,
    bind: Bind = None,
    robot: RobotFileOption = None,
    team: TeamFileOption = None,
    no_record: NoRecording = False,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Run a behavior in a scenario's world, on all robots that know it: watch it in the terminal, or draw a GIF or PNG.

    Behaviors are those of the library, and the basic ones of the scenario's robots.

    [dim]understudy run --library demo/library --behavior forage --seed 7[/]

    [dim]understudy run --behavior goto --bind A=station --record goto.gif[/]

    [dim]understudy run patrol --behavior forwards --seconds 20[/]

    [dim]understudy run --record run.mcap[/], then [dim]understudy run --replay run.mcap --library corrected[/]

    [dim]understudy run --robot rover.toml --behavior servo[/]

    What a squad was taught (in a folder of the squad's name) is run by its coordinators. Where types of robots differ,
    each has a folder of its name, too; SORT/BEHAVIOR says whose behavior is meant.
    """
    if replay is not None:
        from understudy.ui.cli.commands.run_replay import run_replay

        _refuse_meaningless(context, ReplayOptions)
        run_replay(
            ReplayOptions(
                replay=replay,
                behavior=behavior,
                library=library if _given(context, "library") else None,
                bind=bind,
                kit=kit,
                as_json=as_json,
            )
        )
    elif real(robot, team, world=scenario or world) is not None:
        from understudy.ui.cli.commands.run_robot import run_robots

        _refuse_meaningless(context, RobotRunOptions)
        run_robots(
            RobotRunOptions(
                robot=robot,
                team=team,
                record=record,
                no_record=no_record,
                seconds=seconds,
                behavior=behavior,
                library=library,
                bind=bind,
                kit=kit,
                as_json=as_json,
            )
        )
    else:
        from understudy.ui.cli.commands.run_simulated import run_simulated

        run_simulated(
            SimulatedRunOptions(
                scenario=scenario,
                world=world,
                seed=seed,
                seconds=seconds,
                speed=speed,
                record=record,
                trace=trace,
                behavior=behavior,
                library=library,
                bind=bind,
                kit=kit,
                as_json=as_json,
            )
        )


def _given(context: typer.Context, option: str) -> bool:
    """Whether somebody gave an option, be it what it is otherwise."""
    source = context.get_parameter_source(option)
    return source is not None and source.name == "COMMANDLINE"


def _refuse_meaningless(context: typer.Context, mode: type[RobotRunOptions | ReplayOptions]) -> None:
    """Refuse the first option that was given and means nothing in a mode."""
    from understudy.errors import SettingError

    meant = _names(mode)
    for option in OPTIONS:
        if option not in meant and _given(context, option):
            named = "SCENARIO" if option == "scenario" else f"--{option.replace('_', '-')}"
            raise SettingError(where="run", setting=named, problem=mode.REFUSAL, remedy="leave it out")
