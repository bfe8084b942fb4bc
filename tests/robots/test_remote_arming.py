"""Robots elsewhere are armed and stopped, though answers get lost, come late, or never."""

from __future__ import annotations

from collections.abc import Callable
from threading import Thread

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.slow_agents import SlowAgents, finish, make_fleet, wait_for

from understudy.addons.robots.arming_order import ArmingOrder
from understudy.addons.robots.fleet import Fleet
from understudy.addons.robots.safety.guard import ArmingRefused
from understudy.errors import SettingError, UnderstudyError

SILENT = tuple(f"silent_{number}" for number in range(40))
STOPS: dict[str, Callable[[Fleet], None]] = {
    "a stop of all": lambda fleet: fleet.emergency_stop("a key"),
    "a stop of one": lambda fleet: fleet.robots[1].emergency_stop("a key"),
    "nobody looks": lambda fleet: fleet.disarm("nobody looks"),
    "the studio ends": lambda fleet: fleet.close(),
}


class Ordered(Thread):
    """Arm robots in another thread, and keep what went wrong."""

    def __init__(self, fleet: Fleet) -> None:
        super().__init__()
        self.order, self.problem = ArmingOrder(fleet.robots, "Ada"), ""
        self.start()

    def run(self) -> None:
        try:
            self.order.carry_out()
        except UnderstudyError as error:
            self.problem = str(error)


def test_where_the_answer_is_lost_the_robot_is_stopped() -> None:
    agents = SlowAgents()
    fleet = make_fleet(agents, ["one"])
    agents.lost.add(("one", "arm"))
    with pytest.raises(SettingError, match="did not answer"):
        fleet.robots[0].arm("Ada")
    assert wait_for(lambda: ("one", "stop") in agents.asked)
    assert not agents.armed["one"]


def test_a_robot_whose_agent_refuses_is_not_stopped() -> None:
    """Another person may be driving it."""
    agents = SlowAgents()
    agents.refusing.add("one")
    fleet = make_fleet(agents, ["one"])
    with pytest.raises(SettingError, match="was refused: is outside its geofence"):
        fleet.robots[0].arm("Ada")
    fleet.robots[0].disarm("the page was closed")
    finish(fleet)
    assert ("one", "stop") not in agents.asked


def test_where_one_answer_is_lost_all_are_stopped() -> None:
    agents = SlowAgents()
    fleet = make_fleet(agents, ["one", "two", "three"])
    agents.lost.add(("two", "arm"))
    with pytest.raises(SettingError, match=r"'two'.*did not answer"):
        fleet.arm("Ada")
    assert wait_for(lambda: {("one", "stop"), ("two", "stop")} <= {*agents.asked})
    assert not any(agents.armed.values())
    assert ("three", "arm") not in agents.asked


@pytest.mark.parametrize("stop", STOPS)
@pytest.mark.parametrize("held", ["ready", "arm"])
def test_a_stop_wins_over_an_order_that_is_under_way(held: str, stop: str) -> None:
    """Though the agent arms the robot only after it was stopped."""
    agents = SlowAgents()
    fleet = make_fleet(agents, ["one", "two"])
    answer = agents.hold("two", held)
    ordered = Ordered(fleet)
    assert wait_for(lambda: ("two", held) in agents.asked)
    stopping = Thread(target=STOPS[stop], args=(fleet,))  # to close the fleet takes as long as the order
    stopping.start()
    assert wait_for(lambda: fleet.robots[1].stop_count > 0)
    answer.set()
    ordered.join()
    stopping.join()
    assert "it was stopped meanwhile; arm again" in ordered.problem
    assert wait_for(lambda: not any(agents.armed.values()))
    with pytest.raises(ArmingRefused):
        ordered.order.refuse_overtaken()


def test_the_network_is_left_only_after_the_robot_of_a_cancelled_order_was_stopped() -> None:
    agents = SlowAgents()
    fleet = make_fleet(agents, ["one"])
    answer = agents.hold("one", "arm")
    ordered = Ordered(fleet)
    assert wait_for(lambda: ("one", "arm") in agents.asked)
    closing = Thread(target=fleet.close)
    closing.start()
    assert wait_for(lambda: ("one", "stop") in agents.asked)
    answer.set()
    closing.join()
    finish(fleet)
    assert agents.asked[-1] == ("one", "stop")
    assert not agents.armed["one"]
    ordered.join()


def test_an_order_overtaken_before_it_is_begun_asks_nobody_to_arm() -> None:
    agents = SlowAgents()
    fleet = make_fleet(agents, ["one"])
    order = ArmingOrder(fleet.robots, "Ada")
    fleet.emergency_stop("a key")
    with pytest.raises(ArmingRefused, match="it was stopped meanwhile"):
        order.carry_out()
    assert ("one", "arm") not in agents.asked


def test_armed_elsewhere_it_goes_on_where_nobody_looks() -> None:
    agents = SlowAgents()
    fleet = make_fleet(agents, ["one", "two"])
    ArmingOrder(fleet.robots[:1], "Ada").carry_out()
    fleet.disarm("nobody looks")
    finish(fleet)
    assert ("one", "stop") in agents.asked
    assert ("two", "stop") not in agents.asked


def test_a_stop_of_all_waits_for_no_silent_agent() -> None:
    agents = SlowAgents()
    fleet = make_fleet(agents, [*SILENT, "hears"])
    held = [agents.hold(name, "stop") for name in SILENT]
    fleet.emergency_stop("a key")
    assert wait_for(lambda: ("hears", "stop") in agents.asked)
    for each in held:
        each.set()


def test_a_stop_waits_for_no_earlier_one_of_the_same_robot() -> None:
    agents = SlowAgents()
    fleet = make_fleet(agents, ["one"])
    held = agents.hold("one", "stop")
    for _ in range(20):
        fleet.emergency_stop("a key")
    assert wait_for(lambda: agents.asked == [("one", "stop")] * 20)
    held.set()
