"""The process that `understudy bench robots` measures: a robot that decides as soon as a range arrives.

It has all parts of a real run: the guard, the watchdog, limits, and an interpreted automaton.
"""

from __future__ import annotations

import sys
from pathlib import Path
from threading import Event

from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import load_robot
from understudy.addons.robots.ros.open_transport import open_transport
from understudy.addons.robots.ros.transport import Received, Transport, TransportWrapper
from understudy.addons.robots.safety.stop_log import find_stop_log
from understudy.addons.robots.safety.watchdog_client import WatchdogClient
from understudy.model.behaviors import Behavior, Command
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Kit, Library
from understudy.model.value_kinds import Continuous
from understudy.runtime.link import Program, link
from understudy.runtime.run_loop import Run
from understudy_lab.tree_builder import build_automaton, split_below

NAME, AVOID_NEAR_M = "avoid", 1.0


class WakingTransport(TransportWrapper):
    """A transport that signals when a message has arrived."""

    def __init__(self, transport: Transport) -> None:
        super().__init__(transport)
        self.came = Event()

    def subscribe(self, topic: str, type: str, received: Received, *, kept: bool = False) -> None:
        """Subscribe as the wrapped transport does, and signal each message."""

        def woken(data: bytes, at_s: float) -> None:
            received(data, at_s)
            self.came.set()

        self._transport.subscribe(topic, type, woken, kept=kept)


def program() -> Program:
    """Return a program that drives ahead, and turns if something is near."""
    sonar = BoundFeature(Feature("sonar", Continuous(), "sonar_ahead"))
    decide = split_below("sonar", AVOID_NEAR_M, "left", "forward")
    basics = {"forward": Command(drive=1.0), "left": Command(turn=1.0)}
    made = build_automaton(
        NAME, dict.fromkeys(("start", *basics), decide), readings={"sonar": sonar}, basics=basics
    )
    kit = Kit.from_parts(sonar.feature, *(Behavior(name, command) for name, command in basics.items()))
    return link(Library.from_automata(kit, made), NAME)


def main(path: str) -> None:
    """Decide on each arriving range until none has arrived for a second."""
    file = load_robot(path)
    waking = WakingTransport(open_transport(file))
    with Robot(
        file, waking, path=path, watchdog=WatchdogClient(file, log=find_stop_log(file, Path(path)))
    ) as robot:
        while robot.senses.find_missing(robot.now_s) is not None:
            waking.came.wait()
        robot.arm("a measurement")
        run = Run.from_program(robot, program())
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        while waking.came.wait(1.0):  # no message for this time: it is over
            waking.came.clear()
            run.tick()


if __name__ == "__main__":
    main(*sys.argv[1:])
