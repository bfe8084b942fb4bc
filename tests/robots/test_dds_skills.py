"""Skills of a robot over DDS: servers on Cyclone DDS are called, servers on another one never."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import isnan

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.dds_skill_servers import DdsServer, OtherServer, wait_a_little
from tests.robots.skill_servers import Conduct
from tests.robots.test_skills import SkilledRig, skilled, wait_for

from understudy.robots.ros.dds import DdsTransport
from understudy.robots.ros.transport import Transport

TEXT = skilled().replace('transport = "zenoh"\n', "")


class DdsRig(SkilledRig):
    """A rover over DDS."""

    def open(self, endpoint: str) -> Transport:
        return DdsTransport(43)


@contextmanager
def rigged(
    conduct: Conduct, server: type[DdsServer] = DdsServer, *, text: str = TEXT
) -> Iterator[tuple[DdsRig, DdsServer]]:
    with server("", conduct) as serving:
        rig = DdsRig("", text)
        try:
            rig.ready(skills=server is DdsServer)
            yield rig, serving
        finally:
            rig.robot.close()
            rig.driver.close()


@pytest.mark.parametrize(
    ("conduct", "outcome"), [("succeed", "succeeded"), ("abort", "aborted"), ("reject", "rejected")]
)
def test_a_goal_ends_as_its_server_says(conduct: Conduct, outcome: str) -> None:
    with rigged(conduct) as (rig, server):
        rig.tick("go_to", anew=True)
        rig.run_until(rig.outcomes)
        assert (rig.outcomes(), len(server.goals)) == ([outcome], 1)
        assert server.goals[0].goal.pose.pose.position.x == 1.5
        if conduct != "reject":
            assert rig.read("go_to_distance_remaining") == 1.0
            rig.tick("beep", anew=True)
            rig.run_until(lambda: rig.outcomes("beep"), "beep")
            assert (rig.outcomes("beep"), server.requests) == ([outcome], 1)


LEAVES: list[Callable[[DdsRig], object]] = [
    lambda rig: rig.tick(anew=True),
    lambda rig: rig.robot.disarm("Ada said so"),
]


@pytest.mark.parametrize("leave", LEAVES)
def test_leaving_and_disarming_cancel_the_goal(leave: Callable[[DdsRig], object]) -> None:
    with rigged("run") as (rig, server):
        rig.tick("go_to", anew=True)
        rig.run_until(lambda: not isnan(rig.read("go_to_distance_remaining")))
        leave(rig)
        wait_for(lambda: server.cancelled_s)


def test_a_silent_server_times_out_and_one_that_left_aborts() -> None:
    with rigged("silent", text=TEXT.replace("timeout_s = 30", "timeout_s = 0.3")) as (rig, _):
        rig.tick("go_to", anew=True)
        rig.run_until(rig.outcomes)
        assert rig.outcomes() == ["timed_out"]
    with rigged("silent") as (rig, server):
        rig.tick("go_to", anew=True)
        server.close()
        rig.run_until(rig.outcomes)
        assert rig.outcomes() == ["aborted"]


def test_a_goal_is_cancelled_when_its_server_is_there_again() -> None:
    with rigged("silent") as (rig, server):
        rig.tick("go_to", anew=True)
        server.close()
        rig.run_until(rig.outcomes)
        with DdsServer("", "run") as again:
            rig.run_until(lambda: again.cancelled_s)


def test_a_server_on_another_dds_is_sent_nothing() -> None:
    with rigged("succeed", OtherServer) as (rig, server):
        wait_for(lambda: "another DDS" in rig.robot.skills.find_problems().get("go_to", ""))
        assert 'give transport = "zenoh"' in rig.robot.skills.find_problems()["beep"]
        rig.tick("go_to", anew=True)
        assert rig.outcomes() == ["rejected"]
        rig.robot.emergency_stop("Ada said so")
        wait_a_little()
        assert server.taken == 0
