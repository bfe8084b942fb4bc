"""Records of a robot's skills, published as text: each goal, the feedback as it changes, and how each ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from understudy.addons.robots.ros.transport import Transport
from understudy.addons.robots.skills.execution import Execution
from understudy.records.message_types import TEXT, encode_text, resolve_topic_name
from understudy.storage.json_text import encode_json

TOPIC = "understudy/skills"
"""The topic of records of skills, within the robot's namespace."""


class SkillRecords:
    """The published state of a robot's skills, by which changes are found.

    Parameters
    ----------
    transport
        The transport to the robot; recordings keep what is published over it.
    namespace
        The robot's namespace.
    """

    def __init__(self, transport: Transport, namespace: str) -> None:
        self._publish = transport.publisher(resolve_topic_name(namespace, TOPIC), TEXT)
        self._told: dict[str, tuple[Execution, Mapping[str, float], str]] = {}

    def publish_changes(self, skill: str, execution: Execution) -> None:
        """Publish the changes of the last execution of a skill: its goal, its feedback, its outcome."""
        published, feedback, outcome = self._told.get(skill, (None, {}, ""))
        now = execution.feedback, execution.outcome
        if published is not execution:
            feedback, outcome = {}, ""
            if execution.goal is not None:
                self._write(skill, "goal", values=to_plain(execution.goal))
        if now[0] != feedback:
            self._write(skill, "feedback", values=dict(now[0]))
        if now[1] != outcome:
            self._write(skill, now[1], problem=execution.problem, values=to_plain(execution.result))
        self._told[skill] = (execution, *now)

    def _write(self, skill: str, step: str, **about: Any) -> None:
        record = {"skill": skill, "step": step, **{name: value for name, value in about.items() if value}}
        self._publish(encode_text(encode_json(record).decode()))


def to_plain(message: Any) -> Any:
    """Convert a ROS 2 message to objects, lists, numbers and texts; None stays None."""
    if is_dataclass(message):
        return {
            field.name: to_plain(getattr(message, field.name))
            for field in fields(message)
            if not field.name.startswith("_")
        }
    if isinstance(message, np.ndarray):
        return message.tolist()
    if isinstance(message, np.generic):
        return message.item()
    return [to_plain(each) for each in message] if isinstance(message, list) else message
