"""Commands `understudy team`: see, arm and stop the agents of a team, from any computer of its network."""

from __future__ import annotations

import getpass
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.errors import join_names
from understudy.ui.cli.commands.agent import TeamFileArgument
from understudy.ui.cli.options import Json

if TYPE_CHECKING:
    from understudy.robots.recording.merge import MemberClock
    from understudy.robots.team_network.agent_questions import AgentAnswer, AgentStatus
    from understudy.robots.team_network.load_plan import LoadedTeam
    from understudy.robots.team_network.zenoh_network import ZenohNetwork, ZenohOptions

FOUND_S = 1.0
"""The time in s in which other agents are found by multicast."""
OneAgent = Annotated[
    str, typer.Option("--name", help="Name of one agent. By default all.", show_default=False)
]

app = typer.Typer(no_args_is_help=True, help="See, arm and stop the agents of a team.")


@app.command("status")
def show_status(file: TeamFileArgument, as_json: Json = False) -> None:
    """Show what each agent does, on whose order, and which are missing.

    The exit code is 1 if an agent is missing.

    [dim]understudy team status team.toml[/]
    """
    from understudy.robots.team_network.agent_questions import AgentQuestion, ask
    from understudy.ui.cli.output import print_json

    with _connect(file) as (team, network):
        answers = ask(network, AgentQuestion("status"))
    found = [answer.status for answer in answers.values() if answer.status is not None]
    missing = [name for name in team.agents if name not in answers]
    libraries = _find_differing(team, found)
    if as_json:
        print_json({"team": team.name, "agents": found, "missing": missing, "other_library": libraries})
    else:
        _print_status(team, found, missing, libraries)
    if missing:
        raise typer.Exit(1)


def _find_differing(team: LoadedTeam, found: list[AgentStatus]) -> list[str]:
    """Return the agents whose library is not the one of this computer."""
    return [each.name for each in found if each.library != team.fingerprints[each.sort]]


def _print_status(
    team: LoadedTeam, found: list[AgentStatus], missing: list[str], libraries: list[str]
) -> None:
    from understudy.ui.cli.output import make_console, make_table

    made = make_table("agent", "~doing", "order", "from", "leads")
    problems = {each.name: each.unfit for each in found if each.unfit}
    for each in found:
        doing = " > ".join(filter(None, (each.duty, *each.path)))
        order = "" if each.order is None else f"{each.order[0]}.{each.order[1]}"
        made.add_row(each.name, doing or "nothing", order, each.leader or "", ", ".join(each.leads))
        problems |= {name: problem for name, problem in each.missing.items() if name not in problems}
    out = make_console()
    if found:
        out.print(made)
    else:
        out.print(_say_nobody(team.name), markup=False)
        return
    if problems:
        said = ", ".join(f"{name} ({problem})" for name, problem in problems.items())
        out.print(f"Not counted: {said}.", markup=False)
    if libraries:
        out.print(f"With another library than here: {', '.join(libraries)}.", markup=False)
    if missing:
        out.print(f"Not there: {', '.join(missing)}.", markup=False)


@app.command("stop")
def stop_team(file: TeamFileArgument, name: OneAgent = "*", as_json: Json = False) -> None:
    """Stop and disarm the robots of a team at once.

    The exit code is 1 if a robot's agent did not answer: look whether the robot stands.

    [dim]understudy team stop team.toml[/]
    """
    from understudy.robots.team_network.agent_questions import ask_to_stop

    _order_robots(file, name, "stopped", ask_to_stop, as_json=as_json)


@app.command("arm")
def arm_team(file: TeamFileArgument, name: OneAgent = "*", as_json: Json = False) -> None:
    """Let the robots of a team move. A person confirms it in the terminal.

    [dim]understudy team arm team.toml[/]
    """
    from understudy.errors import SettingError

    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise SettingError(
            where="understudy team arm", setting="its input or output",
            problem="is not a terminal, so that no person can confirm it",
            remedy="run it in one, and have `understudy team stop` ready in another",
        )  # fmt: skip
    _order_robots(file, name, "armed", partial(_arm_if_confirmed, file), as_json=as_json)


def _arm_if_confirmed(
    file: TeamFileArgument, network: ZenohNetwork, by: str, name: str
) -> Mapping[str, AgentAnswer]:
    """Prepare robots, and arm them if a person confirms it."""
    from understudy.errors import SettingError
    from understudy.robots.team_network.agent_questions import ask_to_arm, ask_to_prepare

    typer.echo("Starting the watchdogs ...", err=True)
    ask_to_prepare(network, by, name)
    typer.echo("The robots will move. Type arm and Enter to let them:", err=True)
    if sys.stdin.readline().strip().lower() != "arm":
        raise SettingError(
            where=str(file), setting="arming", problem="was not confirmed; nothing moved",
            remedy="type arm to let them move",
        )  # fmt: skip
    return ask_to_arm(network, by, name)


@app.command("logs")
def show_logs(file: TeamFileArgument, name: OneAgent = "*", as_json: Json = False) -> None:
    """Show what happened to each agent: orders, leaders, stops.

    The exit code is 1 if no agent answers.

    [dim]understudy team logs team.toml --name scout_2[/]
    """
    from understudy.robots.team_network.agent_questions import AgentQuestion, ask
    from understudy.ui.cli.output import print_json

    with _connect(file) as (team, network):
        _check_name(name, team.agents, what="agent", team=team.name)
        answers = ask(network, AgentQuestion("logs"), agent=name)
    if as_json:
        print_json({"logs": {agent: answer.log for agent, answer in answers.items()}})
    for line in sorted(line for answer in answers.values() for line in answer.log) if not as_json else ():
        typer.echo(line)
    if not answers:
        typer.echo(_say_nobody(team.name) if name == "*" else f"{name} is not there.", err=True)
        raise typer.Exit(1)


