"""Handle messages about the session: presses; open and resume lessons, change, pause, step and rewind them."""

from __future__ import annotations

import zlib
from dataclasses import fields
from pathlib import Path

from msgspec import structs

from understudy.addons.checks.falsification.holding_test import HoldingResult
from understudy.errors import SessionError, SettingError, UnderstudyError, UnknownName, join_names
from understudy.model.binding import Binding, format_bound_name
from understudy.model.library import list_missing_parts
from understudy.sim.body_world import BodyWorld
from understudy.sim.world import World
from understudy.training.journal import LessonChanged, PressReceived, SnapshotTaken, read_journal
from understudy.training.other_agents import SessionSnapshot
from understudy.ui.controller import coach, formatting, interrupted_sessions
from understudy.ui.controller.clock import FASTEST
from understudy.ui.controller.open_session import begin_session, resume_session
from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.training_plan import (
    LessonChoices,
    SessionStart,
    TrainingPlan,
    make_session_start,
)
from understudy.ui.web.background import SlowAction
from understudy.ui.web.messages import session as m
from understudy.ui.web.messages.session import SetOtherAgents
from understudy.ui.web.session_host import SessionHost


def begin_automaton(host: SessionHost, name: str, choices: LessonChoices, *, discard: bool) -> None:
    """Begin a new automaton; SessionError if the open one has unsaved changes that are not to be discarded."""
    refuse_unsaved(host, discard=discard)
    host.refresh_library()
    host.refresh_interrupted()
    host.library_view.refuse_new(name, remedy="open it to go on, or give another name")
    left = host.cut_off.get(name)
    if left is not None and not discard:
        raise SessionError(
            f"a session of {name} was interrupted with {left.examples} examples: open {name} to resume it, or "
            "discard it to begin anew"
        )
    plan = _plan(host, name, choices)
    start = make_session_start(plan)
    if start is None:
        raise SessionError(f"{name} needs at least one state and one feature")
    opened = begin_session(plan, start, host.wall, body=host.body, agent=host.agent)
    if left is not None:
        interrupted_sessions.finish_journal(left.path, plan.folder, name)
    host.replace_session(opened, f"Press a state to direct the robot: each press teaches {name}")


def open_automaton(host: SessionHost, name: str, *, discard: bool) -> None:
    """Continue the training of an automaton of the library, or resume its interrupted session."""
    refuse_unsaved(host, discard=discard)
    host.refresh_library()
    host.refresh_interrupted()
    left = host.cut_off.get(name)
    if left is not None:
        _go_on_with_cut_off(host, name, left)
        return
    if name in host.library_view.problems:
        raise SessionError(host.library_view.problems[name])
    if name not in host.library_view.library.taught:
        names = [*host.library_view.library.taught, *host.cut_off]
        raise UnknownName(what="automaton", name=name, where="the library", known=names)
    missing = list_missing_parts(
        host.library_view.library.taught[name], {each.name for each in host.body.readings}, host.body.targets
    )
    if missing:
        raise SessionError(
            f"{name} was learned from a recording or a table, and this robot has no {join_names(missing)}: "
            "choose a world whose robots have them, or run it over a recording: understudy replay FILE"
        )
    start = make_session_start(plan := _plan(host, name))
    if start is None:  # pragma: no cover - what the library has is settled
        raise SessionError(f"{name} cannot be opened: its lesson has no states or features")
    opened = begin_session(plan, start, host.wall, body=host.body, agent=host.agent)
    host.replace_session(opened, f"Opened {name}: test it, and press the right state where it is wrong")


def _go_on_with_cut_off(host: SessionHost, name: str, left: interrupted_sessions.InterruptedSession) -> None:
    before = host.world.snapshot() if isinstance(host.world, World) else None
    try:
        opened = resume_session(_plan(host, name), left.path, host.wall, body=host.body)
    except UnderstudyError:
        if before is not None and isinstance(host.world, World):
            host.world.restore(before)
        raise
    plural = "s" * (left.examples != 1)
    host.replace_session(
        opened,
        f"Resumed the interrupted session of {name}, paused: {left.examples} example{plural}, "
        f"the last step was “{left.steps}”",
    )


