"""Handle messages about the session: presses; open and resume lessons, change, pause, step and rewind them."""

from __future__ import annotations

import zlib
from pathlib import Path

from understudy.errors import SessionError, SettingError, UnderstudyError, UnknownName
from understudy.model.binding import Binding, format_bound_name
from understudy.sim.world import World
from understudy.training.journal import LessonChanged, PressReceived, SnapshotTaken, read_journal
from understudy.training.other_agents import SessionSnapshot
from understudy.ui.controller import coach, formatting, interrupted_sessions, lesson_actions
from understudy.ui.controller.clock import FASTEST
from understudy.ui.controller.open_session import begin_session, resume_session
from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.trainer import Trainer
from understudy.ui.controller.training_plan import (
    LessonChoices,
    SessionStart,
    TrainingPlan,
    make_session_start,
)
from understudy.ui.web.messages import review as r
from understudy.ui.web.messages import session as m
from understudy.ui.web.messages.session import SetOtherAgents
from understudy.ui.web.session_host import SessionHost


def begin_automaton(stage: SessionHost, name: str, choices: LessonChoices, *, discard: bool) -> None:
    """Begin a new automaton."""
    _refuse_unsaved(stage, discard=discard)
    stage.refresh_library()
    stage.refresh_interrupted()
    stage.library_view.refuse_new(name, remedy="open it to go on, or give another name")
    left = stage.cut_off.get(name)
    if left is not None and not discard:
        raise SessionError(
            f"a session of {name} was cut off with {left.examples} examples: open {name} to go on with it, or "
            "discard it to begin anew"
        )
    plan = _plan(stage, name, choices)
    start = make_session_start(plan)
    if start is None:
        raise SessionError(f"{name} needs at least one state and one feature: choose what it can do")
    opened = begin_session(plan, start, stage.wall, body=stage.body, agent=stage.agent)
    if left is not None:
        interrupted_sessions.finish_journal(left.path, plan.folder, name)
    stage.replace_session(opened, f"Direct the robot by pressing a state: that is how {name} is taught")


def open_automaton(stage: SessionHost, name: str, *, discard: bool) -> None:
    """Train an automaton of the library on, or go on with a session that was cut off."""
    _refuse_unsaved(stage, discard=discard)
    stage.refresh_library()
    stage.refresh_interrupted()
    left = stage.cut_off.get(name)
    if left is not None:
        _go_on_with_cut_off(stage, name, left)
        return
    if name in stage.library_view.problems:
        raise SessionError(stage.library_view.problems[name])
    if name not in stage.library_view.library.taught:
        known = [*stage.library_view.library.taught, *stage.cut_off]
        raise UnknownName(what="automaton", name=name, where="the library", known=known)
    start = make_session_start(plan := _plan(stage, name))
    if start is None:  # pragma: no cover - what the library has is settled
        raise SessionError(f"{name} cannot be opened: nothing was chosen for it")
    opened = begin_session(plan, start, stage.wall, body=stage.body, agent=stage.agent)
    stage.replace_session(
        opened, f"{name} is open again: let it try, and press what is right where it does wrong"
    )


def _go_on_with_cut_off(stage: SessionHost, name: str, left: interrupted_sessions.InterruptedSession) -> None:
    before = stage.world.snapshot() if isinstance(stage.world, World) else None
    try:
        opened = resume_session(_plan(stage, name), left.path, stage.wall, body=stage.body)
    except UnderstudyError:
        if before is not None and isinstance(stage.world, World):
            stage.world.restore(before)
        raise
    plural = "s" * (left.examples != 1)
    stage.replace_session(
        opened,
        f"The session of {name} that was cut off goes on where it was, paused: {left.examples} example{plural}, "
        f"the last step was “{left.steps}”",
    )


def select_squad_sort(stage: SessionHost, sort: str | None, agent: int, *, discard: bool) -> None:
    """Train coordinators of a sort of squads, or robots (None); what is not saved has to be, or to be discarded."""
    _refuse_beyond(stage, sort, agent)
    _refuse_unsaved(stage, discard=discard)
    stage.select_agents(sort, agent)


