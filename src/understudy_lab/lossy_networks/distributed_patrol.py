"""Run the patrol with each agent in a network namespace of its own, or in one program, and measure its cycles."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from argparse import ArgumentParser
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from threading import Event, Thread
from typing import Any, TextIO

import msgspec
import numpy as np

from understudy.addons.robots.fleet import Fleet, connect_team
from understudy.addons.robots.team_network.agent_process import AgentProcess
from understudy.addons.robots.team_network.agent_questions import AgentAnswer, AgentQuestion
from understudy.addons.robots.team_network.load_plan import LoadedTeam, load_team_plan
from understudy.addons.robots.team_network.zenoh_network import ZenohNetwork
from understudy.addons.robots.twin import DigitalTwin
from understudy.errors import UnderstudyError
from understudy.runtime.engine.engine import Engine
from understudy.runtime.team.team import Team
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import Libraries
from understudy.storage.library_folder import save_automaton
from understudy_lab.lossy_networks.links import LossyLinks
from understudy_lab.lossy_networks.simulated_robots import TEAM, WORLD
from understudy_lab.patrol import practice
from understudy_lab.patrol.metrics import count_cycles
from understudy_lab.patrol.tracks import OTHER, OrderedActivity, PatrolTracks, find_activity, make_tracks

SQUAD = f"{practice.SQUAD}_0"
ROBOTS = tuple(f"{practice.ROBOT}_{number}" for number in range(1, practice.ROBOTS + 1))
MEMBERS = (SQUAD, *ROBOTS)
BEHAVIOR, ALONE = "collective_patrol", "patrol"
PORT = 7447
PATIENCE_S = 60.0
FRESH_S = 0.5
"""The time for which an agent's last activity counts, s."""
LABORATORY = (sys.executable, "-m")


@contextmanager
def take_precedence(process: int = 0) -> Iterator[None]:
    """Give a process (0: this one) precedence, where that is permitted."""
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, process, PRIORITY)
    try:
        yield
    finally:
        with suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, process, 0)


@contextmanager
def simulate(folder: Path, world: int) -> Iterator[None]:
    """Simulate the robots of the patrol; their files are in the folder then."""
    command = [
        *LABORATORY,
        "understudy_lab.lossy_networks.simulated_robots",
        str(folder),
        "--seed",
        str(world),
    ]
    with subprocess.Popen(command) as simulated:
        try:
            with take_precedence(simulated.pid):
                wait_for(folder / TEAM)
                yield
        finally:
            simulated.terminate()
            simulated.wait(20.0)


def wait_until(holds: Callable[[], bool], problem: str) -> None:
    """Wait until a condition holds; raise TimeoutError with the problem if it does not within a minute."""
    until = time.monotonic() + PATIENCE_S
    while not holds():
        if time.monotonic() > until:
            raise TimeoutError(problem)
        time.sleep(0.05)


def wait_for(path: Path) -> None:
    """Wait until a file is there and not empty; raise TimeoutError if it never is."""
    wait_until(lambda: path.is_file() and path.stat().st_size > 0, f"{path.name} never came")


def save_library(libraries: Libraries, folder: Path) -> None:
    """Save what was taught as the library of a team."""
    for automaton in libraries[practice.ROBOT].taught.values():
        save_automaton(folder, automaton)
    for automaton in libraries[practice.SQUAD].taught.values():
        save_automaton(folder / practice.SQUAD, automaton)


class AgentsApart:
    """The agents of the patrol, each a process in a namespace of its own.

    Parameters
    ----------
    folder
        The folder of the team's file, to which agents write what they did.
    library
        The folder of the library.
    links
        The links between the agents.
    """

    def __init__(self, folder: Path, library: Path, links: LossyLinks) -> None:
        self.folder, self.links = folder, links
        self.running: dict[str, subprocess.Popen[bytes]] = {}
        self.file = folder / "agents.toml"
        self.file.write_text((folder / TEAM).read_text() + _format_settings(library, links))
        with ExitStack() as failed:
            failed.callback(self.close)
            for name in MEMBERS:
                self.start(name)
            for name in MEMBERS:
                wait_for(self.log(name))
            failed.pop_all()

    def log(self, name: str) -> Path:
        """Return the file in which an agent records its ticks."""
        return self.folder / f"{name}.jsonl"

    def start(self, name: str) -> None:
        """Start an agent."""
        command = [*self.links.command(name), *LABORATORY, "understudy_lab.lossy_networks.distributed_patrol"]
        options = [str(self.file), "--name", name, "--write", str(self.log(name))]
        self.running[name] = subprocess.Popen([*command, *options])

    def signal(self, name: str, number: int) -> None:
        """Send a signal to an agent."""
        self.running[name].send_signal(number)

    def close(self) -> None:
        """End all agents."""
        for process in self.running.values():
            with suppress(ProcessLookupError):
                process.send_signal(signal.SIGCONT)
                process.terminate()
        for process in self.running.values():
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()