def select_squad_sort(host: SessionHost, sort: str | None, agent: int, *, discard: bool) -> None:
    """Select robots (None) or a sort of squads for training; SessionError if unsaved changes are not discarded."""
    _refuse_beyond(host, sort, agent)
    refuse_unsaved(host, discard=discard)
    host.select_agents(sort, agent)


def has_other_library(host: SessionHost, agent: int) -> bool:
    """Return whether a robot's type has another library than the one in training."""
    there = host.sort is None and agent < host.groups.agents(None)
    return there and not host.groups.have_same_library(host.agent, agent)


def _refuse_beyond(host: SessionHost, sort: str | None, agent: int) -> None:
    most = host.groups.agents(sort)
    if agent >= most:
        problem, remedy = f"is {agent + 1}", f"give one from 1 to {most}"
        raise SettingError(where="the studio", setting=sort or "robot", problem=problem, remedy=remedy)


def select_agent(host: SessionHost, agent: int) -> None:
    """Select the robot to train; SessionError once this session has examples of another robot."""
    _refuse_beyond(host, host.sort, agent)
    trainer = host.trainer
    if trainer is None or trainer.robot == agent:
        host.agent = agent
        if trainer is None:
            who = f"Robot {agent + 1}" if host.sort is None else f"The coordinator of {host.sort} {agent + 1}"
            host.status = StatusMessage(f"{who} will be trained")
            host.frame_version += 1
        return
    session = trainer.session
    if session.view().undoable is not None or len(session.examples) != host.began_with:
        raise SessionError(
            f"{trainer.name} already has examples from robot {trainer.robot + 1}: save it and open it again to train "
            "it with another robot"
        )
    start = SessionStart(session.lesson, dict(trainer.session_view.targets))
    opened = begin_session(_plan(host, trainer.name), start, host.wall, body=host.body, agent=agent)
    host.replace_session(opened, f"Training {trainer.name} with robot {agent + 1} now")


def is_saved_in_training(host: SessionHost, name: str) -> bool:
    """Return whether an automaton is the one in training; SessionError if it has unsaved changes."""
    trainer = host.trainer
    if trainer is None or trainer.name != name:
        return False
    if trainer.has_unsaved_changes:
        raise SessionError(f"{name} is being trained and has unsaved changes: save it first")
    return True


def reload_automaton(host: SessionHost, name: str, sentence: str, *, here: bool) -> StatusMessage | None:
    """Read the library again after a change; reopen the automaton if it is the one in training (`here`)."""
    host.refresh_library()
    if not here:
        return StatusMessage(sentence, "recorded")
    _reopen(host, name, sentence)
    return None


def _reopen(host: SessionHost, name: str, sentence: str) -> None:
    """Reopen the automaton in training as it is in the library, possibly under another name."""
    trainer, paused = host.active_trainer, host.paused
    lesson = host.library_view.find_automaton(name).lesson
    targets = dict(trainer.session_view.targets)
    choices = LessonChoices(
        targets=targets if lesson and set(lesson.automaton.parameters) == set(targets) else {}
    )
    start = make_session_start(plan := _plan(host, name, choices))
    if start is None:  # pragma: no cover - what the library has is settled
        raise SessionError(f"{name} cannot be opened: its lesson has no states or features")
    host.replace_session(begin_session(plan, start, host.wall, body=host.body, agent=trainer.robot), sentence)
    host.pause(paused, sentence)


def _plan(host: SessionHost, name: str, choices: LessonChoices | None = None) -> TrainingPlan:
    library_view = host.library_view
    return TrainingPlan(
        name,
        library_view.folder,
        host.world.scenario,
        library_view.library,
        choices or LessonChoices(),
        host.seed,
    )


