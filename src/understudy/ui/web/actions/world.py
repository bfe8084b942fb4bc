"""Handle messages about the world: move, add and remove things by hand; arm and stop real robots."""

from __future__ import annotations

from understudy.addons.robots.arming_order import ArmingOrder
from understudy.errors import SettingError
from understudy.ui.controller.status import StatusMessage
from understudy.ui.web.background import SlowAction
from understudy.ui.web.messages import session as m
from understudy.ui.web.session_host import SessionHost

FOOD = 10
"""Units of food in a source that a person adds."""


def handle_move_robot(host: SessionHost, message: m.MoveRobot) -> None:
    """Move a robot; without a heading it keeps its own."""
    if message.agent >= host.world.robots:
        problem, remedy = f"is {message.agent + 1}", f"give one from 1 to {host.world.robots}"
        raise SettingError(where="the studio", setting="robot", problem=problem, remedy=remedy)
    heading = message.heading
    if heading is None:
        heading = float(host.world.state.robots["heading"][message.agent])
    place = (message.agent, message.x, message.y, heading)
    host.edit_world(lambda world: world.place(*place), f"Robot {message.agent + 1} was moved")


def handle_move_object(host: SessionHost, message: m.MoveObject) -> None:
    """Move an object."""
    host.edit_world(
        lambda world: world.move_object(message.slot, message.x, message.y), "An object was moved"
    )


def handle_add_object(host: SessionHost, message: m.AddObject) -> None:
    """Add an object of a class; a source of food contains 10 units."""
    kind = message.kind
    classes, rules = host.world.names.classes, host.world.rules.classes
    amount = FOOD if kind in classes and rules["food"][classes.index(kind)] else 0
    host.edit_world(
        lambda world: world.add_object(kind, message.x, message.y, amount=amount), f"{kind} was added"
    )


def handle_remove_object(host: SessionHost, message: m.RemoveObject) -> None:
    """Remove an object."""
    host.edit_world(lambda world: world.remove_object(message.slot), "An object was removed")


def handle_add_obstacle(host: SessionHost, message: m.AddObstacle) -> None:
    """Add a round obstacle."""
    place = (message.x, message.y, message.radius)
    host.edit_world(lambda world: world.add_obstacle(*place), "An obstacle was added")
    host.note_world_change()


def handle_move_obstacle(host: SessionHost, message: m.MoveObstacle) -> None:
    """Move a round obstacle."""
    place = (message.index, message.x, message.y)
    host.edit_world(lambda world: world.move_obstacle(*place), "An obstacle was moved")
    host.note_world_change()


def handle_remove_obstacle(host: SessionHost, message: m.RemoveObstacle) -> None:
    """Remove a round obstacle."""
    host.edit_world(lambda world: world.remove_obstacle(message.index), "An obstacle was removed")
    host.note_world_change()


def handle_arm(host: SessionHost, _: m.Arm) -> SlowAction:
    """Arm the real robots."""
    return _arm(host, host.robots.order_arming(), "Armed: the robot moves while time runs. Esc stops it")


def handle_arm_robot(host: SessionHost, message: m.ArmRobot) -> SlowAction:
    """Arm one real robot."""
    return _arm(host, host.robots.order_arming(message.name), f"{message.name} is armed")


def _arm(host: SessionHost, order: ArmingOrder, sentence: str) -> SlowAction:
    """Return the action that carries out an order to arm robots, at whose end `said` is said."""

    def finish() -> StatusMessage:
        order.refuse_overtaken()
        if host.trainer is not None:
            host.trainer.session.refresh_percept()  # what it read before is old by now
        host.frame_version += 1
        return StatusMessage(sentence)

    return SlowAction(StatusMessage("Arming…"), order.carry_out, finish)


def handle_stop_robot(host: SessionHost, message: m.StopRobot) -> StatusMessage:
    """Stop and disarm one real robot; any page may request it, also without control."""
    host.robots.stop_one(message.name, "stopped in the studio")
    host.frame_version += 1
    return StatusMessage(f"{message.name} was told to stop. Arm it again before it can move", "error")


def handle_emergency_stop(host: SessionHost, _: m.EmergencyStop) -> StatusMessage:
    """Stop and disarm real robots, then pause; any page may request it, also without control."""
    host.robots.stop("stopped in the studio")
    host.pause(True)
    host.frame_version += 1
    return StatusMessage("Stopped. Arm the robot again before it can move", "error")


def handle_heartbeat(host: SessionHost, message: m.Heartbeat) -> None:
    """Record that the page in control is alive, and whether the hold-to-run key is held down."""
    host.robots.refresh_heartbeat(holding=message.holding)