def has_other_library(stage: SessionHost, agent: int) -> bool:
    """Whether this robot has another library than the one that is trained: it is of a type that differs."""
    there = stage.sort is None and agent < stage.groups.agents(None)
    return there and not stage.groups.have_same_library(stage.agent, agent)


def _refuse_beyond(stage: SessionHost, sort: str | None, agent: int) -> None:
    most = stage.groups.agents(sort)
    if agent >= most:
        problem, remedy = f"is {agent + 1}", f"give one from 1 to {most}"
        raise SettingError(where="the studio", setting=sort or "robot", problem=problem, remedy=remedy)


def select_agent(stage: SessionHost, agent: int) -> None:
    """Which robot is trained; not once something was shown in this session."""
    _refuse_beyond(stage, stage.sort, agent)
    desk = stage.trainer
    if desk is None or desk.robot == agent:
        stage.agent = agent
        if desk is None:
            who = (
                f"Robot {agent + 1}" if stage.sort is None else f"The coordinator of {stage.sort} {agent + 1}"
            )
            stage.status = StatusMessage(f"{who} is the one that will be trained")
            stage.frame_version += 1
        return
    session = desk.session
    if session.view().undoable is not None or len(session.examples) != stage.began_with:
        raise SessionError(
            f"{desk.name} has been shown something by robot {desk.robot + 1}: save it and open it again to train "
            "it with another robot"
        )
    start = SessionStart(session.lesson, dict(desk.session_view.targets))
    opened = begin_session(_plan(stage, desk.name), start, stage.wall, body=stage.body, agent=agent)
    stage.replace_session(opened, f"{desk.name} is trained with robot {agent + 1} now")


def is_saved_in_training(stage: SessionHost, name: str) -> bool:
    """Whether an automaton of the library is the one in training; SessionError where it has unsaved changes."""
    desk = stage.trainer
    if desk is None or desk.name != name:
        return False
    if desk.has_unsaved_changes:
        raise SessionError(f"{name} is being trained, and not saved as it is now: save it first")
    return True


def reload_automaton(stage: SessionHost, name: str, said: str, *, here: bool) -> StatusMessage | None:
    """An automaton was changed in the library; the one in training (`here`) goes on as it is there now, and says so."""
    stage.refresh_library()
    if not here:
        return StatusMessage(said, "recorded")
    _reopen(stage, name, said)
    return None


def _reopen(stage: SessionHost, name: str, said: str) -> None:
    """Go on with what is trained as the library has it, perhaps under another name."""
    desk, paused = stage.active_trainer, stage.paused
    lesson = stage.library_view.find_automaton(name).lesson
    targets = dict(desk.session_view.targets)
    choices = LessonChoices(
        targets=targets if lesson and set(lesson.automaton.parameters) == set(targets) else {}
    )
    start = make_session_start(plan := _plan(stage, name, choices))
    if start is None:  # pragma: no cover - what the library has is settled
        raise SessionError(f"{name} cannot be opened: nothing was chosen for it")
    stage.replace_session(begin_session(plan, start, stage.wall, body=stage.body, agent=desk.robot), said)
    stage.pause(paused, said)


def _plan(stage: SessionHost, name: str, choices: LessonChoices | None = None) -> TrainingPlan:
    shelf = stage.library_view
    return TrainingPlan(
        name, shelf.folder, stage.world.scenario, shelf.library, choices or LessonChoices(), stage.seed
    )


def _refuse_unsaved(stage: SessionHost, *, discard: bool) -> None:
    desk = stage.trainer
    if desk is not None and desk.has_unsaved_changes and not discard:
        raise SessionError(f"{desk.name} is not saved as it is now: save it first, or discard it")


