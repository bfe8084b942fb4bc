"""Stop a robot from anywhere: whoever drives it hears that somebody else commands it, and is disarmed."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from pathlib import Path

from understudy.robots.robot_file import RobotFile
from understudy.robots.ros.messages import encode_twist
from understudy.robots.ros.open_transport import open_transport
from understudy.robots.ros.transport import Transport
from understudy.robots.safety.stop_log import append_stop, find_stop_log, make_stop_event

HALTING_S = 2.0
PERIOD_S = 0.02


def make_stop_sender(file: RobotFile, transport: Transport) -> Callable[[], None]:
    """What sends one stop to a robot."""
    commands = file.commands
    publish = transport.publisher(file.topic(commands.topic), commands.type)

    def stop() -> None:
        publish(
            encode_twist(
                commands.type, speed_m_s=0.0, turn_rad_s=0.0, frame=commands.frame, time_s=time.time()
            )
        )

    return stop


def send_emergency_stop(file: RobotFile, *, path: Path | str, by: str, seconds: float = HALTING_S) -> bool:
    """Send stop over and over for so long, and log it; whether anybody was there who publishes what the robot does."""
    transport = open_transport(file)
    try:
        stop, until = make_stop_sender(file, transport), time.monotonic() + seconds
        stop()
        with contextlib.suppress(OSError):
            append_stop(find_stop_log(file, path), make_stop_event(file.name, "a person stopped it", by))
        while time.monotonic() < until:
            stop()
            time.sleep(PERIOD_S)
        return not list_robot_topics(file).isdisjoint(peer.topic for peer in transport.peers())
    finally:
        transport.close()


def list_robot_topics(file: RobotFile) -> set[str]:
    """The topics that a robot speaks on."""
    named = [reading.topic for reading in file.readings.values()]
    named += [target.topic for target in file.targets.values() if target.topic is not None]
    named += [] if file.camera is None else [file.camera.topic]
    return {file.topic(name) for name in named}
