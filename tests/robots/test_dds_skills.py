"""Skills of a robot over DDS: servers on Cyclone DDS are called, servers on another one never."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("zenoh", reason="needs the extra ros2")

from tests.robots import test_zenoh_skills as over_zenoh
from tests.robots.dds_skill_servers import DOMAIN, DdsServer, OtherServer
from tests.robots.skill_rigs import Conduct, write_skill_robot
from tests.waiting import wait_until

from understudy.addons.robots.ros.dds import DdsTransport
from understudy.addons.robots.ros.transport import Transport

TEXT = write_skill_robot().replace('transport = "zenoh"\n', "").replace("domain = 43", f"domain = {DOMAIN}")
ARRIVES_S = 0.3
"""After this time, s, what was sent has arrived."""


class DdsRig(over_zenoh.SkilledRig):
    """A rover over DDS."""

    def open(self, endpoint: str) -> Transport:
        return DdsTransport(DOMAIN, clock=self.clock)


@contextmanager
def open_rig(
    conduct: Conduct, server: type[DdsServer] = DdsServer, *, timeout_s: float = 30.0
) -> Iterator[tuple[DdsRig, DdsServer]]:
    with server("", conduct) as serving:
        rig = DdsRig("", TEXT.replace("timeout_s = 30", f"timeout_s = {timeout_s:g}"))
        try:
            rig.ready(skills=server is DdsServer)
            yield rig, serving
        finally:
            rig.close()


TRIALS: list[tuple[Callable[[DdsRig, DdsServer], None], Conduct, float]] = [
    (over_zenoh.ends, "succeed", 30.0),
    (over_zenoh.ends, "abort", 30.0),
    (over_zenoh.ends, "reject", 30.0),
    (over_zenoh.leaves, "run", 30.0),
    (over_zenoh.is_disarmed, "run", 30.0),
    (over_zenoh.is_never_answered, "silent", 0.05),
]


@pytest.mark.timed
@pytest.mark.parametrize(("tries", "conduct", "timeout_s"), TRIALS)
def test_goals_and_services_over_dds(
    tries: Callable[[DdsRig, DdsServer], None], conduct: Conduct, timeout_s: float
) -> None:
    with open_rig(conduct, timeout_s=timeout_s) as (rig, server):
        tries(rig, server)


@pytest.mark.timed
def test_a_server_that_left_aborts_its_goal_which_is_cancelled_when_it_is_there_again() -> None:
    with open_rig("silent") as (rig, server):
        rig.tick("go_to", anew=True)
        server.close()
        rig.run_until(rig.outcomes)
        assert rig.outcomes() == ["aborted"]
        with DdsServer("", "run") as again:
            rig.run_until(lambda: again.cancelled)


@pytest.mark.timed
def test_a_server_on_another_dds_is_sent_nothing() -> None:
    with open_rig("succeed", OtherServer) as (rig, server):
        wait_until(lambda: "another DDS" in rig.robot.skills.find_problems().get("go_to", ""))
        assert 'give transport = "zenoh"' in rig.robot.skills.find_problems()["beep"]
        rig.tick("go_to", anew=True)
        assert rig.outcomes() == ["rejected"]
        rig.robot.emergency_stop("Ada said so")
        time.sleep(ARRIVES_S)
        assert server.taken == 0
