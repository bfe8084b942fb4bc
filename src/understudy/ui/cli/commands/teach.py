"""Commands `understudy teach` and `understudy robots teach`: teach with the keyboard, in the terminal."""

from __future__ import annotations

import sys
from contextlib import ExitStack, closing
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from understudy.addons.bridges.environments.body_maker import find_world
from understudy.errors import SettingError, UnderstudyError
from understudy.model.library import Library
from understudy.sim.body_world import BodyWorld
from understudy.sim.scenario.schema import Scenario
from understudy.storage.json_text import select_facts
from understudy.ui.cli import FAULT
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.named_inputs import choose_kit, open_library_with_notes
from understudy.ui.cli.options import FAILURES, WORLD, parse_names, parse_targets
from understudy.ui.cli.output import format_count, make_console
from understudy.ui.cli.robot_connection import connect_twin
from understudy.ui.controller import interrupted_sessions
from understudy.ui.controller.training_plan import LessonChoices, TrainingPlan, make_session_start
from understudy.ui.terminal.app import TrainerApp

if TYPE_CHECKING:
    from understudy.addons.bridges.environments.body_maker import BodyMaker
    from understudy.addons.robots.twin import DigitalTwin, Ground
    from understudy.ui.cli.lesson_options import LessonOptions, RobotTeachOptions, TeachOptions


def teach(options: TeachOptions) -> None:
    """Teach a robot with the keyboard: drive it by pressing behaviors, and it learns when to switch."""
    choices = choose_lesson(options)
    opened = find_world(options.world or WORLD)
    known = _library(options, opened)
    with ExitStack() as leaving:
        ground: Ground | None = None
        if isinstance(opened, Scenario):
            where = opened
        else:
            ground = leaving.enter_context(closing(BodyWorld(opened, options.seed, name=opened.name)))
            where = ground.scenario
        plan = TrainingPlan(options.name, options.library, where, known, choices, options.seed)
        teach_in_terminal(plan, ground, options.failures, as_json=options.as_json)


def teach_on_robot(options: RobotTeachOptions) -> None:
    """Teach a real robot with the keyboard, as understudy teach does in a simulated world."""
    choices = choose_lesson(options)
    with connect_twin(options.file, None, record=None, recorded=not options.no_record) as twin:
        _see_hold(twin)
        known = _library(options, twin.scenario)
        plan = TrainingPlan(options.name, options.library, twin.scenario, known, choices, 0)
        teach_in_terminal(plan, twin, FAILURES, as_json=options.as_json)


def choose_lesson(options: LessonOptions) -> LessonChoices:
    """Parse the options that say what a lesson is."""
    return LessonChoices(
        states=parse_names(options.states),
        features=parse_names(options.features),
        flags=parse_names(options.flags),
        parameters=parse_names(options.parameters),
        targets=parse_targets(options.targets),
        watched=options.watched,
        reaction_s=options.reaction,
    )


def teach_in_terminal(plan: TrainingPlan, ground: Ground | None, failures: Path, *, as_json: bool) -> None:
    """Run a teaching session in the terminal, once its plan is complete and there is one."""
    make_session_start(plan)
    _see_terminal()
    _teach(plan, ground, failures, as_json=as_json)


def _see_hold(twin: DigitalTwin) -> None:
    """Refuse robots that need a held key, because a terminal cannot detect when a key is released."""
    if twin.fleet.needs_hold_to_run:
        raise SettingError(
            where=twin.fleet.name,
            setting="safety.hold_to_run",
            problem="needs a key that is held, and a terminal does not report released keys",
            remedy="teach it in the studio: understudy robots studio FILE",
        )


def _teach(plan: TrainingPlan, ground: Ground | None, failures: Path, *, as_json: bool) -> None:
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
        begun = {"examples": 0, "saved": False, "journal": None}
        begun = begun if ended is None else select_facts(ended, "examples", "saved", "journal")
        print_json({"name": plan.name, "library": plan.folder, **begun})
    elif ended is None:
        make_console().print(f"Nothing was begun of {plan.name}.")
    elif ended.saved:
        make_console().print(
            f"[bold]{plan.name}[/] is in {plan.folder}, with {format_count(ended.examples, 'example')}."
        )
    else:
        make_console().print(f"[bold]{plan.name}[/] was not saved.")


def _library(options: LessonOptions, world: Scenario | BodyMaker) -> Library:
    """Open the library, or return an empty one if its folder does not exist yet."""
    kit, folder = choose_kit(options.kit, world), options.library
    return open_library_with_notes(folder, kit).library if folder.exists() else Library(kit)


def _see_terminal() -> None:
    """Refuse to start if input or output is not a terminal."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise SettingError(
            where="understudy teach",
            setting="its input or output",
            problem="is not a terminal",
            remedy="run it in one (ssh -t HOST for another machine); without a person, teach from "
            "Python with understudy.training.session.Session, or from a table with understudy learn table",
        )
