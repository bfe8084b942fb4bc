"""Servers of an action and a service over Zenoh, as robots have them: their keys are written by hand here.

    python -m tests.robots.skill_servers ENDPOINT

serves until it is killed, which tests do in the middle of a goal.
"""

from __future__ import annotations

import json
import struct
import sys
import time
from collections.abc import Callable
from pathlib import Path
from threading import Event, Thread
from typing import Any, Self

from tests.robots.skill_rigs import ABORTED, CANCELED, DEFINITIONS, NAVIGATE, SUCCEEDED, TRIGGER, Conduct

from understudy.addons.robots.ros.interfaces import CANCEL, Interfaces


class Server:
    """The action /rover/navigate_to_pose and the service /rover/beep in domain 43; `conduct` says what they do.

    This one is over Zenoh. A goal sends feedback (the distance left: 3, 2, 1) and ends as `conduct` says; "run" goes
    on until cancelled.
    """

    def __init__(
        self, endpoint: str, conduct: Conduct = "succeed", *, definitions: Path = DEFINITIONS
    ) -> None:
        self.conduct, self._closed = conduct, False
        self._open(endpoint)
        self._interfaces, self._kept = Interfaces(definitions), list[Any]()
        self.goals: list[Any] = []
        self.requests = 0
        self.cancelled_s: list[float] = []
        self.cancelled: list[bytes] = []
        """When goals were to be cancelled, and their ids, one for each request; an id of zeros means all goals."""
        self.cancels: dict[bytes, Event] = {}
        self.asked: set[bytes] = set()
        """The goals whose result was asked for."""
        self._runs: list[Thread] = []
        self._held: list[Any] = []
        """Queries without an answer; Zenoh takes a query that is dropped for answered."""
        types = self._interfaces.find_action(NAVIGATE)
        action, package = "/rover/navigate_to_pose/_action", "nav2_msgs::action::dds_::NavigateToPose"
        self._send, self._result = types.send_goal, types.get_result
        self._cancel, self._trigger = (
            self._interfaces.find_service(CANCEL),
            self._interfaces.find_service(TRIGGER),
        )
        self._serve(f"{action}/send_goal", f"{package}_SendGoal_", self._send.wire.hash, self._accept)
        self._serve(
            f"{action}/get_result", f"{package}_GetResult_", self._result.wire.hash, self._tell_result
        )
        cancel = "action_msgs::srv::dds_::CancelGoal_"
        self._serve(f"{action}/cancel_goal", cancel, self._cancel.wire.hash, self._take_back)
        self._serve("/rover/beep", "std_srvs::srv::dds_::Trigger_", self._trigger.wire.hash, self._beep)
        message = types.feedback_message
        self._feedback_type = message.name
        self._publish = self._publisher(f"{action}/feedback", f"{package}_FeedbackMessage_", message.hash)

    def close(self) -> None:
        if self._closed:
            return
        self._closed = True
        for each in self.cancels.values():
            each.set()
        for thread in self._runs:
            thread.join()
        self._shut()
        self._held.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _open(self, endpoint: str) -> None:
        import zenoh

        config = zenoh.Config()
        config.insert_json5("mode", '"client"')
        config.insert_json5("connect/endpoints", json.dumps([endpoint]))
        self._session: Any = zenoh.open(config)

    def _shut(self) -> None:
        self._session.close()

    def _publisher(self, topic: str, type: str, hash: str) -> Callable[[bytes], None]:
        key = f"43{topic}/{type}/{hash}"
        return lambda data: self._session.put(key, data)

    def _serve(self, name: str, type: str, hash: str, answer: Any) -> None:
        self._kept.append(self._session.declare_queryable(f"43{name}/{type}/{hash}", answer, complete=True))
        node = f"@ros2_lv/43/{self._session.zid()}/0/{len(self._kept)}/SS/%/%/nav"
        token = f"{node}/{name.replace('/', '%')}/{type}/{hash}"
        self._kept.append(self._session.liveliness().declare_token(f"{token}/::,10:,:,:,,"))

    def _reply(self, query: Any, type: str, **values: Any) -> None:
        self._answer(query, self._interfaces.encode(type, self._interfaces.make(type, **values)))

    def _answer(self, query: Any, data: bytes) -> None:
        number, _, length, id = struct.unpack("<qqB16s", bytes(query.attachment))
        assert length == 16
        query.reply(query.key_expr, data, attachment=struct.pack("<qqB16s", number, time.time_ns(), 16, id))

    def _accept(self, query: Any) -> None:
        request = self._interfaces.decode(self._send.request, bytes(query.payload))
        if self.conduct == "silent":
            self._held.append(query)
            return
        self.goals.append(request)
        self.cancels[bytes(request.goal_id.uuid)] = Event()
        self._reply(query, self._send.response, accepted=self.conduct != "reject")

    def _tell_result(self, query: Any) -> None:
        request = self._interfaces.decode(self._result.request, bytes(query.payload))
        self.asked.add(bytes(request.goal_id.uuid))
        self._runs.append(Thread(target=self._run, args=(query, request.goal_id), daemon=True))
        self._runs[-1].start()

    def _run(self, query: Any, goal_id: Any) -> None:
        cancelled = self.cancels[bytes(goal_id.uuid)]
        for left in (3.0, 2.0, 1.0):
            feedback = self._interfaces.make(f"{NAVIGATE}_Feedback", distance_remaining=left)
            message = self._interfaces.make(self._feedback_type, goal_id=goal_id, feedback=feedback)
            self._publish(self._interfaces.encode(self._feedback_type, message))
            time.sleep(0.02)
        if self.conduct == "run":
            cancelled.wait(600)
        status = CANCELED if cancelled.is_set() else ABORTED if self.conduct == "abort" else SUCCEEDED
        self._reply(query, self._result.response, status=status)

    def _take_back(self, query: Any) -> None:
        request = self._interfaces.decode(self._cancel.request, bytes(query.payload))
        id = bytes(request.goal_info.goal_id.uuid)
        self.cancelled_s.append(time.monotonic())
        self.cancelled.append(id)
        for each in self.cancels if id == bytes(16) else [id]:
            if each in self.cancels:
                self.cancels[each].set()
        self._reply(query, self._cancel.response)

    def _beep(self, query: Any) -> None:
        self.requests += 1
        if self.conduct == "silent":
            self._held.append(query)
        else:
            self._reply(query, self._trigger.response, success=self.conduct == "succeed")


def main(endpoint: str, conduct: Conduct = "run") -> None:
    with Server(endpoint, conduct):
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        time.sleep(600)


if __name__ == "__main__":
    main(*sys.argv[1:])  # type: ignore[arg-type]
