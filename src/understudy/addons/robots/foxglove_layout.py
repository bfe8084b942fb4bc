"""A layout for Foxglove that shows the path, the states and the stops of robots, live or from a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from understudy.addons.robots.recording_transport import list_recorded_names
from understudy.addons.robots.robot_file import RobotFile
from understudy.addons.robots.ros.state_topic import STOPPED
from understudy.records.message_types import READINGS, STATES, resolve_topic_name
from understudy.records.recorder import TOPICS

LEVELS = 3
"""The number of levels of automata whose states are shown."""
PATH, SEEN, CHANGES, LOG, DIAGNOSED = (
    "Plot!path",
    "3D!robots",
    "StateTransitions!states",
    "RawMessages!stopped",
    "DiagnosticSummary!diagnostics",
)
"""The panels: Foxglove takes what is before the sign as the type of panel."""


def make_layout(robots: Sequence[RobotFile]) -> dict[str, Any]:
    """Make a layout, to be written as JSON and imported in Foxglove.

    Parameters
    ----------
    robots
        The robots' files.

    Returns
    -------
    dict
        The layout: a plot of the robots' paths, a view of the frames if there are any, states and stops over time, and
        the diagnostics if there are any.
    """
    names = list_recorded_names(robots)
    panels: dict[str, Mapping[str, Any]] = {
        **{f"{PATH}{number}": _plot_path(name) for number, name in enumerate(names)},
        CHANGES: {
            "title": "States and stops",
            "isSynced": True,
            "paths": [
                {"value": value, "label": label, "enabled": True, "timestampMethod": "receiveTime"}
                for value, label in _list_changes(robots, names)
            ],
        },
        LOG: {"title": "Last stop", "topicPath": resolve_topic_name(robots[0].namespace, STOPPED)},
    }
    framed = next((robot for robot in robots if robot.frames is not None), None)
    if framed is not None and framed.frames is not None:
        fixed, static = (framed.topic(name) for name in (framed.frames.topic, framed.frames.static))
        panels[SEEN] = {
            "title": "Robots",
            "followMode": "follow-none",
            "followTf": framed.frames.fixed,
            "scene": {"transforms": {"editable": False, "enablePreloading": False}},
            "layers": {"grid": {"layerId": "foxglove.Grid", "visible": True, "size": 10, "divisions": 10}},
            "topics": {topic: {"visible": True} for topic in (fixed, static)},
        }
    diagnosed = next((robot for robot in robots if robot.diagnostics is not None), None)
    if diagnosed is not None and diagnosed.diagnostics is not None:
        panels[DIAGNOSED] = {
            "title": "Diagnostics",
            "topicToRender": diagnosed.topic(diagnosed.diagnostics.topic),
            "minLevel": 0,
        }
    return {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _arrange(panels),
    }


def _plot_path(name: str) -> Mapping[str, Any]:
    """Describe a plot of a robot's y over its x, from the readings of its decisions."""
    x, y = (
        f'{resolve_topic_name(name, TOPICS[READINGS])}.readings[:]{{name=="{axis}"}}.value'
        for axis in ("x", "y")
    )
    return {
        "title": f"Path of {name.strip('/')}",
        "isSynced": False,
        "showLegend": False,
        "xAxisVal": "custom",
        "xAxisPath": {"value": x, "enabled": True, "timestampMethod": "receiveTime"},
        "paths": [{"value": y, "label": "y", "enabled": True, "timestampMethod": "receiveTime"}],
    }


def _list_changes(robots: Sequence[RobotFile], names: Sequence[str]) -> list[tuple[str, str]]:
    """List the message paths whose changes are shown over time, with their labels."""
    paths = []
    for robot, name in zip(robots, names, strict=True):
        states, label = resolve_topic_name(name, TOPICS[STATES]), name.strip("/")
        paths += [(f"{states}.path[{level}]", f"{label}: level {level}") for level in range(LEVELS)]
        paths.append((f"{resolve_topic_name(robot.namespace, STOPPED)}.data", f"{label}: stopped"))
    return paths


def _arrange(panels: Mapping[str, Any]) -> Any:
    """Arrange the panels: where robots are above, what they do and why they stop below."""
    above = [*[SEEN] * (SEEN in panels), *(name for name in panels if name.startswith(PATH))]
    below = [name for name in (CHANGES, DIAGNOSED, LOG) if name in panels]
    return {
        "direction": "column",
        "first": _arrange_row(above),
        "second": _arrange_row(below),
        "splitPercentage": 55,
    }


def _arrange_row(names: Sequence[str]) -> Any:
    if len(names) == 1:
        return names[0]
    return {
        "direction": "row",
        "first": names[0],
        "second": _arrange_row(names[1:]),
        "splitPercentage": 100 / len(names),
    }
