"""Actions on time, on what is trained and on its lesson."""

from __future__ import annotations

from understudy.errors import SettingError, UnknownName
from understudy.ui.controller import formatting, lesson_actions
from understudy.ui.controller.clock import FASTEST
from understudy.ui.controller.trainer import Trainer
from understudy.ui.controller.training_plan import LessonChoices
from understudy.ui.web.actions import session
from understudy.ui.web.messages import review as r
from understudy.ui.web.messages import session as m
from understudy.ui.web.session_host import SessionHost


def handle_pause(stage: SessionHost, message: m.Pause) -> None:
    """Let time stand still, or go on."""
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
        session.go_to_example(stage, message.example)
    elif message.time_s is not None:
        stage.rewind(stage.reel.at(message.time_s))


def handle_open(stage: SessionHost, message: m.OpenAutomaton) -> None:
    """Train an automaton of the library on."""
    session.open_automaton(stage, message.name, discard=message.discard)


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
    session.begin_automaton(stage, message.name, choices, discard=message.discard)


def handle_select_agent(stage: SessionHost, message: m.SelectAgent) -> None:
    """Choose which robot is trained, or which coordinator."""
    if message.sort != stage.sort or session.has_other_library(stage, message.agent):
        session.select_squad_sort(stage, message.sort, message.agent, discard=message.discard)
    session.select_agent(stage, message.agent)
    stage.moved += 1


def handle_toggle_mode(desk: Trainer, _: m.ToggleMode) -> None:
    """Go from training to testing, or back."""
    desk.turn()


def handle_restart(desk: Trainer, _: m.RestartAutomaton) -> None:
    """Start the automaton afresh."""
    desk.restart()


def handle_bind_targets(desk: Trainer, message: m.BindTargets) -> None:
    """Let parameters stand for other targets."""
    desk.bind(message.targets)


def handle_toggle_watching(desk: Trainer, _: m.ToggleWatching) -> None:
    """Let silence be consent, or not."""
    desk.watch()


def handle_undo(desk: Trainer, _: m.Undo) -> None:
    """Take back a step."""
    desk.undo()


def handle_redo(desk: Trainer, _: m.Redo) -> None:
    """Do an undone step again."""
    desk.redo()


def handle_change_design(desk: Trainer, message: m.ChangeDesign) -> None:
    """Choose anew what the lesson is about."""
    choices = LessonChoices(
        states=message.states,
        features=message.features,
        flags=message.flags,
        renamed=message.renamed,
        watched=message.watched,
        reaction_s=message.reaction_s,
        unlearning=message.unlearning,
    )
    desk.choose(choices)


def handle_edit_example(stage: SessionHost, message: m.EditExample) -> None:
    """Let an example say something else."""
    features = {str(bound): bound for bound in stage.trained.features}
    for label in message.values:
        if label not in features:
            raise UnknownName(what="feature", name=label, where="the lesson", known=list(features))
    values = {
        label: formatting.parse_displayed_value(features[label], text)
        for label, text in message.values.items()
    }
    stage.trained.edit(message.number, state=message.state, next=message.next, values=values)


def handle_delete_example(desk: Trainer, message: m.DeleteExample) -> None:
    """Delete an example."""
    desk.delete(message.number)


def handle_quarantine(desk: Trainer, message: m.QuarantineExamples) -> None:
    """Let examples teach nothing for now."""
    lesson_actions.quarantine_examples(desk, message.numbers)


def handle_release(desk: Trainer, message: m.ReleaseExamples) -> None:
    """Let examples teach again."""
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
