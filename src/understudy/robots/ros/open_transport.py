"""Which transport a robot's file asks for."""

from __future__ import annotations

from understudy.robots.robot_file import RobotFile
from understudy.robots.ros.dds import DDS
from understudy.robots.ros.transport import Transport
from understudy.robots.ros.zenoh import Zenoh


def open_transport(file: RobotFile) -> Transport:
    """The transport of a robot, joined; ExtraMissing or Unreachable where it cannot be."""
    if file.transport == "zenoh":
        return Zenoh(file.domain, file.router)
    return DDS(file.domain)
