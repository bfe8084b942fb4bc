"""Publication of a robot's state changes: one message per change on a topic.

A message is JSON text in a std_msgs/String, so that rosbag and `ros2 topic echo` need no definitions of ours.
"""

from __future__ import annotations

from understudy.addons.robots.ros.transport import Transport
from understudy.records.message_types import TEXT, detect_state_change, encode_text, resolve_topic_name
from understudy.storage.json_text import encode_json

TOPIC = "understudy/transitions"
"""The topic of state changes, within the robot's namespace."""
STOPPED = "understudy/stopped"
"""The topic of stops, within the robot's namespace: why the robot is stopped or disarmed, or nothing while it moves."""


class StateChangePublisher:
    """A publisher of the state changes and stops of one robot, which is given the states after each tick."""

    def __init__(self, transport: Transport, *, namespace: str = "", robot: str = "") -> None:
        self._robot, self._path = robot, tuple[str, ...]()
        self._publish = transport.publisher(resolve_topic_name(namespace, TOPIC), TEXT)
        self._publish_stop = transport.publisher(resolve_topic_name(namespace, STOPPED), TEXT)
        self._stopped: str | None = None

    def publish_changes(self, time_s: float, path: tuple[str, ...], *, stopped: str = "") -> None:
        """Publish what changed since the last tick, if anything.

        `time_s` is the body's time in s; `stopped` is why the robot is stopped, or nothing while it may move.
        """
        if stopped != self._stopped:
            self._stopped = stopped
            self._publish_stop(encode_text(stopped))
        changed = detect_state_change(self._path, path)
        if changed is None:
            return
        self._path = path
        record = {"time_s": time_s, "robot": self._robot, **changed._asdict(), "path": path}
        self._publish(encode_text(encode_json(record).decode()))
