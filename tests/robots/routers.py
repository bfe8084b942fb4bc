"""A router of Zenoh, in this process, for tests: what `ros2 run rmw_zenoh_cpp rmw_zenohd` is on a robot."""

from __future__ import annotations

import json
import os
import socket
from contextlib import ExitStack
from itertools import count
from typing import Any, Self

LOWEST, PORTS, APART = 10_000, 22_000, 101
"""Ports below those that the system hands out itself; where the programs that test at the same time begin."""
_numbers = count()


class Router:
    """Listens on a free port of this machine, until closed, or at an endpoint where one was before."""

    def __init__(self, endpoint: str | None = None) -> None:
        import zenoh

        self.endpoint = endpoint or f"tcp/127.0.0.1:{free_port()}"
        config = zenoh.Config()
        config.insert_json5("mode", '"router"')
        config.insert_json5("listen/endpoints", json.dumps([self.endpoint]))
        config.insert_json5("scouting/multicast/enabled", "false")
        self._session: Any = zenoh.open(config)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._session.close()


def free_port() -> int:
    """A port of TCP and UDP on which nothing listens; programs that test beside this one get others."""
    while True:
        port = LOWEST + (os.getpid() * APART + next(_numbers)) % PORTS
        with ExitStack() as opened:
            try:
                for kind in (socket.SOCK_STREAM, socket.SOCK_DGRAM):
                    opened.enter_context(socket.socket(type=kind)).bind(("127.0.0.1", port))
            except OSError:
                continue
            return port
