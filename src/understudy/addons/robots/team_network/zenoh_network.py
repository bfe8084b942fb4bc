"""The network between the agents of a team over Zenoh: a key for each squad, liveliness tokens for presence."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from threading import Lock
from typing import Any

from understudy.addons.robots.ros.transport import Unreachable
from understudy.errors import SettingError
from understudy.extras import ExtraMissing
from understudy.runtime.agents.network import Inbox, Observe

PREFIX = "understudy"
"""The first part of all keys."""
ANSWERING = 8
"""The number of questions that are answered at the same time."""
WAITING = 4096
"""The number of messages of a key that are kept until they are taken."""
PRESENCE_S = 1.0
"""The longest time in s to wait for the answer whether an agent is there."""
WAIT_MS = 500
"""The time in ms for which a starting agent waits for the others; it goes on connecting to them afterwards."""
SILENT_MS = 5000
"""The time without a message after which a link is closed and made again, ms."""
OPENING_MS = 5000
"""The longest time in ms to make a link: each lost packet of the first ones costs a second."""
RETRY = {"period_init_ms": 100, "period_max_ms": 300, "period_increase_factor": 2}
"""The times in ms after which a link that could not be made is tried again."""
DATAGRAMS = {"udp": "rel=1;mixed_rel=1", "quic": "mixed_rel=1"}
"""The metadata of addresses with which Zenoh sends reliable messages and others over one QUIC connection.

Messages of each tick are then datagrams: a lost one holds up none of the later ones, as it would over TCP.
"""


@dataclass(frozen=True, slots=True)
class ZenohOptions:
    """How agents reach each other.

    Attributes
    ----------
    connect
        The addresses of routers or of other agents, such as `udp/192.168.0.5:7447`.
    listen
        The addresses at which this agent can be reached.
    multicast
        Whether agents look for each other by multicast, which needs no addresses in a local network.
    config
        Further keys of Zenoh's configuration with their values, such as those for TLS and access control.
    """

    connect: Sequence[str] = ()
    listen: Sequence[str] = ()
    multicast: bool = True
    config: Mapping[str, Any] | None = None


class ZenohInbox(Inbox):
    """Messages that a subscriber of Zenoh has received; if they are not taken, the oldest are dropped."""

    def __init__(self, heard: Any, is_closed: Callable[[], bool]) -> None:
        super().__init__()
        self._heard, self._is_closed = heard, is_closed

    def take_all(self) -> list[bytes]:
        """Take all messages, in the order in which they arrived; none once this agent has left."""
        taken: list[bytes] = []
        while not self._is_closed() and (sample := self._heard.try_recv()) is not None:
            taken.append(bytes(sample.payload))
        return taken


class ZenohNetwork:
    """One agent's access to its team over Zenoh; messages arrive in threads of Zenoh.

    Parameters
    ----------
    team
        The name of the team.
    options
        How agents reach each other.

    Raises
    ------
    ExtraMissing
        If Zenoh is not installed.
    Unreachable
        If an address that must be reached does not answer.
    """

    def __init__(self, team: str, options: ZenohOptions = ZenohOptions()) -> None:
        try:
            import zenoh
        except ImportError:
            raise ExtraMissing(what="agents on several computers", extra="ros2") from None
        self._zenoh: Any = zenoh
        self._team = f"{PREFIX}/{team}"
        self._lock = Lock()
        self._present: set[str] = set()
        self._publishers: dict[str, Any] = {}
        self._declared: list[Any] = []
        self._answering = ThreadPoolExecutor(ANSWERING)
        self._closed = False
        try:
            self._session: Any = zenoh.open(_configure(zenoh, options))
        except zenoh.ZError as error:
            where = ", ".join((*options.connect, *options.listen)) or "the network"
            problem = str(error).split(" at /")[0]  # it tells where it was compiled
            remedy = "start the router, or correct [agents.network] in the team's file"
            raise Unreachable(what=where, problem=problem, remedy=remedy) from error
        self._declared.append(
            self._session.liveliness().declare_subscriber(
                f"{self._team}/present/*", self._note_presence, history=True
            )
        )

    def publish(self, key: str, message: bytes) -> None:
        """Send a message to all listeners of a key, without waiting; where the network is slow, it is dropped."""
        with self._lock:
            if self._closed:
                return
            if key not in self._publishers:
                self._publishers[key] = self._session.declare_publisher(
                    f"{self._team}/{key}",
                    congestion_control=self._zenoh.CongestionControl.DROP,
                    reliability=self._zenoh.Reliability.BEST_EFFORT,
                    priority=self._zenoh.Priority.REAL_TIME,
                    express=True,
                )
            self._publishers[key].put(message)

    def listen(self, key: str, observe: Observe | None = None) -> Inbox:
        """Receive the messages of a key from now on, in an inbox of its own."""
        if observe is not None:
            inbox = Inbox(observe=observe)
            self._declared.append(
                self._session.declare_subscriber(f"{self._team}/{key}", partial(self._receive, inbox))
            )
            return inbox
        # Zenoh keeps them until they are taken: a call of Python for each as it arrives costs ten times as much.
        ring = self._zenoh.handlers.RingChannel(WAITING)
        heard = self._session.declare_subscriber(f"{self._team}/{key}", ring)
        self._declared.append(heard)
        return ZenohInbox(heard, lambda: self._closed)

    def _receive(self, inbox: Inbox, sample: Any) -> None:
        if not self._closed:
            inbox.add(bytes(sample.payload))

    def announce(self, name: str) -> None:
        """Let others see that this agent is there, until `close` or the end of its program."""
        self.declare_token(f"present/{name}")

    def declare_token(self, key: str) -> None:
        """Let others see a key, until `close` or the end of this program."""
        self._declared.append(self._session.liveliness().declare_token(f"{self._team}/{key}"))

    def list_tokens(self, key: str) -> list[str]:
        """Ask the network which keys are declared; `*` stands for any part of the key."""
        replies = self._session.liveliness().get(f"{self._team}/{key}", timeout=PRESENCE_S)
        return [str(reply.ok.key_expr) for reply in replies if reply.ok is not None]

    @property
    def present(self) -> frozenset[str]:
        """The names of the agents that are there, as far as is known."""
        with self._lock:
            return frozenset(self._present)

    def is_present(self, name: str) -> bool:
        """Ask the network whether an agent is there; `present` knows of it only a while after this one has joined."""
        return bool(self.list_tokens(f"present/{name}"))

    def answer(self, key: str, answer: Callable[[bytes], bytes]) -> None:
        """Answer questions to a key from now on; `answer` is called in other threads, so that no question waits."""

        def reply(query: Any) -> None:
            with contextlib.suppress(self._zenoh.ZError), query:
                question = b"" if query.payload is None else bytes(query.payload)
                query.reply(f"{self._team}/{key}", answer(question))

        self._declared.append(
            self._session.declare_queryable(
                f"{self._team}/{key}", lambda query: self._answering.submit(reply, query)
            )
        )

    def ask(self, key: str, question: bytes, *, timeout_s: float = 2.0) -> dict[str, bytes]:
        """Ask all agents that answer questions to a key.

        Parameters
        ----------
        key
            The key; `*` stands for any part of it.
        question
            The question.
        timeout_s
            The longest time to wait for answers, s.

        Returns
        -------
        dict
            The answers, by the key of the agent that gave it.
        """
        answers = {}
        for reply in self._session.get(f"{self._team}/{key}", payload=question, timeout=timeout_s):
            if reply.ok is not None:
                answers[str(reply.ok.key_expr).removeprefix(f"{self._team}/")] = bytes(reply.ok.payload)
        return answers

    def close(self) -> None:
        """Leave the network; nothing is received afterwards."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        for each in (*self._declared, *self._publishers.values()):
            with contextlib.suppress(self._zenoh.ZError):
                each.undeclare()
        self._session.close()
        self._answering.shutdown(wait=False)

    def _note_presence(self, sample: Any) -> None:
        name = str(sample.key_expr).rpartition("/")[2]
        with self._lock:
            if sample.kind == self._zenoh.SampleKind.DELETE:
                self._present.discard(name)
            else:
                self._present.add(name)


