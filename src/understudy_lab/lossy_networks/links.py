"""Links between network namespaces that lose and delay packets at random, and can be cut.

Each member of a network gets a network namespace with a TUN device of its own. This program reads the IP packets that
members send, drops some, and hands the others over to the member of their destination after a while, as `tc netem`
would. It needs root.
"""

from __future__ import annotations

import heapq
import os
import selectors
import shutil
import struct
import subprocess
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from math import inf
from pathlib import Path
from random import Random
from threading import Lock, Thread
from time import monotonic

TUN = "/dev/net/tun"
SET_NAME, TUN_DEVICE, NO_HEADER = 0x400454CA, 0x0001, 0x1000
"""From linux/if_tun.h: TUNSETIFF, IFF_TUN and IFF_NO_PI."""
DEVICE = "link"
LONGEST_PACKET = 65536
IPV4, MULTICAST = 4, range(224, 240)
NETWORK = bytes((10, 83, 0))
"""How the addresses of all members begin."""
IDLE_S = 0.2
"""The longest time to wait for a packet before looking whether to end, s."""


@dataclass(frozen=True, slots=True)
class Loss:
    """What happens to packets: the share that is lost, and the delay of the others, s, plus or minus the jitter, s."""

    share: float = 0.0
    delay_s: float = 0.0
    jitter_s: float = 0.0


NONE = Loss()


def find_obstacle() -> str:
    """Return why such links cannot be made here; empty if they can."""
    if os.geteuid() != 0:
        return "network namespaces need root"
    if shutil.which("ip") is None or not Path(TUN).exists():
        return f"needs the command ip, and {TUN}"
    probe = f"us-probe-{os.getpid()}"
    process = subprocess.run(["ip", "netns", "add", probe], capture_output=True, text=True, check=False)
    subprocess.run(["ip", "netns", "delete", probe], capture_output=True, check=False)
    return f"network namespaces cannot be made: {process.stderr.strip()}" if process.returncode else ""


class PacketQueue:
    """Packets under way between members of a network, each lost or delayed by a random draw.

    Parameters
    ----------
    members
        The number of members, whose addresses end with their numbers, from 1 on.
    loss
        What happens to packets.
    seed
        The seed of the random draws.
    """

    def __init__(self, members: int, loss: Loss, *, seed: int = 0) -> None:
        self._members, self.loss = members, loss
        self.sent = self.lost = 0
        """The number of packets that members sent, and of those that were lost at random."""
        self._random = Random(seed)
        self._numbers = count()
        self._under_way: list[tuple[float, int, int, int, bytes]] = []

    @property
    def due_s(self) -> float:
        """When the next packet arrives, s; infinite if none is under way."""
        return self._under_way[0][0] if self._under_way else inf

    def send(self, sender: int, packet: bytes, now: float) -> None:
        """Draw what happens to a packet that a member has sent at a time (s), to each of its receivers."""
        for receiver in self._find_receivers(sender, packet):
            self.sent += 1
            if self._random.random() < self.loss.share:
                self.lost += 1
                continue
            jitter_s = self._random.uniform(-self.loss.jitter_s, self.loss.jitter_s)
            due = now + max(0.0, self.loss.delay_s + jitter_s)
            heapq.heappush(self._under_way, (due, next(self._numbers), sender, receiver, packet))

    def take_due(self, now: float) -> list[tuple[int, int, bytes]]:
        """Take the packets that have arrived until a time (s): the sender, the receiver and the packet of each."""
        taken = []
        while self.due_s <= now:
            taken.append(heapq.heappop(self._under_way)[2:])
        return taken

    def _find_receivers(self, sender: int, packet: bytes) -> list[int]:
        if packet[0] >> 4 != IPV4:
            return []
        if packet[16] in MULTICAST:
            return [index for index in range(self._members) if index != sender]
        receiver = packet[19] - 1
        is_member = packet[16:19] == NETWORK and 0 <= receiver < self._members
        return [receiver] if is_member else []


