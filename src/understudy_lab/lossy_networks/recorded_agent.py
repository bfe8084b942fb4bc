"""Run an agent of a team as `understudy agent` does, arm its robot, and record each of its ticks.

    python -m understudy_lab.lossy_networks.recorded_agent TEAM --name pioneer_1 --write pioneer_1.jsonl

Times are of the clock that all processes of a machine have in common; agents do not use it for their decisions.
"""

from __future__ import annotations

import json
import os
import signal
import time
from argparse import ArgumentParser
from contextlib import suppress
from pathlib import Path
from threading import Event, Thread
from typing import TextIO

import msgspec

from understudy.addons.robots.team_network.agent_process import AgentProcess
from understudy.addons.robots.team_network.agent_questions import AgentAnswer, AgentQuestion
from understudy.addons.robots.team_network.load_plan import LoadedTeam, load_team_plan
from understudy.addons.robots.team_network.zenoh_network import ZenohNetwork

PERSON = "a person who looks after it"
LOOKS_S = 1.0
"""The time after which the person looks again, s."""
PRIORITY = -10
"""An agent has a computer of its own; where it may, it takes precedence here."""


class RecordedAgent(AgentProcess):
    """An agent that writes a line of JSON for each tick."""

    def __init__(self, name: str, team: LoadedTeam, network: ZenohNetwork, file: TextIO) -> None:
        self._file = file
        super().__init__(name, team, network)

    def tick(self) -> None:
        """Tick, and record what was obeyed and sent."""
        began_s = time.monotonic()
        super().tick()
        line: dict[str, object] = {"began_s": began_s, "ended_s": time.monotonic(), "late": self.late}
        for each in self.coordinators:
            if each.leads:
                line["leads"] = each.leadership.term, each.sent
        if self.agent is not None and self.agent.follower is not None and self.robot is not None:
            follower = self.agent.follower
            line["armed"], line["path"] = self.robot.armed, self.agent.path
            if follower.order is not None:
                line["obeys"] = follower.term, follower.heard
                line["order"], line["duty"] = follower.order, follower.duty
                line["leader"] = follower.leader
        self._file.write(json.dumps(line) + "\n")
        self._file.flush()

    def arm_whenever_disarmed(self, ends: Event) -> None:
        """Arm the robot now and whenever it was stopped, as a person would who looks after it."""
        while not ends.wait(LOOKS_S):
            if self.robot is not None and not self.robot.armed:
                ready = self._ask_itself(AgentQuestion("ready", PERSON))
                self._ask_itself(AgentQuestion("arm", PERSON, permits={self.name: ready.permit}))

    def _ask_itself(self, question: AgentQuestion) -> AgentAnswer:
        return msgspec.msgpack.decode(self._answer(msgspec.msgpack.encode(question)), type=AgentAnswer)


def main() -> None:
    """Run until the program is told to end."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("team", type=Path)
    parser.add_argument("--name", required=True)
    parser.add_argument("--write", type=Path, required=True)
    arguments = parser.parse_args()
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, 0, PRIORITY)
    ends = Event()
    signal.signal(signal.SIGTERM, lambda number, frame: ends.set())
    team = load_team_plan(arguments.team, agent=arguments.name)
    network = ZenohNetwork(team.name, team.make_network_options(arguments.name))
    with arguments.write.open("a") as file:
        agent = RecordedAgent(arguments.name, team, network, file)
        Thread(target=agent.arm_whenever_disarmed, args=(ends,), daemon=True).start()
        agent.run(until=ends.is_set)
        agent.close()


if __name__ == "__main__":
    main()