@app.command("push")
def push_to_team(
    file: TeamFileArgument,
    library: Annotated[
        Path | None,
        typer.Option(help="Folder of the automata. By default as the team's file says.", show_default=False),
    ] = None,
    as_json: Json = False,
) -> None:
    """Hand a library to all agents of a team: all take it over and keep the former one, or all go back to it.

    The robots must be disarmed. The exit code is 1 if an agent is missing, refuses, or does not answer; then the output
    says which library each agent has.

    [dim]understudy team push team.toml --library library[/]
    """
    from understudy.robots.team_network.agent_questions import ask
    from understudy.robots.team_network.library_push import read_library_files
    from understudy.robots.team_network.team_push import describe_push, push_library
    from understudy.ui.cli.output import print_json

    with _connect(file) as (team, network):
        by = f"{getpass.getuser()} in a terminal"
        files = read_library_files(library or team.library)
        results = push_library(partial(ask, network), files, agents=team.agents, by=by)
    if as_json:
        problems = {agent: result.problem for agent, result in results.items()}
        print_json(
            {"agents": problems, "libraries": {agent: each.library for agent, each in results.items()}}
        )
    else:
        typer.echo("\n".join(describe_push(results)))
    if any(result.problem or result.library != "new" for result in results.values()):
        raise typer.Exit(1)


def _say_nobody(team: str) -> str:
    return f"No agent of team {team} is there; start them with understudy agent, or correct [agents.network]."


@app.command("merge")
def merge_team(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="The new file.", show_default=False)],
    recordings: Annotated[
        list[Path],
        typer.Argument(
            metavar="RECORDING...", help="Recordings of agents, from their computers.", show_default=False
        ),
    ],
    reference: Annotated[
        str | None,
        typer.Option(
            help="Agent whose clock the new file has. By default that of the first recording.",
            show_default=False,
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Merge the recordings of a team's agents into one file with one clock.

    The computers need no common clock: how far each is ahead is found from the messages that they exchanged. The
    largest error of each is printed, and stored in the file.

    [dim]understudy team merge team.mcap patrol_0.mcap scout_1.mcap scout_2.mcap[/]

    [dim]understudy why team.mcap --agent scout_2 --time 12.5[/]
    """
    from understudy.robots.recording.merge import merge_recordings
    from understudy.ui.cli.output import make_console, print_json

    clock = merge_recordings(out, recordings, reference=reference)
    if as_json:
        print_json({"recording": str(out), "reference": clock.reference, "members": clock.members})
        return
    made = make_console()
    for each in clock.members:
        made.print(_describe_clock(each, clock.reference), markup=False, soft_wrap=True)
    made.print(f"Merged in {out}, by the clock of {clock.reference}.", markup=False, soft_wrap=True)


def _describe_clock(each: MemberClock, reference: str) -> str:
    """Describe how the clock of an agent was found to be."""
    killed = (
        "" if each.whole else " Its recording was not closed: what was recorded until then is all there is."
    )
    if each.agent == reference:
        return f"{each.agent}: the reference.{killed}"
    side = "ahead of" if each.ahead_s >= 0 else "behind"
    by = f" by way of {join_names(each.by_way_of)}" if each.by_way_of else ""
    uneven = f" The clocks run unevenly, by {each.uneven_s * 1e3:.2g} ms." if each.uneven_s else ""
    return (
        f"{each.agent}: clock {abs(each.ahead_s):.4f} s {side} that of {reference}, {each.drift_ppm:+.1f} ppm; "
        f"error at most {each.error_s * 1e3:.2g} ms ({each.messages} messages{by}).{uneven}{killed}"
    )


def _order_robots(
    file: TeamFileArgument,
    name: str,
    done: str,
    order: Callable[[ZenohNetwork, str, str], Mapping[str, AgentAnswer]],
    *,
    as_json: bool,
) -> None:
    """Arm or stop robots; only the names in the files are needed, no library."""
    from understudy.robots.team_network.load_plan import load_team_names, make_network_options
    from understudy.ui.cli.output import print_json

    team, names = load_team_names(file)
    _check_name(name, names, what="robot", team=team.name)
    with _join(team.name, make_network_options(team.agents)) as network:
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


def _check_name(name: str, known: Sequence[str], *, what: str, team: str) -> None:
    from understudy.errors import UnknownName

    if name not in ("*", *known):
        raise UnknownName(what=what, name=name, where=f"team {team}", known=list(known))


@contextmanager
def _connect(file: TeamFileArgument) -> Iterator[tuple[LoadedTeam, ZenohNetwork]]:
    """Load a team and join its network as a visitor."""
    from understudy.robots.team_network.load_plan import load_team_plan

    team = load_team_plan(file)
    with _join(team.name, team.make_network_options()) as network:
        yield team, network


@contextmanager
def _join(team: str, options: ZenohOptions) -> Iterator[ZenohNetwork]:
    """Join a team's network as a visitor, and wait until its agents are found."""
    from time import sleep

    from understudy.robots.team_network.zenoh_network import ZenohNetwork

    network = ZenohNetwork(team, options)
    try:
        sleep(FOUND_S)
        yield network
    finally:
        network.close()
