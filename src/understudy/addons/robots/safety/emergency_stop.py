"""Emergency stop of a robot from any computer on its network (`understudy robots stop`), whichever program drives it.

Stops are sent directly to the robot for `HALTING_S`, and all goals of its skills are cancelled. A program of
Understudy that drives it detects another publisher of commands within 0.3 s, disarms the robot and repeats stops
itself, so that it stands afterwards. Any other program (Nav2, a joystick's node) does not react: between two stops
its commands get through, and after the last stop the robot drives on. This runs in the thread that calls it, and
needs no guard or watchdog.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from pathlib import Path

from understudy.addons.robots.robot_file import RobotFile
from understudy.addons.robots.ros.open_transport import open_transport
from understudy.addons.robots.ros.transport import Transport
from understudy.addons.robots.safety.stop_log import append_stop, find_stop_log, make_stop_event
from understudy.addons.robots.skills.cancel_all import make_cancel_sender
from understudy.clock import REAL_TIME, Clock
from understudy.records.messages import encode_twist

HALTING_S = 2.0
"""Duration of sending stops, s: several times as long as a guard takes to detect another publisher."""
PERIOD_S = 0.02
"""Time between two stops, s."""


def make_stop_sender(file: RobotFile, transport: Transport) -> Callable[[], None]:
    """Make a function that sends one stop (zero speeds) to a robot, with the time of day as the stamp if it has one."""
    commands = file.commands
    publish = transport.publisher(file.topic(commands.topic), commands.type)

    def stop() -> None:
        publish(
            encode_twist(
                commands.type, speed_m_s=0.0, turn_rad_s=0.0, frame=commands.frame, time_s=time.time()
            )
        )

    return stop


def send_emergency_stop(
    file: RobotFile, *, path: Path | str, by: str, seconds: float = HALTING_S, clock: Clock = REAL_TIME
) -> bool:
    """Send stops for the given time (s), and log that a person stopped the robot; return whether it was found.

    It was found if a publisher on one of the robot's sensor topics was discovered: otherwise the stops may have
    reached no robot. A log that cannot be written is ignored.
    """
    transport = open_transport(file)
    try:
        stop, until = make_stop_sender(file, transport), clock() + seconds
        cancel = make_cancel_sender(file, transport)
        stop()
        with contextlib.suppress(OSError):
            append_stop(find_stop_log(file, path), make_stop_event(file.name, "a person stopped it", by))
        while clock() < until:
            stop()
            cancel()
            clock.sleep(PERIOD_S)
        return not list_robot_topics(file).isdisjoint(peer.topic for peer in transport.peers())
    finally:
        transport.close()


def list_robot_topics(file: RobotFile) -> set[str]:
    """List the topics of a robot's sensors, by which its presence is detected."""
    named = [reading.topic for reading in file.readings.values()]
    named += [target.topic for target in file.targets.values() if target.topic is not None]
    named += [] if file.camera is None else [file.camera.topic]
    return {file.topic(name) for name in named}
