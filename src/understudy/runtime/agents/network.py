"""The network between agents: messages by key, and the agents that are present; and one within a single process."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from random import Random
from typing import NamedTuple, Protocol, TypeAlias

Observe: TypeAlias = Callable[[bytes], None]
"""A function that is called with each message as soon as it arrives, such as to record it."""


class Inbox:
    """Messages that have arrived and were not taken yet; a network's threads may add to it at any time.

    If they are not taken, the oldest are dropped. `observe` is called with each message as soon as it arrives.
    """

    def __init__(self, most: int = 4096, *, observe: Observe | None = None) -> None:
        self._waiting: deque[bytes] = deque(maxlen=most)
        self._observe = observe

    def add(self, message: bytes) -> None:
        """Add a message."""
        if self._observe is not None:
            self._observe(message)
        self._waiting.append(message)

    def take_all(self) -> list[bytes]:
        """Take all messages, in the order in which they arrived."""
        taken = []
        while self._waiting:
            taken.append(self._waiting.popleft())
        return taken


class Network(Protocol):
    """One agent's access to the network of its team."""

    def publish(self, key: str, message: bytes) -> None:
        """Send a message to all listeners of a key, without waiting; it may be lost, late, or doubled."""
        ...

    def listen(self, key: str, observe: Observe | None = None) -> Inbox:
        """Receive the messages of a key from now on, in an inbox of its own."""
        ...

    def announce(self, name: str) -> None:
        """Let others see that this agent is there, until `close`."""
        ...

    @property
    def present(self) -> frozenset[str]:
        """The names of the agents that are there, as far as is known."""
        ...

    def close(self) -> None:
        """Leave the network."""
        ...


class Envelope(NamedTuple):
    """A message on its way: the number of the step in which it arrives, its sender, its key, and its content."""

    due: int
    sender: str
    key: str
    content: bytes


Fate = Callable[[str, str, int], list[int]]
"""A function of sender, receiver and step: after how many steps each copy of a message arrives; none: it is lost."""


def deliver_at_once(sender: str, receiver: str, step: int) -> list[int]:
    """Deliver every message once and at once."""
    return [0]


def make_fate(ticks: int, loss: float, *, seed: int = 0) -> Fate:
    """Make the fate of messages that arrive `ticks` steps later, and of which a share `loss` is lost."""
    if loss == 0.0 and ticks == 0:
        return deliver_at_once
    draws = Random(seed)
    return lambda sender, receiver, step: [] if draws.random() < loss else [ticks]


class LocalNetwork:
    """The network of agents in one process, for simulations and tests.

    Parameters
    ----------
    fate
        A function that returns after how many steps each copy of a message arrives. `step` advances the time.
    """

    def __init__(self, fate: Fate = deliver_at_once) -> None:
        self.fate = fate
        self.step_number = 0
        self._nodes: dict[str, LocalNode] = {}
        self._listeners: dict[str, list[LocalNode]] = {}
        """The nodes that listen to each key, since one joined, left or began to listen."""
        self._under_way: list[tuple[Envelope, str]] = []

    def join(self, name: str) -> LocalNode:
        """Return the access of an agent of this name; a former one of the same name is replaced."""
        self._nodes[name] = node = LocalNode(self, name)
        self._listeners.clear()
        return node

    def leave(self, name: str) -> None:
        """Remove an agent."""
        self._nodes.pop(name, None)
        self._listeners.clear()

    def forget_listeners(self) -> None:
        """Forget the listeners of each key; they are looked up again at the next message."""
        self._listeners.clear()

    def find_listeners(self, key: str) -> Sequence[LocalNode]:
        """Find the agents that listen to a key."""
        if key not in self._listeners:
            self._listeners[key] = [node for node in self._nodes.values() if key in node.inboxes]
        return self._listeners[key]

    @property
    def names(self) -> frozenset[str]:
        """The names of the agents that are there."""
        return frozenset(name for name, node in self._nodes.items() if node.is_announced)

    def send(self, sender: str, key: str, content: bytes) -> None:
        """Send a message to all agents that listen to its key."""
        at_once = self.fate is deliver_at_once
        for node in self.find_listeners(key):
            if at_once or node.name == sender:
                node.deliver(key, content)
                continue
            for steps in self.fate(sender, node.name, self.step_number):
                if steps == 0:
                    node.deliver(key, content)
                else:
                    envelope = Envelope(self.step_number + steps, sender, key, content)
                    self._under_way.append((envelope, node.name))

    def step(self) -> None:
        """Advance by one step: deliver what arrives in it."""
        self.step_number += 1
        left = []
        for envelope, name in self._under_way:
            node = self._nodes.get(name)
            if envelope.due > self.step_number:
                left.append((envelope, name))
            elif node is not None:
                node.deliver(envelope.key, envelope.content)
        self._under_way = left


class LocalNode:
    """One agent's access to a `LocalNetwork`."""

    def __init__(self, network: LocalNetwork, name: str) -> None:
        self._network, self.name = network, name
        self.inboxes: dict[str, list[Inbox]] = {}
        self.is_announced = False

    def publish(self, key: str, message: bytes) -> None:
        """Send a message to all listeners of a key."""
        self._network.send(self.name, key, message)

    def listen(self, key: str, observe: Observe | None = None) -> Inbox:
        """Receive the messages of a key from now on."""
        inbox = Inbox(observe=observe)
        self.inboxes.setdefault(key, []).append(inbox)
        self._network.forget_listeners()
        return inbox

    def deliver(self, key: str, message: bytes) -> None:
        """Put a message into all inboxes of its key."""
        for inbox in self.inboxes.get(key, ()):
            inbox.add(message)

    def announce(self, name: str) -> None:
        """Let others see that this agent is there."""
        self.is_announced = True

    @property
    def present(self) -> frozenset[str]:
        """The names of the agents that are there."""
        return self._network.names

    def close(self) -> None:
        """Leave the network."""
        self._network.leave(self.name)
