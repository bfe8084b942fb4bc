"""Links that lose and delay packets do so as stated."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from understudy_lab.lossy_networks.links import Loss, LossyLinks, find_obstacle

if OBSTACLE := find_obstacle():
    pytest.skip(OBSTACLE, allow_module_level=True)

RECEIVE = """
import json, socket, sys, time
inbox = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
inbox.bind((sys.argv[1], 9000))
inbox.settimeout(float(sys.argv[2]))
print("ready", flush=True)
delays = []
try:
    while True:
        sent = float(inbox.recv(100))
        delays.append(time.monotonic() - sent)
except TimeoutError:
    print(json.dumps(delays))
"""
SEND = """
import socket, sys, time
outbox = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
for _ in range(int(sys.argv[2])):
    outbox.sendto(str(time.monotonic()).encode(), (sys.argv[1], 9000))
    time.sleep(0.001)
"""
PATIENCE_S = 1.0


def measure_delays(links: LossyLinks, count: int) -> list[float]:
    """Send datagrams from one to two; return the delay of each that arrived."""
    receive = [*links.command("two"), sys.executable, "-c", RECEIVE, links.address("two"), str(PATIENCE_S)]
    with subprocess.Popen(receive, stdout=subprocess.PIPE, text=True) as receiving:
        assert receiving.stdout is not None
        receiving.stdout.readline()
        send = [*links.command("one"), sys.executable, "-c", SEND, links.address("two"), str(count)]
        subprocess.run(send, check=True)
        delays: list[float] = json.loads(receiving.stdout.read())
    return delays


def test_packets_are_lost_and_delayed_as_stated() -> None:
    with LossyLinks(["one", "two"], Loss(0.2, 0.1, 0.03), seed=1) as links:
        delays = measure_delays(links, 1000)
        assert len(delays) == links.sent - links.lost
        assert 0.15 < 1 - len(delays) / 1000 < 0.25
        assert min(delays) >= 0.07
        assert sorted(delays)[len(delays) // 4] < 0.1 < sorted(delays)[3 * len(delays) // 4]


SPEAK = """
import sys, time
from understudy.robots.team_network.zenoh_network import ZenohNetwork, ZenohOptions
own, other = sys.argv[1:]
listen, connect = ([f"udp/{address}:7447"] for address in (own, other))
network = ZenohNetwork("test", ZenohOptions(connect=connect, listen=listen, multicast=False))
inbox = network.listen("count")
until, heard = time.monotonic() + 60.0, []
for number in range(10**6):
    if len(heard) > 1 and heard[-1] - heard[0] > 200 or time.monotonic() > until:
        break
    network.publish("count", f"{own} {number}".encode())
    heard += [int(each.split()[1]) for each in inbox.take_all() if each.decode().split()[0] == other]
    time.sleep(0.02)
print(len(heard) / (heard[-1] - heard[0] + 1) if heard else 0.0, flush=True)
time.sleep(3.0)
network.close()
"""


def test_messages_of_agents_are_not_sent_again_when_they_are_lost() -> None:
    """Over TCP all of them would come, the later ones held up by those that were lost."""
    pytest.importorskip("zenoh", reason="needs the extra ros2")
    with LossyLinks(["one", "two"], Loss(0.2, 0.02, 0.01), seed=2) as links:
        speaking = [
            subprocess.Popen(
                [*links.command(own), sys.executable, "-c", SPEAK, links.address(own), links.address(other)],
                stdout=subprocess.PIPE,
                text=True,
            )
            for own, other in (("one", "two"), ("two", "one"))
        ]
        shares = [float(each.communicate(timeout=120.0)[0]) for each in speaking]
    assert all(0.6 < share < 0.95 for share in shares), shares


def test_no_packet_passes_a_link_that_is_cut() -> None:
    with LossyLinks(["one", "two"]) as links:
        assert len(measure_delays(links, 20)) == 20
        links.cut("one")
        assert measure_delays(links, 20) == []
        links.heal("one")
        assert len(measure_delays(links, 20)) == 20
