"""Command `understudy run`: run a behavior in a simulation, on real robots, or over a recording."""

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
    """Options that apply to every mode of `understudy run`; subclasses add those of one mode."""

    behavior: str | None
    bind: list[str] | None
    kit: str | None
    as_json: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedRunOptions(RunOptions):
    """Options of a run in a simulated world."""

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
    """Options of a run on real robots."""

    REFUSAL: ClassVar[str] = "is not used with real robots"
    robot: Path | None
    team: Path | None
    record: Path | None
    no_record: bool
    seconds: float | None
    library: Path


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayOptions(RunOptions):
    """Options of `--replay`, which decides again over a recording; None means as recorded."""

    REFUSAL: ClassVar[str] = "is not used with --replay"
    replay: Path
    library: Path | None


def _names(*modes: type[RunOptions]) -> dict[str, None]:
    """Return the option names of several modes, each once."""
    return dict.fromkeys(each.name for mode in modes for each in fields(mode))


OPTIONS = tuple(_names(SimulatedRunOptions, RobotRunOptions, ReplayOptions))
"""Names of all options; of several that do not apply in a mode, the first here is refused."""


def run_behavior(
    context: typer.Context,
    scenario: ScenarioName = None,
    behavior: BehaviorName = None,
    library: LibraryOption = LIBRARY,
    world: SameWorld = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the world.")] = 0,
    record: Annotated[
        Path | None,
        typer.Option(
            "--record", "-r", metavar="OUT.gif|png|mcap", help="Draw or record the run instead of showing it."
        ),
    ] = None,
    trace: Annotated[
        Path | None,
        typer.Option(
            "--trace", metavar="OUT.jsonl|OUT.parquet", help="Save the positions and states of the robots."
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds",
            min=0.1,
            max=86_400,
            help="End after this time (simulated seconds) instead of the scenario's limit.",
            show_default=False,
        ),
    ] = None,
    speed: Annotated[
        float, typer.Option("--speed", min=0.1, max=1000, help="Playback speed, as a multiple of real time.")
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
    """Run a behavior in a scenario's world, on all robots that have it, and show, draw or record the run.

    Behaviors are the automata of the library, and the basic behaviors of the scenario's robots.

    [dim]understudy run --library demo/library --behavior forage --seed 7[/]

    [dim]understudy run --behavior goto --bind A=station --record goto.gif[/]

    [dim]understudy run patrol --behavior forwards --seconds 20[/]

    [dim]understudy run --record run.mcap[/], then [dim]understudy run --replay run.mcap --library corrected[/]

    [dim]understudy run --robot rover.toml --behavior servo[/]

    The automata of a squad are in a subfolder of the squad's name, and its coordinators run them. If robot types
    differ, each has a subfolder of its name, too. SORT/BEHAVIOR selects the behavior of one squad or type.
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
    """Return whether an option was given on the command line."""
    source = context.get_parameter_source(option)
    return source is not None and source.name == "COMMANDLINE"


def _refuse_meaningless(context: typer.Context, mode: type[RobotRunOptions | ReplayOptions]) -> None:
    """Refuse the first option that was given but does not apply in this mode."""
    from understudy.errors import SettingError

    meant = _names(mode)
    for option in OPTIONS:
        if option not in meant and _given(context, option):
            named = "SCENARIO" if option == "scenario" else f"--{option.replace('_', '-')}"
            raise SettingError(where="run", setting=named, problem=mode.REFUSAL, remedy="leave it out")
