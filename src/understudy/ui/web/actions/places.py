"""Handle messages about where one teaches: other worlds and libraries, failing worlds, and worlds that are saved."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from understudy.errors import SessionError, UnderstudyError
from understudy.model.library import Kit
from understudy.sim.body_world import BodyWorld
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario_snapshot import make_scenario_snapshot
from understudy.sim.world import World
from understudy.ui.controller.failing_worlds import make_draft, prepare_failure
from understudy.ui.controller.open_session import begin_session
from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.training_plan import LessonChoices, SessionStart, TrainingPlan
from understudy.ui.web.actions.session import open_automaton, refuse_unsaved
from understudy.ui.web.messages import session as m
from understudy.ui.web.messages.review import LeaveFailure, OpenFailure, RerunFailures
from understudy.ui.web.session_host import CARRY, SessionHost
from understudy.ui.web.views.library import check_folder
from understudy.ui.web.views.team import TrainableGroups


def handle_open_world(host: SessionHost, message: m.OpenWorld) -> StatusMessage:
    """Go to a world of another scenario; what is trained goes along where it can."""
    refuse_fixed(host)
    refuse_unsaved(host, discard=message.discard)
    scenario, kit = host.places.open_world(message.name)
    return _enter(host, scenario, host.folder, kit, f"World {scenario.name}")


def handle_open_library(host: SessionHost, message: m.OpenLibrary) -> StatusMessage:
    """Use another library; an automaton of the same name is opened from it."""
    refuse_fixed(host)
    refuse_unsaved(host, discard=message.discard)
    folder = host.places.open_library(message.name, host.folder)
    check_folder(folder)
    return _enter(host, host.scenario, folder, host.first_kit, f"Library {message.name}")


def _enter(host: SessionHost, scenario: Scenario, folder: Path, kit: Kit, sentence: str) -> StatusMessage:
    """Enter a world with a library, and open there what was trained; refused, nothing has changed."""
    trained = None if host.trainer is None else host.trainer.name
    world = World(scenario, [host.seed])  # what cannot be entered is told before anything is left
    host.enter(world, folder, kit)
    if trained is not None and trained in host.library_view.library.taught:
        with suppress(UnderstudyError):  # it may need what this world does not have
            open_automaton(host, trained, discard=True)
            return StatusMessage(f"{sentence}: {trained} is opened here")
    return StatusMessage(f"{sentence}: teach something new, or open an automaton of the library")


def handle_save_world(host: SessionHost, message: m.SaveWorld) -> StatusMessage:
    """Save the world as it stands as a scenario, which is offered from then on."""
    refuse_fixed(host)
    about = f"Saved in the studio: {host.scenario.name}, world {host.seed}, as it stood then."
    snapshot = make_scenario_snapshot(host.scenario, host.world.view(), name=message.name, about=about)
    path = host.places.save_world(snapshot)
    host.scene_version += 1
    return StatusMessage(
        f"The world is saved as {snapshot.name}, in {path.parent.name}/{path.name}", "recorded"
    )


def refuse_fixed(host: SessionHost) -> None:
    """Raise SessionError if the world is that of real robots or a body of the user's own."""
    if isinstance(host.world, BodyWorld):
        raise SessionError(
            f"{host.world.name} is a body of your own: start the studio again for another world"
        )
    if not isinstance(host.world, World):
        raise SessionError(f"real robots are where they are, with the library that was chosen: {CARRY}")


def handle_open_failure(host: SessionHost, message: OpenFailure) -> None:
    """Open a session in a failing world, paused shortly before the behavior goes wrong."""
    refuse_fixed(host)
    failing, draft = host.failures.find(message.name), make_draft(host.trainer)
    opening = prepare_failure(failing, host.library_source, draft, discard=message.discard)
    host.refresh_interrupted()
    left = host.cut_off.get(opening.plan.name)
    if left is not None:
        raise SessionError(
            f"a session of {opening.plan.name} was interrupted with {left.examples} examples: open it from the "
            "library to resume it, or discard it first"
        )
    opened = opening.begin(host.wall)
    world = opening.moment.world
    host.failures.note_opened(message.name, world.scenario, host.scenario, host.seed)
    host.enter(world, host.folder, host.places.find_kit(world.scenario))
    if opening.moment.sort is not None:
        host.select_agents(opening.moment.sort, opening.moment.agent)
    host.replace_session(opened, opening.sentence)


def handle_leave_failure(host: SessionHost, _: LeaveFailure) -> StatusMessage:
    """Go back to the world from before the failing one, from its start, with what is in training."""
    before = host.failures.before
    if before is None or host.failures.find_open(host.scenario) is None:
        raise SessionError("no failing world is open")
    scenario, seed = before
    kit, trainer, world = host.places.find_kit(scenario), host.trainer, World(scenario, [seed])
    groups, sort = TrainableGroups(scenario, host.folder, kit), host.sort
    if sort is not None and sort not in groups.squads:  # that world has no such coordinators
        refuse_unsaved(host, discard=False)
        trainer = sort = None
    sentence = f"World {scenario.name}, from the start"
    opened, agent = None, 0
    if trainer is not None:
        library, body = host.library_view.library, groups.body(world, sort)
        plan = TrainingPlan(trainer.name, trainer.folder, scenario, library, LessonChoices(), seed)
        start = SessionStart(trainer.session.lesson, dict(trainer.session_view.targets))
        agent = min(host.agent, body.agents - 1)
        opened = begin_session(plan, start, host.wall, body=body, agent=agent, carried_to=scenario.name)
    host.enter(world, host.folder, kit)
    if sort is not None:
        host.select_agents(sort, agent)
    if opened is not None:
        host.replace_session(opened, sentence)
        host.pause(True, sentence)
    return StatusMessage(sentence)


def handle_rerun_failures(host: SessionHost, _: RerunFailures) -> StatusMessage | None:
    """Read the folder of failing worlds again, and begin to run them with what is in training."""
    if host.failures.folder is None:
        raise SessionError("there is no folder of failing worlds: start the studio with --failures FOLDER")
    if host.failures.is_running:
        raise SessionError("the failing worlds are being run already: wait for the result")
    host.failures.read()
    host.properties.read()
    if not host.failures.worlds:
        return StatusMessage(f"There are no failing worlds in {host.failures.folder}")
    host.failures.begin_rerun(host.library_source, host.trainer)
    return None
