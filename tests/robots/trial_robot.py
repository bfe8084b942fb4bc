"""A robot for trials of stopping, in a process of its own: ranges or odometry out, Twist in, a deadline of its own.

It prints when it was set in motion and when it stopped, by the clock that all processes of a machine have in common,
and why: `moves 12.345 command`, `stops 12.567 deadline`.
"""

from __future__ import annotations

import contextlib
import math
import os
import sys
import time
from argparse import ArgumentParser

from tests.robots.rovers import ODOMETRY, RANGE, TWIST, odometry, sonar

from understudy.addons.robots.ros.dds import DdsTransport
from understudy.addons.robots.ros.transport import Transport
from understudy.addons.robots.ros.zenoh import ZenohTransport
from understudy.records.messages import decode_message

PERIOD_S = 0.02
SLICE_S = 0.005
PRIORITY = -10
"""A robot has a computer of its own; where it may, it takes precedence here."""


class Base:
    """What moves: at the speed it was told last, for as long as its deadline allows."""

    def __init__(self, deadline_s: float) -> None:
        self.x, self.speed, self.told_s = 0.0, 0.0, -math.inf
        self._deadline_s = deadline_s
        self._moving = False

    def take_command(self, data: bytes, at_s: float) -> None:
        self.speed, self.told_s = decode_message(TWIST, data).linear.x, at_s
        self._now("command", time.monotonic())

    def go_on(self, elapsed_s: float, now: float) -> None:
        self.x += self.speed * elapsed_s
        if now - self.told_s > self._deadline_s:
            self.speed = 0.0
            self._now("deadline", now)

    def _now(self, why: str, now: float) -> None:
        if self._moving != (self.speed != 0.0):
            self._moving = not self._moving
            sys.stdout.write(f"{'moves' if self._moving else 'stops'} {now:.6f} {why}\n")
            sys.stdout.flush()


def main() -> None:
    given = ArgumentParser()
    given.add_argument("domain", type=int)
    given.add_argument("namespace")
    given.add_argument("--deadline", type=float, default=math.inf)
    given.add_argument("--only", choices=("sonar", "base"), help="either sensor or base")
    given.add_argument("--listen", help="speak Zenoh, and listen at this endpoint")
    asked = given.parse_args()
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, 0, PRIORITY)
    wire: Transport = (
        DdsTransport(asked.domain)
        if asked.listen is None
        else ZenohTransport(asked.domain, listen=asked.listen)
    )
    base = Base(asked.deadline)
    if asked.only != "sonar":
        wire.subscribe(f"{asked.namespace}/cmd_vel", TWIST, base.take_command)
    ranges = wire.publisher(f"{asked.namespace}/sonar", RANGE) if asked.only != "base" else None
    places = wire.publisher(f"{asked.namespace}/odom", ODOMETRY) if asked.only != "sonar" else None
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    last = told = time.monotonic()
    while True:
        now = time.monotonic()
        base.go_on(now - last, now)
        last = now
        if now - told >= PERIOD_S:
            told = now
            if ranges is not None:
                ranges(sonar(2.0))
            if places is not None:
                places(odometry(base.x))
        time.sleep(SLICE_S)


if __name__ == "__main__":
    main()
