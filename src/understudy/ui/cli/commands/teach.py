"""Command `understudy teach`: teach a robot with the keyboard, in the terminal."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.ui.cli.options import (
    FAILURES,
    LIBRARY,
    WORLD,
    FailuresOption,
    Json,
    KitName,
    LibraryOption,
    SameWorld,
)
from understudy.ui.cli.robot_options import NoRecording, RobotFileOption, connect_twin
from understudy.ui.cli.robot_options import find_robots_file as real

if TYPE_CHECKING:
    from pathlib import Path

    from understudy.adapters.body_maker import BodyMaker
    from understudy.model.library import Library as Opened
    from understudy.robots.twin import DigitalTwin, Ground
    from understudy.sim.scenario.schema import Scenario
    from understudy.ui.controller.training_plan import TrainingPlan


def teach(
    name: Annotated[
        str, typer.Argument(help="Name of the automaton; new, or in the library to continue its lesson.")
    ],
    world: SameWorld = None,
    library: LibraryOption = LIBRARY,
    states: Annotated[
        str | None,
        typer.Option(
            "--states", metavar="A,B(C)", help="States: basic behaviors and automata of the library."
        ),
    ] = None,
    features: Annotated[
        str | None, typer.Option("--features", metavar="A,B(C)", help="Features that decisions depend on.")
    ] = None,
    parameters: Annotated[
        str | None,
        typer.Option("--parameters", metavar="A,B", help="Parameters, to be bound to targets later."),
    ] = None,
    targets: Annotated[
        str | None,
        typer.Option("--targets", metavar="A=TARGET", help="Targets of the parameters during teaching."),
    ] = None,
    flags: Annotated[
        str | None, typer.Option("--flags", metavar="A,B", help="Flags it can raise, such as done.")
    ] = None,
    watched: Annotated[
        bool | None,
        typer.Option(
            "--watched/--plain",
            help="Learn from silence or not; as in the existing lesson, or not, if left out.",
        ),
    ] = None,
    reaction: Annotated[
        float | None,
        typer.Option(
            "--reaction",
            min=0.0,
            max=1.0,
            metavar="SECONDS",
            help="Reaction time by which presses are shifted earlier.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the world.")] = 0,
    failures: FailuresOption = FAILURES,
    robot: RobotFileOption = None,
    no_record: NoRecording = False,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Teach a robot with the keyboard: drive it by pressing behaviors, and it learns when to switch.

    The program asks for everything that is not chosen here. It works over SSH; after a lost connection, the same
    command continues the session.

    [dim]understudy teach goto --parameters A --states forward,rotate_left,rotate_right --flags done --features
    'distance_to(A),angle_to(A)' --targets A=station[/]

    [dim]understudy teach balance --world cart_pole:make[/]

    [dim]understudy teach servo --robot rover.toml[/]
    """
    from contextlib import ExitStack, closing

    from understudy.sim.body_world import BodyWorld
    from understudy.sim.scenario.schema import Scenario
    from understudy.ui.cli.options import open_world, parse_names, parse_targets
    from understudy.ui.controller.training_plan import LessonChoices, TrainingPlan, make_session_start

    choices = LessonChoices(
        states=parse_names(states),
        features=parse_names(features),
        flags=parse_names(flags),
        parameters=parse_names(parameters),
        targets=parse_targets(targets),
        watched=watched,
        reaction_s=reaction,
    )
    with ExitStack() as leaving:
        ground: Ground | None = None
        if real(robot, None, world=world) is not None:
            ground = twin = leaving.enter_context(
                connect_twin(robot, None, record=None, recorded=not no_record)
            )
            _see_hold(twin)
            opened: Scenario | BodyMaker = twin.scenario
        else:
            opened = open_world(world or WORLD)
        known = _library(library, kit, opened)
        if isinstance(opened, Scenario):
            where = opened
        else:
            ground = leaving.enter_context(closing(BodyWorld(opened, seed, name=opened.name)))
            where = ground.scenario
        plan = TrainingPlan(name, library, where, known, choices, seed)
        make_session_start(plan)
        _see_terminal()
        _teach(plan, ground, failures, as_json=as_json)


def _see_hold(twin: DigitalTwin) -> None:
    """Refuse robots that need a held key, because a terminal cannot detect when a key is released."""
    from understudy.errors import SettingError

    if twin.fleet.needs_hold_to_run:
        raise SettingError(
            where=twin.fleet.name,
            setting="safety.hold_to_run",
            problem="needs a key that is held, and a terminal does not report released keys",
            remedy="teach it in the studio: understudy studio --robot FILE",
        )


@dataclass(frozen=True, kw_only=True)
class TeachResult:
    """Result of a teaching session in the terminal."""

    name: str
    library: Path
    examples: int
    saved: bool
    journal: Path | None
    """Path of the session's journal; None if no session began."""


def _teach(plan: TrainingPlan, ground: Ground | None, failures: Path, *, as_json: bool) -> None:
    from understudy.errors import UnderstudyError
    from understudy.ui.cli.error_reporting import FAULT
    from understudy.ui.cli.output import format_count, make_console, print_json
    from understudy.ui.controller import interrupted_sessions
    from understudy.ui.tui.app import TrainerApp

    left = interrupted_sessions.find_interrupted_session(
        plan.folder, plan.name, plan.world.name, plan.library
    )
    trainer = TrainerApp(plan, unfinished=left, ground=ground, failures=failures)
    ended = trainer.run()
    plan = trainer.plan  # in a failing world another automaton may have been corrected
    if isinstance(ended, UnderstudyError):
        raise ended
    if trainer.return_code == 1:
        typer.echo(f"No examples are lost: `understudy teach {plan.name}` resumes the session.", err=True)
        raise typer.Exit(FAULT)
    if trainer.return_code:
        raise typer.Exit(trainer.return_code)
    if as_json:
        result = TeachResult(
            name=plan.name,
            library=plan.folder,
            examples=0 if ended is None else ended.examples,
            saved=ended is not None and ended.saved,
            journal=None if ended is None else ended.journal,
        )
        print_json(result)
    elif ended is None:
        make_console().print(f"Nothing was begun of {plan.name}.")
    elif ended.saved:
        make_console().print(
            f"[bold]{plan.name}[/] is in {plan.folder}, with {format_count(ended.examples, 'example')}."
        )
    else:
        make_console().print(f"[bold]{plan.name}[/] was not saved.")


def _library(folder: Path, kit: str | None, world: Scenario | BodyMaker) -> Opened:
    """Open the library, or return an empty one if its folder does not exist yet."""
    from understudy.model.library import Library
    from understudy.ui.cli.options import find_kit, make_world_kit, open_library_with_notes

    found = make_world_kit(world) if kit is None else find_kit(kit, world.name)
    return open_library_with_notes(folder, found).library if folder.exists() else Library(found)


def _see_terminal() -> None:
    """Refuse to start if input or output is not a terminal."""
    from understudy.errors import SettingError

    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise SettingError(
            where="understudy teach",
            setting="its input or output",
            problem="is not a terminal",
            remedy="run it in one (ssh -t HOST for another machine); without a person, teach from "
            "Python with understudy.training.session.Session, or from a table with understudy learn",
        )
