"""Requests to services over Zenoh, as rmw_zenoh of ROS 2 sends them: a query with the request as its payload.

The attachment is that of a message: sequence number, time, and the id of the client.
"""

from __future__ import annotations

import contextlib
import struct
import time
import uuid
from threading import Lock
from typing import Any

from understudy.addons.robots.ros.transport import Answered
from understudy.records.messages import convert_to_dds_name

ATTACHED = struct.Struct("<qqB16s")
"""The layout of an attachment: sequence number, time (ns since 1970), length of the id, id."""


def make_service_key(domain: int, name: str, type: str, hash: str) -> str:
    """Return the key of a service, or of a topic whose type has this hash."""
    return f"{domain}/{name.strip('/')}/{convert_to_dds_name(type)}/{hash}"


class ServiceCalls:
    """The pending requests of a session, whose answers come in threads of Zenoh."""

    def __init__(self, zenoh: Any, session: Any, domain: int) -> None:
        self._zenoh, self._session, self._domain = zenoh, session, domain
        self._id, self._sent = uuid.uuid4().bytes, 0
        self._lock, self._pending, self._closed = Lock(), set[Any](), False

    def call(self, key: str, request: bytes, answered: Answered, *, timeout_s: float) -> None:
        """Send a request to the services with a key; the first answer counts, None if there is none."""
        zenoh, token = self._zenoh, self._zenoh.CancellationToken()
        answers: list[bytes] = []
        with self._lock:
            if self._closed:
                return
            self._sent += 1
            self._pending.add(token)
            attached = ATTACHED.pack(self._sent, time.time_ns(), 16, self._id)

        def came(reply: Any) -> None:
            if reply.ok is not None and not answers:
                answers.append(bytes(reply.ok.payload))
                if not self._closed:
                    answered(answers[0])

        def ended() -> None:
            with self._lock:
                self._pending.discard(token)
                closed = self._closed
            if not answers and not closed:
                answered(None)

        self._session.get(
            key,
            zenoh.handlers.Callback(came, ended),
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=timeout_s,
            payload=request,
            attachment=attached,
            congestion_control=zenoh.CongestionControl.BLOCK,
            express=True,
            cancellation_token=token,
        )

    def cancel(self) -> None:
        """Stop waiting for answers: threads that wait would keep the program alive."""
        with self._lock:
            pending = list(self._pending)
        for token in pending:
            with contextlib.suppress(self._zenoh.ZError):
                token.cancel()

    def close(self) -> None:
        """Drop pending requests without calling anybody."""
        with self._lock:
            self._closed = True
        self.cancel()
