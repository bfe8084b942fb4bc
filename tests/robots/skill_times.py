"""How long skills take on the way: from a tick to the answer of a service, and to the cancellation of a goal.

    python -m tests.robots.skill_times

prints both, over Zenoh and on Cyclone DDS, in milliseconds, with servers in the same process.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np
from tests.robots.dds_skill_servers import DdsServer
from tests.robots.routers import Router
from tests.robots.skill_servers import Server
from tests.robots.test_dds_skills import TEXT, DdsRig
from tests.robots.test_zenoh_skills import SkilledRig
from tests.waiting import wait_until

CALLS, CANCELS = 200, 50


def main() -> None:
    with Router() as router, Server(router.endpoint) as server:
        report("Zenoh", SkilledRig(router.endpoint), server)
    with DdsServer("") as server:
        report("Cyclone DDS", DdsRig("", TEXT), server)


def report(over: str, rig: SkilledRig, server: Server) -> None:
    rig.ready()
    calls = [time_call(rig) for _ in range(CALLS)]
    server.conduct = "run"
    cancels = [time_cancel(rig, server) for _ in range(CANCELS)]
    for what, times in (("answer of a service", calls), ("cancellation", cancels)):
        found = np.percentile(np.array(times) * 1e3, [50, 99, 100])
        sys.stdout.write(
            f"{over}, {what}, {len(times)} times: median {found[0]:.1f}, 99 % {found[1]:.1f}, most {found[2]:.1f} ms\n"
        )
    rig.close()


def time_call(rig: SkilledRig) -> float:
    began_s = time.monotonic()
    rig.tick("beep", anew=True)
    last = rig.robot.skills.skills["beep"].last
    spin(lambda: not last.runs)
    return time.monotonic() - began_s


def time_cancel(rig: SkilledRig, server: Server) -> float:
    """From the tick in which the state was left to the request at the server."""
    rig.tick("go_to", anew=True)
    last, before = rig.robot.skills.skills["go_to"].last, len(server.cancelled_s)
    wait_until(lambda: last.feedback)
    began_s = time.monotonic()
    rig.tick(anew=True)
    spin(lambda: len(server.cancelled_s) > before)
    return server.cancelled_s[before] - began_s


def spin(done: Callable[[], bool]) -> None:
    while not done():
        time.sleep(0.0001)


if __name__ == "__main__":
    main()
