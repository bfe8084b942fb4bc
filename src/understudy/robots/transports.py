"""Which transport a robot's file asks for."""

from __future__ import annotations

from understudy.robots.dds import DDS
from understudy.robots.file import RobotFile
from understudy.robots.transport import Transport
from understudy.robots.zenoh import Zenoh


def open_transport(file: RobotFile) -> Transport:
    """The transport of a robot, joined; ExtraMissing or Unreachable where it cannot be."""
    if file.transport == "zenoh":
        return Zenoh(file.domain, file.router)
    return DDS(file.domain)