def complete_address(address: str) -> str:
    """Return an address with the metadata that lets Zenoh send datagrams, unless it has some of its own."""
    metadata = DATAGRAMS.get(address.partition("/")[0])
    if metadata is None or "?" in address:
        return address
    where, sign, config = address.partition("#")
    return f"{where}?{metadata}{sign}{config}"


def _configure(zenoh: Any, options: ZenohOptions) -> Any:
    """Make the configuration of a session: a peer that others reach directly or through routers."""
    config = zenoh.Config()
    # not open without TLS where others use it
    protocol = options.connect[0].partition("/")[0] if options.connect else "udp"
    settings = {
        "mode": "peer",
        "connect/endpoints": [complete_address(each) for each in options.connect],
        "connect/timeout_ms": WAIT_MS,
        "connect/exit_on_failure": False,
        "connect/retry": RETRY,
        "listen/endpoints": [complete_address(each) for each in options.listen or [f"{protocol}/[::]:0"]],
        "transport/link/tx/lease": SILENT_MS,
        "transport/unicast/open_timeout": OPENING_MS,
        "transport/unicast/accept_timeout": OPENING_MS,
        "scouting/multicast/enabled": options.multicast,
        "scouting/gossip/enabled": True,
        "transport/shared_memory/enabled": False,
        **(options.config or {}),
    }
    for key, value in settings.items():
        try:
            config.insert_json5(key, json.dumps(value))
        except zenoh.ZError as error:
            problem = str(error).split(" at /")[0]
            raise SettingError(
                where="[agents.network.config]", setting=key, problem=f"is refused by Zenoh ({problem})",
                remedy="give a key of its configuration with a value of its type",
            ) from None  # fmt: skip
    return config