def set_other_agents(stage: SessionHost, message: SetOtherAgents) -> StatusMessage:
    """Let the others idle (None), or run a behavior of the library, its parameters standing for targets."""
    desk, library = stage.active_trainer, stage.library_view.library
    behavior, targets = message.behavior, message.targets
    if stage.world.robots < 2:
        problem, remedy = "cannot be told: there is one robot", "open a world with more"
        raise SettingError(where="the studio", setting="others", problem=problem, remedy=remedy)
    wanted = () if behavior is None else library.parameters(behavior)
    if set(wanted) != set(targets):
        problem = f"need what {', '.join(wanted)} stands for" if wanted else "need no targets"
        raise SettingError(where="the studio", setting="others", problem=problem, remedy="say exactly that")
    known = list(stage.world.targets)
    for target in targets.values():
        if target not in known:
            raise UnknownName(what="target", name=target, where="the world", known=known)
    before = stage.other_behavior
    try:
        desk.session.set_other_agents(behavior, targets, library=library)
    except UnderstudyError:
        former = (None, {}) if before is None else (before.behavior, before.targets)
        desk.session.set_other_agents(*former, library=library)
        raise
    doing = "idle" if behavior is None else f"run {format_bound_name(behavior, Binding(targets))}"
    stage.frame_version += 1
    return StatusMessage(f"The others {doing} meanwhile")


def go_to_example(stage: SessionHost, number: int) -> None:
    """Go back to just before an example was shown; SessionError where that moment is not kept."""
    desk = stage.active_trainer
    if all(example.number != number for example in desk.session.examples):
        raise SessionError(f"{desk.name} has no example {number}")
    frame = stage.rewind_buffer.find_before_example(number)
    if frame is not None:
        stage.rewind(frame)
        return
    journal = stage.open_session.journal if stage.open_session else Path()
    snapshot = _before(journal, number)
    if snapshot is None:
        raise SessionError(f"example {number} was not shown in this session: its moment is not kept")
    others = desk.session.other_agents.snapshot()  # what they did then is not kept: they go on
    stage.go_back(SessionSnapshot(zlib.decompress(snapshot.body), tuple(snapshot.run), snapshot.mode, others))


def _before(journal: Path, number: int) -> SnapshotTaken | None:
    """The snapshot before the press that showed an example; the last such, as undo lets numbers go."""
    snapshot = found = None
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
                found = before.get(entry.press)
    return found


def handle_press(stage: SessionHost, message: m.PressState) -> None:
    """Direct the robot to a state; while a question is open, the press answers it."""
    _press(stage, message.state)


def handle_confirm(stage: SessionHost, _: m.Confirm) -> None:
    """Confirm the present state; while a question is open, that answers it."""
    _press(stage, None)


def _press(stage: SessionHost, state: str | None) -> None:
    """Direct to a state, or confirm the present one (None)."""
    desk = stage.active_trainer
    stage.frame_version += 1
    if desk.coach.question is not None:
        coach.answer_question(desk, state)
        stage.note_tick()
    elif state is None:
        desk.confirm()
    else:
        desk.press(state)


def handle_pause(stage: SessionHost, message: m.Pause) -> None:
    """Pause or resume."""
    stage.pause(message.paused)


def handle_step(stage: SessionHost, _: m.StepTick) -> None:
    """Take one tick."""
    stage.step()


def handle_set_speed(stage: SessionHost, message: m.SetSpeed) -> None:
    """Choose how fast time goes."""
    stage.set_speed(FASTEST if message.speed == "fastest" else message.speed)


def handle_reset(stage: SessionHost, message: m.ResetWorld) -> None:
    """Begin the world of a seed."""
    stage.reset(message.seed)


def handle_rewind(stage: SessionHost, message: m.Rewind) -> None:
    """Go back to a time, or to an example."""
    if (message.time_s is None) == (message.example is None):
        problem, remedy = "says nothing, or two things", "give a time or an example"
        raise SettingError(where="the studio", setting="rewind", problem=problem, remedy=remedy)
    if message.example is not None:
        go_to_example(stage, message.example)
    elif message.time_s is not None:
        stage.rewind(stage.rewind_buffer.find_before_time(message.time_s))


