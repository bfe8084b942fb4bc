"""Learn colors that a person clicks in the images of real robots' cameras."""

from __future__ import annotations

from understudy.addons.robots.camera.color import Color
from understudy.addons.robots.camera.config import write_color
from understudy.addons.robots.camera.live_camera import LiveCamera
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.twin import DigitalTwin
from understudy.errors import SessionError, SettingError
from understudy.ui.controller.status import StatusMessage
from understudy.ui.web.messages.base import Data
from understudy.ui.web.messages.session import PickColor
from understudy.ui.web.session_host import SessionHost


class ColorReply(Data, frozen=True, kw_only=True):
    """The color that was learned."""

    color: Color


def handle_pick_color(host: SessionHost, message: PickColor) -> ColorReply:
    """Learn a color from clicks, detect it from now on, and write it into the robot's file."""
    robot, camera = find_live_camera(host, message.robot)
    color = camera.learn_color(message.name, message.image, [(x, y) for x, y in message.points])
    if robot.path.is_file():
        write_color(robot.path, message.name, color)
    host.status = StatusMessage(
        f"Cameras detect {message.name} by this color now; saved in {robot.path.name}", "recorded"
    )
    return ColorReply(color=color)


def find_live_camera(host: SessionHost, number: int) -> tuple[Robot, LiveCamera]:
    """Return a real robot and its camera; an error if there is none."""
    if not isinstance(host.world, DigitalTwin):
        raise SessionError("these robots are simulated: their cameras need no calibration")
    robots = host.world.fleet.robots
    if not 0 <= number < len(robots):
        remedy = f"give one from 1 to {len(robots)}"
        raise SettingError(where="the studio", setting="robot", problem=f"is {number + 1}", remedy=remedy)
    camera = robots[number].senses.camera
    if camera is None:
        raise SessionError(f"{robots[number].file.name} has no camera: add [camera] to its file")
    return robots[number], camera
