"""Commands `understudy team stop` and `understudy team arm`; they need no library, so that they are quick."""

from __future__ import annotations

import getpass
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from time import sleep

import typer

from understudy.addons.robots.team_network.agent_questions import (
    AgentAnswer,
    ask_to_arm,
    ask_to_prepare,
    ask_to_stop,
)
from understudy.addons.robots.team_network.load_plan import load_team_names, make_network_options
from understudy.addons.robots.team_network.zenoh_network import ZenohNetwork, ZenohOptions
from understudy.errors import SettingError, UnknownName
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.robots_options import TeamArmOptions, TeamStopOptions

FOUND_S = 1.0
"""The time in s in which other agents are found by multicast."""


def stop_team(options: TeamStopOptions) -> None:
    """Stop and disarm the robots of a team at once."""
    _order_robots(options.file, options.name, "stopped", ask_to_stop, as_json=options.as_json)


def arm_team(options: TeamArmOptions) -> None:
    """Let the robots of a team move. A person confirms it in the terminal."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise SettingError(
            where="understudy team arm", setting="its input or output",
            problem="is not a terminal, so that no person can confirm it",
            remedy="run it in one, and have `understudy team stop` ready in another",
        )  # fmt: skip
    _order_robots(
        options.file, options.name, "armed", partial(_arm_if_confirmed, options.file), as_json=options.as_json
    )


def _arm_if_confirmed(file: Path, network: ZenohNetwork, by: str, name: str) -> Mapping[str, AgentAnswer]:
    """Prepare robots, and arm them if a person confirms it."""
    typer.echo("Starting the watchdogs ...", err=True)
    ask_to_prepare(network, by, name)
    typer.echo("The robots will move. Type arm and Enter to let them:", err=True)
    if sys.stdin.readline().strip().lower() != "arm":
        raise SettingError(
            where=str(file), setting="arming", problem="was not confirmed; nothing moved",
            remedy="type arm to let them move",
        )  # fmt: skip
    return ask_to_arm(network, by, name)


def _order_robots(
    file: Path,
    name: str,
    done: str,
    order: Callable[[ZenohNetwork, str, str], Mapping[str, AgentAnswer]],
    *,
    as_json: bool,
) -> None:
    """Arm or stop robots; only the names in the files are needed, no library."""
    team, names = load_team_names(file)
    check_agent_name(name, names, what="robot", team=team.name)
    with join_team(team.name, make_network_options(team.agents)) as network:
        answers = order(network, f"{getpass.getuser()} in a terminal", name)
    said = {robot: _describe(answers, robot, done) for robot in names if name in ("*", robot)}
    if as_json:
        print_json({"robots": said})
    else:
        for robot, text in said.items():
            typer.echo(f"{robot}: {text}")
    if any(text != done for text in said.values()):
        raise typer.Exit(1)


def _describe(answers: Mapping[str, AgentAnswer], robot: str, done: str) -> str:
    answer = answers.get(robot)
    if answer is None:
        return "did not answer: look whether it stands"
    return answer.problem or done


def check_agent_name(name: str, known: Sequence[str], *, what: str, team: str) -> None:
    """Refuse a name that none of the team has; `*` stands for all."""
    if name not in ("*", *known):
        raise UnknownName(what=what, name=name, where=f"team {team}", known=list(known))


@contextmanager
def join_team(team: str, options: ZenohOptions) -> Iterator[ZenohNetwork]:
    """Join a team's network as a visitor, and wait until its agents are found."""
    network = ZenohNetwork(team, options)
    try:
        sleep(FOUND_S)
        yield network
    finally:
        network.close()
