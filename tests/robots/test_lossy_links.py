"""Links that lose and delay packets do so as stated: in numbers, and between network namespaces."""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from itertools import pairwise
from math import inf

import pytest
from tests.processes import end_with_tests
from tests.waiting import wait_until

from understudy_lab.lossy_networks.links import Loss, LossyLinks, PacketQueue, find_obstacle

OBSTACLE = find_obstacle()
needs_namespaces = pytest.mark.skipif(bool(OBSTACLE), reason=OBSTACLE or "namespaces can be made")
SENT = 1000


def make_packet(*address: int) -> bytes:
    """The header of a packet of IPv4 to an address."""
    return bytes((0x45, *bytes(15), *address))


def test_packets_are_lost_and_delayed_as_stated() -> None:
    packets = PacketQueue(2, Loss(0.2, 0.1, 0.03), seed=1)
    for number in range(SENT):
        packets.send(0, make_packet(10, 83, 0, 2) + number.to_bytes(2, "big"), 5.0)
    assert packets.sent == SENT
    assert 0.15 < packets.lost / SENT < 0.25
    assert packets.take_due(5.0 + 0.0699) == []
    arrived, early = list[bytes](), 0
    for ms in range(70, 131):
        due = packets.take_due(5.0 + ms / 1000)
        early += len(due) if ms <= 85 else 0
        arrived += [packet for sender, receiver, packet in due if (sender, receiver) == (0, 1)]
        assert packets.due_s > 5.0 + ms / 1000
    assert len(arrived) == SENT - packets.lost
    assert packets.take_due(9.0) == []
    assert 0.2 < early / len(arrived) < 0.3  # a quarter of the times, all of which are as likely
    numbers = [int.from_bytes(packet[20:], "big") for packet in arrived]
    assert any(one > other for one, other in pairwise(numbers))


RECEIVERS = [  # a packet of the first of three members, who gets it
    (make_packet(10, 83, 0, 2), [1]),
    (make_packet(10, 83, 0, 3), [2]),
    (make_packet(224, 0, 0, 224), [1, 2]),
    (make_packet(10, 83, 0, 4), []),
    (make_packet(10, 83, 1, 2), []),
    (b"\x60" + bytes(39), []),  # of IPv6
]


@pytest.mark.parametrize(("packet", "receivers"), RECEIVERS)
def test_packets_go_to_whom_they_are_addressed(packet: bytes, receivers: list[int]) -> None:
    packets = PacketQueue(3, Loss())
    packets.send(0, packet, 0.0)
    assert packets.sent == len(receivers)
    assert [receiver for _, receiver, _ in packets.take_due(0.0)] == receivers


RECEIVE = """
import socket, sys
inbox = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
inbox.bind((sys.argv[1], 9000))
print("ready", flush=True)
while (text := inbox.recv(100)) != b"end":
    print(text.decode(), flush=True)
"""
SEND = """
import socket, sys, time
outbox = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
for _ in range(int(sys.argv[2])):
    outbox.sendto(sys.argv[3].encode(), (sys.argv[1], 9000))
    time.sleep(0.001)
"""


def send(links: LossyLinks, count: int, text: str) -> None:
    """Send datagrams from one to two, and wait until all have arrived that are not lost."""
    before = links.packets.sent
    sender = [*links.command("one"), sys.executable, "-c", SEND, links.address("two"), str(count), text]
    subprocess.run(end_with_tests(sender), check=True)
    wait_until(lambda: links.packets.sent >= before + count and links.packets.due_s == inf)


@needs_namespaces
@pytest.mark.timed
def test_packets_pass_links_unless_they_are_lost_or_cut() -> None:
    with LossyLinks(["one", "two"], Loss(0.2, 0.01, 0.005), seed=1) as links:
        command = [*links.command("two"), sys.executable, "-c", RECEIVE, links.address("two")]
        with subprocess.Popen(end_with_tests(command), stdout=subprocess.PIPE, text=True) as receiving:
            assert receiving.stdout is not None
            receiving.stdout.readline()
            send(links, 100, "before")
            lost = links.packets.lost
            links.cut("one")
            send(links, 50, "cut")
            links.heal("one")
            healed = links.packets.lost
            send(links, 100, "after")
            passed = {"before": 100 - lost, "after": 100 - (links.packets.lost - healed)}
            while receiving.poll() is None:
                send(links, 1, "end")
            assert Counter(receiving.stdout.read().split()) == passed
    assert 10 < lost < 30


SPEAK = """
import sys, time
from itertools import count
from understudy.addons.robots.team_network.zenoh_network import ZenohNetwork, ZenohOptions
own, other = sys.argv[1:]
listen, connect = ([f"udp/{address}:7447"] for address in (own, other))
network = ZenohNetwork("test", ZenohOptions(connect=connect, listen=listen, multicast=False))
inbox = network.listen("count")
heard, said = [], False
for number in count():
    network.publish("count", f"{own} {number}".encode())
    heard += [int(each.split()[1]) for each in inbox.take_all() if each.decode().split()[0] == other]
    if not said and len(heard) > 1 and heard[-1] - heard[0] > 200:
        print(len(heard) / (heard[-1] - heard[0] + 1), flush=True)
        said = True
    time.sleep(0.02)
"""
"""A program that goes on until it is killed, and says which share of the other one's messages it has heard."""


@needs_namespaces
@pytest.mark.timed
def test_messages_of_agents_are_not_sent_again_when_they_are_lost() -> None:
    """Over TCP all of them would come, the later ones held up by those that were lost."""
    pytest.importorskip("zenoh", reason="needs the extra ros2")
    with LossyLinks(["one", "two"], Loss(0.2, 0.02, 0.01), seed=2) as links:
        speaking = [
            subprocess.Popen(
                end_with_tests(
                    [
                        *links.command(own), sys.executable, "-c", SPEAK,
                        links.address(own), links.address(other),
                    ]
                ),
                stdout=subprocess.PIPE,
                text=True,
            )
            for own, other in (("one", "two"), ("two", "one"))
        ]  # fmt: skip
        try:
            shares = [float(each.stdout.readline()) for each in speaking if each.stdout is not None]
        finally:
            for each in speaking:
                each.kill()
                each.communicate()
    # A machine that holds up the links for a while loses more; no packet is sent again.
    assert all(0.2 < share < 0.95 for share in shares), shares
