"""Choice of the transport that a robot file asks for."""

from __future__ import annotations

from pkgutil import resolve_name
from typing import Any

from understudy.addons.robots.robot_file import RobotFile
from understudy.addons.robots.ros.transport import BUILTIN_TRANSPORTS, Transport
from understudy.entry_points import TRANSPORTS, load_object
from understudy.errors import SettingError

REMEDY = "let the entry point name a function from a RobotFile to a Transport of understudy.spi"


def open_transport(file: RobotFile) -> Transport:
    """Connect to a robot's transport; ExtraMissing or Unreachable is raised if that fails.

    SettingError is raised if it is that of another package, and cannot be loaded or is no transport.
    """
    name = file.transport
    if name in BUILTIN_TRANSPORTS:
        opened: Transport = resolve_name(BUILTIN_TRANSPORTS[name])(file)
        return opened
    open_plugin = load_object(name, TRANSPORTS, where="transport", remedy=REMEDY)
    transport: Any = open_plugin(file) if callable(open_plugin) else open_plugin
    if not isinstance(transport, Transport):
        problem = f"{'returned' if callable(open_plugin) else 'is'} a {type(transport).__name__}"
        raise SettingError(where="transport", setting=repr(name), problem=problem, remedy=REMEDY)
    return transport
