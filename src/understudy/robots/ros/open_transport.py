"""Choice of the transport that a robot file asks for."""

from __future__ import annotations

from understudy.robots.robot_file import RobotFile
from understudy.robots.ros.dds import DdsTransport
from understudy.robots.ros.transport import Transport
from understudy.robots.ros.zenoh import ZenohTransport


def open_transport(file: RobotFile) -> Transport:
    """Connect to a robot's transport; ExtraMissing or Unreachable is raised if that fails."""
    if file.transport == "zenoh":
        return ZenohTransport(file.domain, file.router)
    return DdsTransport(file.domain)