def refuse_unsaved(host: SessionHost, *, discard: bool) -> None:
    """Raise SessionError if what is trained has unsaved changes that are not to be discarded."""
    trainer = host.trainer
    if trainer is not None and trainer.has_unsaved_changes and not discard:
        raise SessionError(f"{trainer.name} has unsaved changes: save it first, or discard them")


def set_other_agents(host: SessionHost, message: SetOtherAgents) -> StatusMessage:
    """Set what the robots not in training do: idle (None), or run a behavior of the library with these targets."""
    trainer, library = host.active_trainer, host.library_view.library
    behavior, targets = message.behavior, message.targets
    if host.world.robots < 2:
        problem, remedy = "cannot be set: there is only one robot", "open a scenario with more"
        raise SettingError(where="the studio", setting="others", problem=problem, remedy=remedy)
    wanted = () if behavior is None else library.parameters(behavior)
    if set(wanted) != set(targets):
        problem = f"need targets for {', '.join(wanted)}" if wanted else "need no targets"
        raise SettingError(where="the studio", setting="others", problem=problem, remedy="give exactly these")
    world_targets = list(host.world.targets)
    for target in targets.values():
        if target not in world_targets:
            raise UnknownName(what="target", name=target, where="the world", known=world_targets)
    before = host.other_behavior
    try:
        trainer.session.set_other_agents(behavior, targets, library=library)
    except UnderstudyError:
        former = (None, {}) if before is None else (before.behavior, before.targets)
        trainer.session.set_other_agents(*former, library=library)
        raise
    doing = "idle" if behavior is None else f"run {format_bound_name(behavior, Binding(targets))}"
    host.frame_version += 1
    return StatusMessage(f"The other robots {doing} meanwhile")


def go_to_example(host: SessionHost, number: int) -> None:
    """Go back to just before an example was given; SessionError if that moment is not stored."""
    trainer = host.active_trainer
    if all(example.number != number for example in trainer.session.examples):
        raise SessionError(f"{trainer.name} has no example {number}")
    frame = host.rewind_buffer.find_before_example(number)
    if frame is not None:
        host.rewind(frame)
        return
    journal = host.open_session.journal if host.open_session else Path()
    snapshot = _before(journal, number)
    if snapshot is None:
        raise SessionError(f"example {number} is not from this session: its moment was not kept")
    others = trainer.session.other_agents.snapshot()  # what they did then is not kept: they go on
    host.go_back(SessionSnapshot(zlib.decompress(snapshot.body), tuple(snapshot.run), snapshot.mode, others))


def _before(journal: Path, number: int) -> SnapshotTaken | None:
    """Return the last snapshot before the press that gave an example; None if there is none."""
    snapshot = moment = None
    before: dict[int, SnapshotTaken | None] = {}
    for entry in read_journal(journal):
        match entry:
            case SnapshotTaken():
                snapshot = entry
            case PressReceived():
                before[entry.press.number] = snapshot
            case LessonChanged() if entry.press is not None and any(
                each.number == number for each in entry.changed
            ):
                moment = before.get(entry.press)
    return moment


def handle_press(host: SessionHost, message: m.PressState) -> None:
    """Direct the robot to a state; if a question is open, the press answers it."""
    host.frame_version += 1
    if coach.press_or_answer(host.active_trainer, message.state):
        host.note_tick()


def handle_confirm(host: SessionHost, _: m.Confirm) -> None:
    """Confirm the present state; if a question is open, this answers it."""
    host.frame_version += 1
    if coach.press_or_answer(host.active_trainer, None):
        host.note_tick()


def handle_pause(host: SessionHost, message: m.Pause) -> None:
    """Pause or resume."""
    host.pause(message.paused)


def handle_step(host: SessionHost, _: m.StepTick) -> None:
    """Run one tick, then pause."""
    host.step()


