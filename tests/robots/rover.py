"""A robot in a process of its own: publishes at 50 Hz, and ends with the first command that moves, which it prints."""

from __future__ import annotations

import sys
import time

from tests.robots.rovers import ODOMETRY, RANGE, TWIST, odometry, sonar

from understudy.addons.robots.ros.dds import DdsTransport
from understudy.addons.robots.ros.transport import Transport
from understudy.addons.robots.ros.zenoh import ZenohTransport
from understudy.records.messages import encode_twist

RATE_HZ = 50


def main(domain: str, namespace: str, router: str = "") -> None:
    """Over DDS, or where there is a router, over Zenoh."""
    wire: Transport = ZenohTransport(int(domain), router) if router else DdsTransport(int(domain))
    moving = list[bytes]()
    stop = encode_twist(TWIST, speed_m_s=0.0, turn_rad_s=0.0)
    wire.subscribe(f"{namespace}/cmd_vel", TWIST, lambda data, _: moving.extend([data][data == stop :]))
    ranges, odometries = (
        wire.publisher(f"{namespace}/sonar", RANGE),
        wire.publisher(f"{namespace}/odom", ODOMETRY),
    )
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    until = time.monotonic() + 300
    while not moving and time.monotonic() < until:
        ranges(sonar(2.0))
        odometries(odometry(1.0))
        time.sleep(1 / RATE_HZ)
    sys.stdout.write("".join(data.hex() for data in moving[:1]))
    sys.stdout.flush()
    wire.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
