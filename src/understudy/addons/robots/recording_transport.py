"""Recording of what a robot receives and sends."""

from __future__ import annotations

from collections.abc import Sequence

from understudy.addons.robots.robot_file import RobotFile
from understudy.addons.robots.ros.transport import Publish, Received, Transport, TransportWrapper
from understudy.records.recorder import RunRecorder


class RecordingTransport(TransportWrapper):
    """A transport that records all messages that are received and sent through another transport.

    Requests to services, their answers and the feedback of actions are passed on and not recorded.
    """

    def __init__(self, transport: Transport, recorder: RunRecorder) -> None:
        super().__init__(transport)
        self._recorder = recorder
        self._heard: set[tuple[str, str]] = set()

    def subscribe(self, topic: str, type: str, received: Received, *, kept: bool = False) -> None:
        """Pass each message of a topic to `received`, and record it once, however many subscribers there are."""
        if (topic, type) in self._heard:
            self._transport.subscribe(topic, type, received, kept=kept)
            return
        self._heard.add((topic, type))
        keep = self._recorder.open_topic(topic, type)

        def both(data: bytes, at_s: float) -> None:
            keep(data, at_s)
            received(data, at_s)

        self._transport.subscribe(topic, type, both, kept=kept)

    def publisher(self, topic: str, type: str) -> Publish:
        """Make a function that publishes on a topic and records its messages."""
        publish, keep = self._transport.publisher(topic, type), self._recorder.open_topic(topic, type)

        def both(data: bytes) -> None:
            publish(data)
            keep(data, None)

        return both


def list_recorded_names(robots: Sequence[RobotFile]) -> list[str]:
    """List the unique names under which robots are recorded; in two domains two may have the same namespace."""
    names = [robot.namespace or robot.name for robot in robots]
    plain = [name.strip("/") for name in names]
    return [
        name if plain.count(name.strip("/")) == 1 else f"{name.rstrip('/')}/robot{number}"
        for number, name in enumerate(names)
    ]