def handle_open(stage: SessionHost, message: m.OpenAutomaton) -> None:
    """Continue the training of an automaton of the library."""
    open_automaton(stage, message.name, discard=message.discard)


def handle_new(stage: SessionHost, message: m.NewAutomaton) -> None:
    """Begin a new automaton."""
    choices = LessonChoices(
        states=message.states,
        features=message.features,
        flags=message.flags,
        parameters=message.parameters,
        targets=message.targets,
        watched=message.watched,
        reaction_s=message.reaction_s,
        unlearning=message.unlearning,
    )
    begin_automaton(stage, message.name, choices, discard=message.discard)


def handle_select_agent(stage: SessionHost, message: m.SelectAgent) -> None:
    """Choose which robot is trained, or which coordinator."""
    if message.sort != stage.sort or has_other_library(stage, message.agent):
        select_squad_sort(stage, message.sort, message.agent, discard=message.discard)
    select_agent(stage, message.agent)
    stage.frame_version += 1


def handle_toggle_mode(desk: Trainer, _: m.ToggleMode) -> None:
    """Go from training to testing, or back."""
    desk.toggle_mode()


def handle_restart(desk: Trainer, _: m.RestartAutomaton) -> None:
    """Start the automaton afresh."""
    desk.restart()


def handle_bind_targets(desk: Trainer, message: m.BindTargets) -> None:
    """Bind parameters to other targets."""
    desk.bind_targets(message.targets)


def handle_toggle_watching(desk: Trainer, _: m.ToggleWatching) -> None:
    """Let silence be consent, or not."""
    desk.toggle_watching()


def handle_undo(desk: Trainer, _: m.Undo) -> None:
    """Take back a step."""
    desk.undo()


def handle_redo(desk: Trainer, _: m.Redo) -> None:
    """Do an undone step again."""
    desk.redo()


def handle_change_design(desk: Trainer, message: m.ChangeDesign) -> None:
    """Change states, features or options of the lesson."""
    choices = LessonChoices(
        states=message.states,
        features=message.features,
        flags=message.flags,
        renamed=message.renamed,
        watched=message.watched,
        reaction_s=message.reaction_s,
        unlearning=message.unlearning,
    )
    desk.change_design(choices)


def handle_edit_example(stage: SessionHost, message: m.EditExample) -> None:
    """Let an example say something else."""
    features = {str(bound): bound for bound in stage.active_trainer.features}
    for label in message.values:
        if label not in features:
            raise UnknownName(what="feature", name=label, where="the lesson", known=list(features))
    values = {
        label: formatting.parse_displayed_value(features[label], text)
        for label, text in message.values.items()
    }
    stage.active_trainer.edit(message.number, state=message.state, next=message.next, values=values)


def handle_delete_example(desk: Trainer, message: m.DeleteExample) -> None:
    """Delete an example."""
    desk.delete(message.number)


def handle_quarantine(desk: Trainer, message: m.QuarantineExamples) -> None:
    """Put examples into quarantine: the learner ignores them."""
    lesson_actions.quarantine_examples(desk, message.numbers)


def handle_release(desk: Trainer, message: m.ReleaseExamples) -> None:
    """Release examples from quarantine."""
    lesson_actions.release_examples(desk, message.numbers)


def handle_add_expectation(desk: Trainer, message: r.AddExpectation) -> None:
    """Let the lesson promise an outcome."""
    lesson_actions.add_expectation_here(desk, message.flag, message.within_s)


def handle_remove_expectation(desk: Trainer, message: r.RemoveExpectation) -> None:
    """Let the lesson no longer promise an outcome."""
    lesson_actions.remove_expectation(desk, message.outcome)


def handle_apply_pruning(desk: Trainer, message: r.ApplyPruning) -> None:
    """Learn with fewer questions from now on."""
    lesson_actions.change_pruning(desk, message.pruning)
