"""A patrol whose robots and coordinator are agents in processes of this machine, with real messages."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.robots.routers import free_port

from understudy.robots.team_network.agent_questions import (
    AgentAnswer,
    AgentQuestion,
    ask,
    ask_to_arm,
    ask_to_prepare,
)
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

    def arm(self) -> Mapping[str, AgentAnswer]:
        """Arm all robots that can be, and return the answers."""
        ask_to_prepare(self.visitor, "a trial")
        return ask_to_arm(self.visitor, "a trial")

    def find_leaders(self) -> list[str]:
        """Find the agents that lead the squad."""
        return [
            name
            for name, answer in self.ask("status").items()
            if answer.status is not None and SQUAD in answer.status.leads
        ]


def wait_until(seen: Callable[[], bool], what: str) -> None:
    """Wait until something is so; raise TimeoutError if it never is."""
    until = time.monotonic() + PATIENCE_S
    while not seen():
        if time.monotonic() > until:
            raise TimeoutError(what)
        time.sleep(0.1)


@contextmanager
def run_patrol(seed: int, *, trainer: str | None = None) -> Iterator[AgentProcesses]:
    """Teach a patrol, simulate its robots, and run an agent for each robot and the coordinator.

    `trainer` is the name of the computer from which robots may be trained.
    """
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
            text.write(_format_settings(trainer))
        team = load_team_plan(file)
        visitor = ZenohNetwork(team.name, team.make_network_options())
        ends.callback(visitor.close)
        agents = AgentProcesses(file, team, visitor)
        ends.callback(agents.end)
        for name in team.agents:
            agents.start(name)
        wait_until(lambda: visitor.present >= set(team.agents), "the agents never came")
        time.sleep(SETTLES_S)
        agents.arm()
        yield agents


def _format_settings(trainer: str | None) -> str:
    names = [SQUAD, *(f"pioneer_{number}" for number in range(1, 5))]
    ports = {name: f"tcp/127.0.0.1:{free_port()}" for name in names}
    trains = "" if trainer is None else f'trainer = "{trainer}"\n'
    connect = ", ".join(f'"{port}"' for port in ports.values())
    listen = "".join(f'[agents.each.{name}]\nlisten = ["{port}"]\n' for name, port in ports.items())
    return (
        f'\n[agents]\n{trains}library = "../library"\n[agents.runs]\npatrol = "collective_patrol"\npioneer = "patrol"\n'
        f"[agents.network]\nmulticast = false\nconnect = [{connect}]\n{listen}"
    )
