"""A router of Zenoh, in this process, for tests: what `ros2 run rmw_zenoh_cpp rmw_zenohd` is on a robot."""

from __future__ import annotations

import json
import socket
from typing import Any, Self


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
    """A port of TCP that nobody listens on."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port: int = one.getsockname()[1]
        return port
