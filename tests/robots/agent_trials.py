"""Trials of agents in processes of their own: coordinators and robots that are killed or frozen, with real messages.

    python -m tests.robots.agent_trials --times 10

prints for each kind of trial how long the squad was without a leader, in the middle and at worst, and what was wrong.
Four simulated robots speak ROS 2; the agents speak Zenoh. All are on this machine.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from tests.robots.routers import free_port

from understudy.robots.team_network.agent_process import AgentAnswer, AgentQuestion, ask
from understudy.robots.team_network.load_plan import LoadedTeam, load_team_plan
from understudy.robots.team_network.zenoh_network import ZenohNetwork
from understudy.storage.library_folder import save_automaton
from understudy_lab.patrol import practice
from understudy_lab.patrol.teach import teach

DOMAIN = 63
SQUAD = "patrol_0"
PATIENCE_S = 60.0
SETTLES_S = 2.0
COMMAND = (sys.executable, "-m", "understudy.ui.cli")


@dataclass
class Trial:
    """One trial: how long nobody led, s, and what was wrong; empty if nothing was."""

    without_s: float
    wrong: str = ""


class AgentProcesses:
    """The agents of a team as processes of this machine."""

    def __init__(self, file: Path, team: LoadedTeam, visitor: ZenohNetwork) -> None:
        self.file, self.team, self.visitor = file, team, visitor
        self.running: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, name: str) -> None:
        """Start an agent."""
        command = [*COMMAND, "agent", str(self.file), "--name", name]
        self.running[name] = subprocess.Popen(command, stderr=subprocess.DEVNULL)

    def end(self) -> None:
        """End all agents."""
        for process in self.running.values():
            with suppress(ProcessLookupError):
                process.send_signal(signal.SIGCONT)
            process.terminate()
        for process in self.running.values():
            process.wait(20.0)

    def ask(self, do: str) -> Mapping[str, AgentAnswer]:
        """Ask all agents."""
        return ask(self.visitor, AgentQuestion(do, by="a trial"))

    def find_leaders(self) -> list[str]:
        """Find the agents that lead the squad."""
        return [
            name
            for name, answer in self.ask("status").items()
            if answer.status is not None and SQUAD in answer.status.leads
        ]

    def find_takeover(self, after: float) -> float | None:
        """Return when an agent began to lead after a time of day, s; None if none did."""
        day = time.mktime((*time.localtime(after)[:3], 0, 0, 0, 0, 0, -1))
        found = []
        for answer in self.ask("logs").values():
            for line in answer.log:
                stamp, _, said = line.partition(" ")
                if " leads " in said and "no longer" not in said:
                    hours, minutes, seconds = stamp.split(":")
                    found.append(day + int(hours) * 3600 + int(minutes) * 60 + float(seconds))
        return min((each for each in found if each >= after), default=None)


def wait_until(seen: Callable[[], bool], what: str) -> None:
    """Wait until something is so; raise TimeoutError if it never is."""
    until = time.monotonic() + PATIENCE_S
    while not seen():
        if time.monotonic() > until:
            raise TimeoutError(what)
        time.sleep(0.1)


@contextmanager
def run_patrol(seed: int) -> Iterator[AgentProcesses]:
    """Teach a patrol, simulate its robots, and run an agent for each robot and the coordinator."""
    with TemporaryDirectory() as folder, ExitStack() as ends:
        where = Path(folder)
        taught = teach(seed)
        for automaton in taught.robots.library.taught.values():
            save_automaton(where / "library", automaton)
        for automaton in taught.coordinators.library.taught.values():
            save_automaton(where / "library" / practice.SQUAD, automaton)
        file = where / "files" / "team.toml"
        command = [*COMMAND, "robots", "simulate", "patrol", "--domain", str(DOMAIN), "--rate", "10"]
        simulated = subprocess.Popen([*command, "--write-files", str(file.parent)], stdout=subprocess.DEVNULL)
        ends.callback(simulated.wait, 20.0)
        ends.callback(simulated.terminate)
        wait_until(file.is_file, "the simulated robots never came")
        with file.open("a") as text:
            text.write(_settings())
        team = load_team_plan(file)
        visitor = ZenohNetwork(team.name, team.make_network_options())
        ends.callback(visitor.close)
        agents = AgentProcesses(file, team, visitor)
        ends.callback(agents.end)
        for name in team.agents:
            agents.start(name)
        wait_until(lambda: visitor.present >= set(team.agents), "the agents never came")
        time.sleep(SETTLES_S)
        agents.ask("arm")
        yield agents


def _settings() -> str:
    names = [SQUAD, *(f"pioneer_{number}" for number in range(1, 5))]
    ports = {name: f"tcp/127.0.0.1:{free_port()}" for name in names}
    connect = ", ".join(f'"{port}"' for port in ports.values())
    listen = "".join(f'[agents.each.{name}]\nlisten = ["{port}"]\n' for name, port in ports.items())
    return (
        '\n[agents]\nlibrary = "../library"\n[agents.runs]\npatrol = "collective_patrol"\npioneer = "patrol"\n'
        f"[agents.network]\nmulticast = false\nconnect = [{connect}]\n{listen}"
    )


def kill_leader(agents: AgentProcesses) -> Trial:
    """Kill the leader's process, and start it again afterwards."""
    leader = agents.find_leaders()[0]
    began = time.time()
    agents.running[leader].kill()
    agents.running[leader].wait()
    time.sleep(SETTLES_S)
    trial = _judge(agents, began, leader)
    agents.start(leader)
    wait_until(lambda: leader in agents.visitor.present, f"{leader} never came back")
    time.sleep(SETTLES_S)
    agents.ask("arm")
    return trial


def freeze_leader(agents: AgentProcesses) -> Trial:
    """Freeze the leader's process for a while."""
    leader = agents.find_leaders()[0]
    began = time.time()
    os.kill(agents.running[leader].pid, signal.SIGSTOP)
    time.sleep(SETTLES_S)
    trial = _judge(agents, began, leader)
    os.kill(agents.running[leader].pid, signal.SIGCONT)
    time.sleep(SETTLES_S)
    now = agents.find_leaders()
    if len(now) != 1 and not trial.wrong:
        trial.wrong = f"then {len(now)} led"
    agents.ask("arm")
    return trial


def _judge(agents: AgentProcesses, began: float, before: str) -> Trial:
    found = agents.find_takeover(began)
    leaders = [name for name in agents.find_leaders() if name != before]
    if found is None or len(leaders) != 1:
        return Trial(float("inf") if found is None else found - began, f"{len(leaders)} led")
    return Trial(found - began)


TRIALS: Mapping[str, Callable[[AgentProcesses], Trial]] = {"killed": kill_leader, "frozen": freeze_leader}


def main() -> None:
    """Run trials of each kind and print what was measured."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1000, help="of the teaching")
    asked = parser.parse_args()
    with run_patrol(asked.seed) as agents:
        for name, run in TRIALS.items():
            trials = [run(agents) for _ in range(asked.times)]
            found = [trial.without_s for trial in trials]
            wrong = [trial.wrong for trial in trials if trial.wrong]
            said = f"without a leader {median(found):.2f} s in the middle, {max(found):.2f} s at worst"
            sys.stdout.write(f"{name}, {len(trials)} times: {said}; wrong: {wrong or 'nothing'}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
