"""Check of a transport, with several ends on this machine."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from queue import Empty, SimpleQueue
from threading import get_ident
from typing import TypeAlias

from understudy.addons.robots.robot_file import RobotFile
from understudy.addons.robots.ros.transport import Publisher, Transport, WireType
from understudy.testing.laws import LawBroken, require, require_call

TOPIC, TYPE = "/understudy_check/speed", "geometry_msgs/msg/Twist"
MESSAGE = b"\x00\x01\x00\x00" + bytes(range(48))
"""A Twist as CDR with encapsulation header: six numbers of 64 bits."""
SERVICE, SERVICE_TYPE = "/understudy_check/missing", WireType("std_srvs/srv/Trigger", f"RIHS01_{'0' * 64}")
PERIOD_S = 0.05
"""The time between two messages, which are sent until one has arrived, s."""

Arrivals: TypeAlias = SimpleQueue[tuple[bytes, float, int]]
"""Messages with their arrival times, s, and the threads in which they came."""


def check_transport(
    connect: Callable[[RobotFile], Transport], file: RobotFile, *, timeout_s: float = 10.0
) -> None:
    """Check that the ends of a transport reach each other, and what happens after one has closed.

    Messages must arrive as they were sent, in another thread, with the time of `time.monotonic`. A request to a service
    that is not there must be answered once by None. After it is closed, an end must receive nothing, and closing it
    again must do nothing.

    Parameters
    ----------
    connect
        Function that opens the transport of a robot.
    file
        File of a robot, which need not be there. Choose a domain that is used by nothing else.
    timeout_s
        Longest time to wait for a message, s.

    Raises
    ------
    LawBroken
        If the transport breaks a rule.
    """
    part = f"transport {getattr(connect, '__name__', connect)!r}"
    with ExitStack() as opened:
        sender, closing, staying = (_open(part, connect, file, opened) for _ in range(3))
        begun_s = time.monotonic()
        closing_arrivals, staying_arrivals = (_subscribe(part, end) for end in (closing, staying))
        send = require_call(part, "topics can be published on", lambda: sender.publisher(TOPIC, TYPE))
        for arrivals in (closing_arrivals, staying_arrivals):
            data, at_s, thread = _send_until(part, send, arrivals, timeout_s=timeout_s)
            require(data == MESSAGE, part, "a message arrives as it was sent", f"{data!r:.60} arrived")
            law = "arrival times are those of time.monotonic"
            require(begun_s <= at_s <= time.monotonic(), part, law, f"one is {at_s}")
            law = "messages arrive in another thread than that of the sender"
            require(thread != get_ident(), part, law, "one came in the same")
        _check_service(part, sender, timeout_s=timeout_s)
        for peer in require_call(part, "it lists its peers", sender.peers):
            require(isinstance(peer, Publisher), part, "peers are Publishers", f"one is {peer!r:.60}")
        require_call(part, "it can be closed", closing.close)
        require_call(part, "closing it again does nothing", closing.close)
        for arrivals in (closing_arrivals, staying_arrivals):
            _drain(arrivals)
        _send_until(part, send, staying_arrivals, timeout_s=timeout_s)
        require(closing_arrivals.empty(), part, "nothing is received after closing", "a message came")


def _open(
    part: str, connect: Callable[[RobotFile], Transport], file: RobotFile, opened: ExitStack
) -> Transport:
    transport = require_call(part, "it can be opened several times on a machine", lambda: connect(file))
    law = "it has the methods of a Transport"
    require(isinstance(transport, Transport), part, law, f"{type(transport).__name__} has not all of them")
    opened.callback(transport.close)
    return transport


def _subscribe(part: str, transport: Transport) -> Arrivals:
    arrivals: Arrivals = SimpleQueue()

    def receive(data: bytes, at_s: float) -> None:
        arrivals.put((data, at_s, get_ident()))

    require_call(part, "topics can be received", lambda: transport.subscribe(TOPIC, TYPE, receive))
    return arrivals


def _send_until(
    part: str, send: Callable[[bytes], None], arrivals: Arrivals, *, timeout_s: float
) -> tuple[bytes, float, int]:
    """Send messages until one arrives: ends may take a while to find each other."""
    end_s = time.monotonic() + timeout_s
    while time.monotonic() < end_s:
        require_call(part, "messages can be sent", lambda: send(MESSAGE))
        try:
            return arrivals.get(timeout=PERIOD_S)
        except Empty:
            continue
    law = "a message of one end reaches the others"
    raise LawBroken(part=part, law=law, found=f"none came in {timeout_s:g} s")


def _drain(arrivals: Arrivals) -> None:
    while not arrivals.empty():
        arrivals.get()


def _check_service(part: str, transport: Transport, *, timeout_s: float) -> None:
    law = "it says why a service is not reached"
    problem = require_call(part, law, lambda: transport.find_service_problem(SERVICE, SERVICE_TYPE))
    require(isinstance(problem, str), part, law, f"it said {problem!r:.60}")
    answers: SimpleQueue[bytes | None] = SimpleQueue()
    call = partial(transport.call, SERVICE, SERVICE_TYPE, MESSAGE, answers.put, timeout_s=timeout_s / 2)
    require_call(part, "requests can be sent", call)
    law = "a request to a service that is not there is answered once by None"
    try:
        answer = answers.get(timeout=timeout_s)
    except Empty:
        raise LawBroken(part=part, law=law, found="there was no answer") from None
    require(answer is None and answers.empty(), part, law, f"the answer was {answer!r:.60}")