def _format_settings(library: Path, links: LossyLinks) -> str:
    addresses = {name: f"udp/{links.address(name)}:{PORT}" for name in MEMBERS}
    connect = ", ".join(f'"{address}"' for address in addresses.values())
    each = "".join(f'[agents.each.{name}]\nlisten = ["{address}"]\n' for name, address in addresses.items())
    return (
        f'\n[agents]\nlibrary = "{library}"\n[agents.runs]\n{practice.SQUAD} = "{BEHAVIOR}"\n'
        f'{practice.ROBOT} = "{ALONE}"\n[agents.network]\nmulticast = false\nconnect = [{connect}]\n{each}'
    )


def run_apart(folder: Path, library: Path, links: LossyLinks, *, seconds: float) -> dict[str, list[Any]]:
    """Run the agents for a while, once all robots are armed.

    Parameters
    ----------
    folder
        The folder of the team's file.
    library
        The folder of the library.
    links
        The links between the agents.
    seconds
        How long, s.

    Returns
    -------
    dict
        For each robot, what it was ordered to do: times, s, and activities.
    """
    agents = AgentsApart(folder, library, links)
    try:
        wait_until(lambda: all(_is_armed(agents.log(name)) for name in ROBOTS), "the robots were never armed")
        began_s = time.monotonic()
        time.sleep(seconds)
    finally:
        agents.close()
    activities = {}
    for name in ROBOTS:
        lines = [line for line in read_lines(agents.log(name)) if line["ended_s"] >= began_s]
        activities[name] = [(line["ended_s"], find_activity(line.get("duty"))) for line in lines]
    return activities


def _is_armed(log: Path) -> bool:
    lines = read_lines(log)
    return bool(lines) and bool(lines[-1]["armed"])


def read_lines(path: Path) -> list[Any]:
    """Read the lines of a recording; one that was cut off at the end is left out."""
    lines = []
    for text in path.read_text().splitlines() if path.is_file() else ():
        with suppress(json.JSONDecodeError):
            lines.append(json.loads(text))
    return lines


def run_together(folder: Path, libraries: Libraries, *, seconds: float) -> dict[str, list[Any]]:
    """Run the patrol in this program for a while, as `understudy robots run` does; return as `run_apart`."""
    activities: dict[str, list[Any]] = {name: [] for name in ROBOTS}
    with connect_team(folder / TEAM) as fleet, take_precedence():
        wait_for_readings(fleet)
        twin = DigitalTwin(fleet)
        team, ordered = make_live_team(twin, libraries)
        fleet.arm(PERSON)
        began = due = looks_s = time.monotonic()
        while time.monotonic() - began < seconds:
            team.tick()
            now = time.monotonic()
            for name, activity in zip(ROBOTS, ordered.now()[0], strict=True):
                activities[name].append((now, int(activity)))
            if now >= looks_s:
                looks_s = now + LOOKS_S
                for robot in fleet:
                    if not robot.armed:
                        with suppress(UnderstudyError):
                            robot.arm(PERSON)
            due = max(due + twin.tick_s, now)
            time.sleep(max(0.0, due - time.monotonic()))
    return activities


def wait_for_readings(fleet: Fleet) -> None:
    """Wait until each robot sends all readings, and for the watchdogs."""
    wait_until(
        lambda: all(robot.senses.find_missing(robot.now_s) is None for robot in fleet),
        "the simulated robots never came",
    )
    time.sleep(1.0)


def make_live_team(twin: DigitalTwin, libraries: Libraries) -> tuple[Team, OrderedActivity]:
    """Make the team that decides for robots in this program, and what tells the activity of each."""
    members = assign_team_members(twin.scenario)
    team = Team(twin, members, libraries, {practice.SQUAD: (BEHAVIOR, {})}, makes=Engine, seeds=(0,))
    return team, OrderedActivity(team, 1, ["home"])


def measure_cycles(folder: Path, activities: dict[str, list[Any]]) -> dict[str, Any]:
    """Return the cycles and captures in a recorded world."""
    tracks = _read_tracks(folder, activities)
    return {
        "minutes": round(tracks.ticks * tracks.tick_s / 60.0, 2),
        "tick_s": round(tracks.tick_s, 4),
        **count_cycles(tracks),
    }


def _read_tracks(folder: Path, activities: dict[str, list[Any]]) -> PatrolTracks:
    begins = max(done[0][0] for done in activities.values())
    ends = min(done[-1][0] for done in activities.values())
    lines = [line for line in read_lines(folder / WORLD) if begins <= line["at_s"] <= ends]
    at_s = np.array([line["at_s"] for line in lines])
    doing = np.full((len(lines), len(ROBOTS)), OTHER, np.int8)
    for row, name in enumerate(ROBOTS):
        done = activities[name]
        times = np.array([each[0] for each in done])
        last = np.searchsorted(times, at_s, "right") - 1
        fresh = at_s - times[last] < FRESH_S
        doing[:, row] = np.where(fresh, np.array([each[1] for each in done])[last], OTHER)
    things = {
        name: np.array([line["objects"][name] for line in lines]) for name in ("intruder", "boss", "home")
    }
    return make_tracks(
        float(at_s[-1] - at_s[0]) / (len(lines) - 1),
        doing,
        np.array([line["robots"] for line in lines]),
        intruder=things["intruder"],
        boss=things["boss"],
        home=things["home"][-1, :2],
    )


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
