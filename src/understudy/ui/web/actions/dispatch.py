"""Directing: what each message does on the stage, and what its answer says beside that it was done."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, TypeAlias

from understudy.errors import SettingError, UnknownName
from understudy.ui.controller import formatting, lesson_actions
from understudy.ui.controller.clock import FASTEST
from understudy.ui.controller.lesson_actions import prune
from understudy.ui.controller.status import Said
from understudy.ui.controller.training_plan import Choices
from understudy.ui.web.actions import camera, coach, library, session
from understudy.ui.web.messages import coach as c
from understudy.ui.web.messages import review as r
from understudy.ui.web.messages import session as m
from understudy.ui.web.messages.base import Data, Message
from understudy.ui.web.session_host import Stage
from understudy.ui.web.views import explanation, lesson_test

FOOD = 10
"""Units in a source of food that somebody adds."""

Action: TypeAlias = Callable[[Stage, Any], Data | None]


def obey(stage: Stage, message: Message) -> Data | None:
    """Do what a message says; UnderstudyError where it cannot be done, and nothing is changed."""
    return ACTIONS[type(message)](stage, message)


def _pause(stage: Stage, message: m.Pause) -> None:
    stage.pause(message.paused)


def _step(stage: Stage, message: m.Step) -> None:
    stage.step()


def _speed(stage: Stage, message: m.Speed) -> None:
    stage.set_speed(FASTEST if message.speed == "fastest" else message.speed)


def _reset(stage: Stage, message: m.Reset) -> None:
    stage.reset(message.seed)


def _rewind(stage: Stage, message: m.Rewind) -> None:
    if (message.time_s is None) == (message.example is None):
        problem, remedy = "says nothing, or two things", "give a time or an example"
        raise SettingError(where="the studio", setting="rewind", problem=problem, remedy=remedy)
    if message.example is not None:
        session.go_to_example(stage, message.example)
    elif message.time_s is not None:
        stage.rewind(stage.reel.at(message.time_s))


def _open(stage: Stage, message: m.Open) -> None:
    session.go_on(stage, message.name, discard=message.discard)


def _new(stage: Stage, message: m.New) -> None:
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


def _choose(stage: Stage, message: m.Choose) -> None:
    choices = Choices(
        states=message.states,
        features=message.features,
        flags=message.flags,
        renamed=message.renamed,
        watched=message.watched,
        reaction_s=message.reaction_s,
        unlearning=message.unlearning,
    )
    stage.trained.choose(choices)
    stage.moved += 1


def _edit(stage: Stage, message: m.Edit) -> None:
    features = {str(bound): bound for bound in stage.trained.features}
    for label in message.values:
        if label not in features:
            raise UnknownName(what="feature", name=label, where="the lesson", known=list(features))
    values = {label: formatting.number(features[label], text) for label, text in message.values.items()}
    stage.trained.edit(message.number, state=message.state, next=message.next, values=values)


def _agent(stage: Stage, message: m.Agent) -> None:
    if message.sort != stage.sort or session.knows_other(stage, message.agent):
        session.choose_sort(stage, message.sort, message.agent, discard=message.discard)
    session.choose_agent(stage, message.agent)
    stage.moved += 1


def _place(stage: Stage, message: m.Place) -> None:
    if message.agent >= stage.world.robots:
        problem, remedy = f"is {message.agent + 1}", f"give one from 1 to {stage.world.robots}"
        raise SettingError(where="the studio", setting="robot", problem=problem, remedy=remedy)
    heading = message.heading
    if heading is None:
        heading = float(stage.world.state.robots["heading"][message.agent])
    place = (message.agent, message.x, message.y, heading)
    stage.put(lambda world: world.place(*place), f"Robot {message.agent + 1} was put elsewhere")


def _move_object(stage: Stage, message: m.MoveObject) -> None:
    stage.put(lambda world: world.move_object(message.slot, message.x, message.y), "An object was moved")


def _add_object(stage: Stage, message: m.AddObject) -> None:
    kind = message.kind
    classes, rules = stage.world.names.classes, stage.world.rules.classes
    amount = FOOD if kind in classes and rules["food"][classes.index(kind)] else 0
    stage.put(lambda world: world.add_object(kind, message.x, message.y, amount=amount), f"{kind} was added")


def _remove_object(stage: Stage, message: m.RemoveObject) -> None:
    stage.put(lambda world: world.remove_object(message.slot), "An object was removed")


def _add_obstacle(stage: Stage, message: m.AddObstacle) -> None:
    place = (message.x, message.y, message.radius)
    stage.put(lambda world: world.add_obstacle(*place), "An obstacle was added")
    stage.changed()


def _move_obstacle(stage: Stage, message: m.MoveObstacle) -> None:
    place = (message.index, message.x, message.y)
    stage.put(lambda world: world.move_obstacle(*place), "An obstacle was moved")
    stage.changed()


def _remove_obstacle(stage: Stage, message: m.RemoveObstacle) -> None:
    stage.put(lambda world: world.remove_obstacle(message.index), "An obstacle was removed")
    stage.changed()


def _arm(stage: Stage, _: m.Arm) -> None:
    stage.robots.arm()
    if stage.desk is not None:
        stage.desk.session.look()  # what it read before is old by now
    stage.said = Said("Armed: it moves when time goes on. Esc stops it")
    stage.moved += 1


def _stop(stage: Stage, _: m.Stop) -> None:
    stage.robots.stop("stopped in the studio")
    stage.pause(True)
    stage.said = Said("Stopped. Arm it again before it moves", "error")
    stage.moved += 1


def _desk(action: Callable[[Any, Any], object]) -> Action:
    """What the desk does without moving the world."""

    def act(stage: Stage, message: Any) -> None:
        action(stage.trained, message)
        stage.moved += 1

    return act


ACTIONS: Mapping[type[Message], Action] = MappingProxyType(
    {
        m.Press: lambda stage, message: coach.press(stage, message.state),
        m.Confirm: lambda stage, _: coach.press(stage, None),
        m.Turn: _desk(lambda desk, _: desk.turn()),
        m.Undo: _desk(lambda desk, _: desk.undo()),
        m.Redo: _desk(lambda desk, _: desk.redo()),
        m.Restart: _desk(lambda desk, _: desk.restart()),
        m.Delete: _desk(lambda desk, message: desk.delete(message.number)),
        m.Quarantine: _desk(lambda desk, message: lesson_actions.hold(desk, message.numbers)),
        m.Release: _desk(lambda desk, message: lesson_actions.release(desk, message.numbers)),
        m.Pause: _pause,
        m.Arm: _arm,
        m.Stop: _stop,
        m.PickColor: camera.pick,
        m.Here: lambda stage, message: stage.robots.hear(holding=message.holding),
        m.Step: _step,
        m.Speed: _speed,
        m.Reset: _reset,
        m.Rewind: _rewind,
        m.StandFor: _desk(lambda desk, message: desk.bind(message.targets)),
        m.Open: _open,
        m.New: _new,
        m.Choose: _choose,
        m.Edit: _edit,
        m.Remove: lambda stage, message: library.remove(stage, message.name),
        m.Restore: lambda stage, message: library.restore(stage, message.name),
        m.Discard: lambda stage, message: library.discard(stage, message.name),
        m.Recall: lambda stage, message: library.recall(stage, message.name),
        m.Rename: lambda stage, message: library.rename(stage, message.name, message.to),
        m.Duplicate: lambda stage, message: library.duplicate(stage, message.name, message.to),
        m.GoBack: lambda stage, message: library.go_back(stage, message.name, message.version),
        m.Agent: _agent,
        m.Others: lambda stage, message: session.occupy(stage, message.behavior, message.targets),
        m.Watch: _desk(lambda desk, _: desk.watch()),
        m.Place: _place,
        m.MoveObject: _move_object,
        m.AddObject: _add_object,
        m.RemoveObject: _remove_object,
        m.AddObstacle: _add_obstacle,
        m.MoveObstacle: _move_obstacle,
        m.RemoveObstacle: _remove_obstacle,
        r.Why: lambda stage, _: explanation.told(stage),
        r.Promise: _desk(lambda desk, message: lesson_actions.promise(desk, message.flag, message.within_s)),
        r.Withdraw: _desk(lambda desk, message: lesson_actions.withdraw(desk, message.outcome)),
        r.Visit: lambda stage, message: lesson_test.visit(stage, message.outcome),
        r.Test: lambda stage, message: lesson_test.describe_lesson_test(stage, message.name),
        r.Save: lambda stage, message: library.save_current_automaton(
            stage, message.name, anyway=message.anyway
        ),
        r.Simplify: lambda stage, message: lesson_test.describe_simplification(stage, message.pruning),
        r.Prune: _desk(lambda desk, message: prune(desk, message.pruning)),
        r.Versions: lambda stage, message: library.listed(stage, message.name),
        r.Changes: lambda stage, message: library.told(stage, message.name, message.version, message.to),
        c.Advise: lambda stage, _: coach.told(stage),
        c.SetUp: coach.set_up,
        c.AskWhen: coach.ask_when,
        c.GoToMark: coach.go_to_mark,
        c.UseReaction: coach.use_reaction,
        c.Mend: coach.mend,
        c.StandBy: coach.stand_by,
    }
)
