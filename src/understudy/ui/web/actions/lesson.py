"""Actions on time, on what is trained and on its lesson."""

from __future__ import annotations

from understudy.errors import SettingError, UnknownName
from understudy.ui.controller import formatting, lesson_actions
from understudy.ui.controller.clock import FASTEST
from understudy.ui.controller.trainer import Desk
from understudy.ui.controller.training_plan import Choices
from understudy.ui.web.actions import session
from understudy.ui.web.messages import review as r
from understudy.ui.web.messages import session as m
from understudy.ui.web.session_host import Stage


def pause(stage: Stage, message: m.Pause) -> None:
    """Let time stand still, or go on."""
    stage.pause(message.paused)


def step(stage: Stage, _: m.Step) -> None:
    """Take one tick."""
    stage.step()


def set_speed(stage: Stage, message: m.Speed) -> None:
    """Choose how fast time goes."""
    stage.set_speed(FASTEST if message.speed == "fastest" else message.speed)


def reset(stage: Stage, message: m.Reset) -> None:
    """Begin the world of a seed."""
    stage.reset(message.seed)


def rewind(stage: Stage, message: m.Rewind) -> None:
    """Go back to a time, or to an example."""
    if (message.time_s is None) == (message.example is None):
        problem, remedy = "says nothing, or two things", "give a time or an example"
        raise SettingError(where="the studio", setting="rewind", problem=problem, remedy=remedy)
    if message.example is not None:
        session.go_to_example(stage, message.example)
    elif message.time_s is not None:
        stage.rewind(stage.reel.at(message.time_s))


def open_automaton(stage: Stage, message: m.Open) -> None:
    """Train an automaton of the library on."""
    session.go_on(stage, message.name, discard=message.discard)


def begin_automaton(stage: Stage, message: m.New) -> None:
    """Begin a new automaton."""
    choices = Choices(
        states=message.states,
        features=message.features,
        flags=message.flags,
        parameters=message.parameters,
        targets=message.targets,
        watched=message.watched,
        reaction_s=message.reaction_s,
        unlearning=message.unlearning,
    )
    session.begin(stage, message.name, choices, discard=message.discard)


def select_agent(stage: Stage, message: m.Agent) -> None:
    """Choose which robot is trained, or which coordinator."""
    if message.sort != stage.sort or session.knows_other(stage, message.agent):
        session.choose_sort(stage, message.sort, message.agent, discard=message.discard)
    session.choose_agent(stage, message.agent)
    stage.moved += 1


def turn(desk: Desk, _: m.Turn) -> None:
    """Go from training to testing, or back."""
    desk.turn()


def restart(desk: Desk, _: m.Restart) -> None:
    """Start the automaton afresh."""
    desk.restart()


def stand_for(desk: Desk, message: m.StandFor) -> None:
    """Let parameters stand for other targets."""
    desk.bind(message.targets)


def watch(desk: Desk, _: m.Watch) -> None:
    """Let silence be consent, or not."""
    desk.watch()


def undo(desk: Desk, _: m.Undo) -> None:
    """Take back a step."""
    desk.undo()


def redo(desk: Desk, _: m.Redo) -> None:
    """Do an undone step again."""
    desk.redo()


def choose(desk: Desk, message: m.Choose) -> None:
    """Choose anew what the lesson is about."""
    choices = Choices(
        states=message.states,
        features=message.features,
        flags=message.flags,
        renamed=message.renamed,
        watched=message.watched,
        reaction_s=message.reaction_s,
        unlearning=message.unlearning,
    )
    desk.choose(choices)


def edit_example(stage: Stage, message: m.Edit) -> None:
    """Let an example say something else."""
    features = {str(bound): bound for bound in stage.trained.features}
    for label in message.values:
        if label not in features:
            raise UnknownName(what="feature", name=label, where="the lesson", known=list(features))
    values = {label: formatting.number(features[label], text) for label, text in message.values.items()}
    stage.trained.edit(message.number, state=message.state, next=message.next, values=values)


def delete_example(desk: Desk, message: m.Delete) -> None:
    """Delete an example."""
    desk.delete(message.number)


def hold_examples(desk: Desk, message: m.Quarantine) -> None:
    """Let examples teach nothing for now."""
    lesson_actions.hold(desk, message.numbers)


def release_examples(desk: Desk, message: m.Release) -> None:
    """Let examples teach again."""
    lesson_actions.release(desk, message.numbers)


def promise(desk: Desk, message: r.Promise) -> None:
    """Let the lesson promise an outcome."""
    lesson_actions.promise(desk, message.flag, message.within_s)


def withdraw(desk: Desk, message: r.Withdraw) -> None:
    """Let the lesson no longer promise an outcome."""
    lesson_actions.withdraw(desk, message.outcome)


def prune(desk: Desk, message: r.Prune) -> None:
    """Learn with fewer questions from now on."""
    lesson_actions.prune(desk, message.pruning)
