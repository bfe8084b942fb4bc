"""The base task as users of other simulators would write it, each given its best honest chance."""

from __future__ import annotations

from understudy.errors import UnderstudyError


class PeerMissing(UnderstudyError):
    """A peer to be measured beside is not installed."""

    def __init__(self, *, peer: str, extra: str = "bench") -> None:
        self.peer = peer
        super().__init__(
            f"the comparison needs {peer}, not installed here; install it with: pip install 'understudy[{extra}]'"
        )