def handle_skip_ahead(host: SessionHost, _: m.SkipAhead) -> None:
    """Skip to the next moment at which the person is needed, and pause there."""
    coach.skip_ahead(host.active_trainer)
    host.frame_version += 1
    host.note_tick()


def handle_set_speed(host: SessionHost, message: m.SetSpeed) -> None:
    """Set the simulation speed."""
    host.set_speed(FASTEST if message.speed == "fastest" else message.speed)


def handle_reset(host: SessionHost, message: m.ResetWorld) -> None:
    """Reset the world to a seed."""
    host.reset(message.seed)


def handle_rewind(host: SessionHost, message: m.Rewind) -> None:
    """Go back to a time of the run (s), or to just before an example was given."""
    if isinstance(host.world, BodyWorld):
        raise SessionError(f"{host.world.name} cannot be rewound: reset the world instead")
    if (message.time_s is None) == (message.example is None):
        problem, remedy = "gives neither or both of a time and an example", "give one of them"
        raise SettingError(where="the studio", setting="rewind", problem=problem, remedy=remedy)
    if message.example is not None:
        go_to_example(host, message.example)
    elif message.time_s is not None:
        host.rewind(host.rewind_buffer.find_before_time(message.time_s))


def handle_open(host: SessionHost, message: m.OpenAutomaton) -> None:
    """Continue the training of an automaton of the library."""
    open_automaton(host, message.name, discard=message.discard)


def handle_new(host: SessionHost, message: m.NewAutomaton) -> None:
    """Begin a new automaton."""
    begin_automaton(host, message.name, _choices(message), discard=message.discard)


def _choices(message: m.NewAutomaton | m.ChangeDesign) -> LessonChoices:
    """Return the lesson choices that a message contains."""
    values = structs.asdict(message)
    return LessonChoices(
        **{each.name: values[each.name] for each in fields(LessonChoices) if each.name in values}
    )


def handle_keep_going(host: SessionHost, _: m.KeepGoing) -> SlowAction:
    """Test what is in training in new worlds; then go to where it goes wrong, or say that it holds."""
    trainer = host.active_trainer
    test, results = trainer.continuation.begin(), list[HoldingResult]()

    def finish() -> StatusMessage:
        if host.trainer is not trainer:
            return StatusMessage(f"{trainer.name} was tested, but is not in training any more")
        status = trainer.continuation.finish(results[0])
        host.clear_rewind()
        return status

    return SlowAction(
        StatusMessage(f"Testing {trainer.name} in new worlds…"), lambda: results.append(test()), finish
    )


def handle_go_back_to_best(host: SessionHost, _: m.GoBackToBest) -> None:
    """Undo what was done since the best version that was tested, and go to where that one goes wrong."""
    host.active_trainer.go_back()
    host.clear_rewind()


def handle_select_agent(host: SessionHost, message: m.SelectAgent) -> None:
    """Select the robot or the coordinator to train."""
    if message.sort != host.sort or has_other_library(host, message.agent):
        select_squad_sort(host, message.sort, message.agent, discard=message.discard)
    select_agent(host, message.agent)
    host.frame_version += 1


def handle_change_design(host: SessionHost, message: m.ChangeDesign) -> None:
    """Change states, features or options of the lesson."""
    host.active_trainer.change_design(_choices(message))
    host.frame_version += 1


def handle_edit_example(host: SessionHost, message: m.EditExample) -> None:
    """Change an example's state, next state, or values."""
    features = {str(bound): bound for bound in host.active_trainer.features}
    for label in message.values:
        if label not in features:
            raise UnknownName(what="feature", name=label, where="the lesson", known=list(features))
    values = {
        label: formatting.parse_displayed_value(features[label], text)
        for label, text in message.values.items()
    }
    host.active_trainer.edit(message.number, state=message.state, next=message.next, values=values)