class LossyLinks:
    """A network of namespaces; every packet between two of them is lost or delayed alike.

    Parameters
    ----------
    members
        The names of the members.
    loss
        What happens to packets.
    seed
        The seed of the random draws.
    """

    def __init__(self, members: Sequence[str], loss: Loss = NONE, *, seed: int = 0) -> None:
        self.members = tuple(members)
        self.packets = PacketQueue(len(self.members), loss, seed=seed)
        """The packets under way."""
        self._cut: set[int] = set()
        self._lock, self._ends = Lock(), False
        self._devices: list[int] = []
        try:
            for index in range(len(self.members)):
                self._make(index)
        except BaseException:
            self._remove()
            raise
        self._thread = Thread(target=self._forward, name="links", daemon=True)
        self._thread.start()

    def namespace(self, member: str) -> str:
        """Return the name of a member's namespace."""
        return f"us-{os.getpid()}-{self.members.index(member)}"

    def address(self, member: str) -> str:
        """Return the IP address of a member."""
        return ".".join(map(str, (*NETWORK, self.members.index(member) + 1)))

    def command(self, member: str) -> list[str]:
        """Return how a command begins that runs in a member's namespace."""
        return ["ip", "netns", "exec", self.namespace(member)]

    def cut(self, member: str) -> None:
        """Lose all packets from and to a member from now on, also those that are under way.

        Those that have arrived are handed over before.
        """
        with self._lock:
            self._cut.add(self.members.index(member))

    def heal(self, member: str) -> None:
        """Let packets from and to a member pass again."""
        with self._lock:
            self._cut.discard(self.members.index(member))

    def close(self) -> None:
        """End forwarding, and remove the namespaces."""
        self._ends = True
        self._thread.join()
        self._remove()

    def __enter__(self) -> LossyLinks:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _make(self, index: int) -> None:
        import fcntl  # which Windows does not have

        namespace, device = self.namespace(self.members[index]), f"us{os.getpid() % 10**6}x{index}"
        _run("ip", "netns", "add", namespace)
        _run("ip", "-n", namespace, "link", "set", "lo", "up")
        opened = os.open(TUN, os.O_RDWR | os.O_NONBLOCK)
        self._devices.append(opened)
        fcntl.ioctl(opened, SET_NAME, struct.pack("16sH", device.encode(), TUN_DEVICE | NO_HEADER))
        _run("ip", "link", "set", "dev", device, "netns", namespace, "name", DEVICE)
        _run(
            "ip", "-n", namespace, "address", "add", f"{self.address(self.members[index])}/24", "dev", DEVICE
        )
        _run("ip", "-n", namespace, "link", "set", "dev", DEVICE, "multicast", "on", "up")

    def _remove(self) -> None:
        for device in self._devices:
            os.close(device)
        for member in self.members:
            subprocess.run(
                ["ip", "netns", "delete", self.namespace(member)], capture_output=True, check=False
            )

    def _forward(self) -> None:
        with selectors.DefaultSelector() as selector:
            for index, device in enumerate(self._devices):
                selector.register(device, selectors.EVENT_READ, index)
            while not self._ends:
                wait_s = min(IDLE_S, self.packets.due_s - monotonic())
                for key, _ in selector.select(max(0.0, wait_s)):
                    self._take(key.data)
                self._deliver()

    def _take(self, sender: int) -> None:
        """Read the packets that a member has sent, and draw what happens to each."""
        now = monotonic()
        while True:
            try:
                packet = os.read(self._devices[sender], LONGEST_PACKET)
            except BlockingIOError:
                return
            self.packets.send(sender, packet, now)

    def _deliver(self) -> None:
        with self._lock:
            for sender, receiver, packet in self.packets.take_due(monotonic()):
                if sender not in self._cut and receiver not in self._cut:
                    with suppress(OSError):  # the receiver is overloaded
                        os.write(self._devices[receiver], packet)


def _run(*command: str) -> None:
    subprocess.run(command, check=True, capture_output=True)
