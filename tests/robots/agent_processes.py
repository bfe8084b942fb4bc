"""A patrol whose robots and coordinator are agents in processes of this machine, with real messages."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from tests import waiting
from tests.processes import end_with_tests
from tests.robots.domains import own_domain
from tests.robots.routers import free_port

from understudy.addons.robots.team_network.agent_questions import (
    AgentAnswer,
    AgentQuestion,
    ask,
    ask_to_arm,
    ask_to_prepare,
)
from understudy.addons.robots.team_network.load_plan import LoadedTeam, load_team_plan, open_libraries
from understudy.addons.robots.team_network.zenoh_network import ZenohNetwork
from understudy.model.features import BoundFeature, TimeInState
from understudy.model.library import TrainedAutomaton
from understudy.sim.catalog import find_scenario
from understudy.storage.library_folder import save_automaton
from understudy_lab.tree_builder import build_automaton, split_below, split_on_flag

DOMAIN = own_domain()
SQUAD = "patrol_0"
ROBOTS = tuple(f"pioneer_{number}" for number in range(1, 5))
BOUND_S = 120.0
"""The time after which a team counts as never in a state, s: five programs start at once on a busy machine."""
TURNS_S = 1.45
COMMAND = (sys.executable, "-m", "understudy.ui.cli")


class AgentProcesses:
    """The agents of a team as processes of this machine, which end with the tests.

    Each writes a recording to the folder `record`, unless that is None.
    """

    def __init__(
        self, file: Path, team: LoadedTeam, visitor: ZenohNetwork, *, record: Path | None = None
    ) -> None:
        self.file, self.team, self.visitor, self._record = file, team, visitor, record
        self.processes: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, name: str) -> None:
        """Start an agent."""
        command = [*COMMAND, "agent", str(self.file), "--name", name]
        if self._record is not None:
            command += ["--record", str(self._record / f"{name}.mcap")]
        self.processes[name] = subprocess.Popen(end_with_tests(command), stderr=subprocess.DEVNULL)

    def end(self) -> None:
        """End all agents."""
        for process in self.processes.values():
            with suppress(ProcessLookupError):
                process.send_signal(signal.SIGCONT)
            process.terminate()
        for process in self.processes.values():
            process.wait(BOUND_S)

    def ask(self, do: str) -> Mapping[str, AgentAnswer]:
        """Ask all agents."""
        return ask(self.visitor, AgentQuestion(do, by="a trial"))

    def arm(self) -> Mapping[str, AgentAnswer]:
        """Arm all robots that can be, and return the answers."""
        ask_to_prepare(self.visitor, "a trial")
        return ask_to_arm(self.visitor, "a trial")

    def are_armed(self) -> bool:
        """Whether all robots are armed; if one is not, arm it: on a busy machine, its guard may have stopped it."""
        answers = self.ask("status")
        found = [answers[name].status for name in self.team.robots if name in answers]
        if len(found) == len(self.team.robots) and all(
            status is not None and status.armed for status in found
        ):
            return True
        self.arm()
        return False

    def find_leaders(self) -> list[str]:
        """Find the agents that lead the squad."""
        return [
            name
            for name, answer in self.ask("status").items()
            if answer.status is not None and SQUAD in answer.status.leads
        ]


def wait_until(seen: Callable[[], object], what: str) -> None:
    """Wait until something is so; raise TimeoutError if it never is."""
    try:
        waiting.wait_until(seen, bound_s=BOUND_S)
    except TimeoutError:
        raise TimeoutError(what) from None


def save_patrol(folder: Path) -> None:
    """Save a coordinator that lets all robots patrol, and disperse once all have; robots turn on the spot."""
    turned = {"time_in_state": BoundFeature(TimeInState())}
    for name, turns in (("patrol", "left"), ("disperse", "right")):
        built = build_automaton(
            name,
            {"start": turns, turns: split_below("time_in_state", TURNS_S, turns, "done")},
            readings=turned,
            flags=("done",),
            basics=(turns,),
        )
        save_automaton(folder, TrainedAutomaton(built))
    features = open_libraries(find_scenario("patrol"), folder)["patrol"].kit.features
    led = build_automaton(
        "collective_patrol",
        {
            "start": "patrol",
            "patrol": split_on_flag("all_done", "disperse", "patrol"),
            "disperse": split_on_flag("all_done", "patrol", "disperse"),
        },
        readings={"all_done": BoundFeature(features["all_done"])},
        runs={"patrol": "patrol", "disperse": "disperse"},
    )
    save_automaton(folder / "patrol", TrainedAutomaton(led))


@contextmanager
def simulate_patrol(folder: Path, domain: int, *, robots: int = len(ROBOTS), seed: int = 0) -> Iterator[Path]:
    """Simulate the robots of a patrol, and write the file of a team of the first of them.

    Their guards wait for late ticks as long as they may, and for readings for longer than a busy machine takes.
    """
    file = folder / "team.toml"
    command = [*COMMAND, "robots", "simulate", "patrol", "--domain", str(domain), "--rate", "10"]
    command += ["--seed", str(seed), "--write-files", str(folder)]
    simulated = subprocess.Popen(
        end_with_tests(command), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        wait_until(file.is_file, "the simulated robots never came")
        listed = ", ".join(f'"{name}.toml"' for name in ROBOTS[:robots])
        lines = [line for line in file.read_text().splitlines() if not line.startswith("robots")]
        file.write_text("\n".join([*lines, f"robots = [{listed}]\n"]))
        for name in ROBOTS:
            robot = folder / f"{name}.toml"
            text = re.sub(r"stale_s = [\d.]+", "stale_s = 10.0", robot.read_text())
            robot.write_text(f"{text}\n[safety]\ndeadline_s = 1.0\n")
        yield file
    finally:
        simulated.terminate()
        simulated.wait(BOUND_S)


@contextmanager
def run_patrol(
    seed: int, *, robots: int = len(ROBOTS), trainer: str | None = None, record: Path | None = None
) -> Iterator[AgentProcesses]:
    """Simulate the robots of a patrol, and run an agent for each robot and the coordinator.

    `seed` is that of the world, `robots` the number of robots that have agents, and `trainer` the name of the computer
    from which they may be trained.
    """
    with TemporaryDirectory() as folder, ExitStack() as ends:
        where = Path(folder)
        save_patrol(where / "library")
        file = ends.enter_context(simulate_patrol(where / "files", DOMAIN, robots=robots, seed=seed))
        with file.open("a") as text:
            text.write(_format_settings(ROBOTS[:robots], trainer))
        team = load_team_plan(file)
        visitor = ZenohNetwork(team.name, team.make_network_options())
        ends.callback(visitor.close)
        agents = AgentProcesses(file, team, visitor, record=record)
        ends.callback(agents.end)
        for name in team.agents:
            agents.start(name)
        wait_until(lambda: visitor.present >= set(team.agents), "the agents never came")
        wait_until(agents.are_armed, "a robot was never armed")
        yield agents


def _format_settings(robots: Sequence[str], trainer: str | None) -> str:
    names = [SQUAD, *robots]
    ports = {name: f"tcp/127.0.0.1:{free_port()}" for name in names}
    trains = "" if trainer is None else f'trainer = "{trainer}"\n'
    connect = ", ".join(f'"{port}"' for port in ports.values())
    listen = "".join(f'[agents.each.{name}]\nlisten = ["{port}"]\n' for name, port in ports.items())
    return (
        f'\n[agents]\n{trains}library = "../library"\n[agents.runs]\npatrol = "collective_patrol"\npioneer = "patrol"\n'
        f"[agents.network]\nmulticast = false\nconnect = [{connect}]\n{listen}"
    )
