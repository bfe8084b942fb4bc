"""Handle messages about failing worlds: open one shortly before it goes wrong, leave it, and run all again."""

from __future__ import annotations

from understudy.errors import SessionError
from understudy.sim.world import World
from understudy.ui.controller.failing_worlds import make_draft, prepare_failure
from understudy.ui.controller.open_session import begin_session
from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.training_plan import LessonChoices, SessionStart, TrainingPlan
from understudy.ui.web.actions.places import refuse_fixed
from understudy.ui.web.actions.session import refuse_unsaved
from understudy.ui.web.messages.review import LeaveFailure, OpenFailure, RerunFailures
from understudy.ui.web.session_host import SessionHost
from understudy.ui.web.views.team import TrainableGroups


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
