"""Commands `understudy team`: run and see the agents of a team, hand them a library, and merge their recordings."""

from __future__ import annotations

import getpass
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path

import typer

from understudy.addons.robots.team_network.agent_process import AgentProcess
from understudy.addons.robots.team_network.agent_questions import AgentQuestion, AgentStatus, ask
from understudy.addons.robots.team_network.library_push import read_library_files
from understudy.addons.robots.team_network.load_plan import LoadedTeam, load_team_plan
from understudy.addons.robots.team_network.team_push import describe_push, push_library
from understudy.addons.robots.team_network.zenoh_network import ZenohNetwork
from understudy.clock import REAL_TIME
from understudy.records.recorder import RunRecorder
from understudy.ui.cli.commands.team_orders import check_agent_name, join_team
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import make_console, make_table
from understudy.ui.cli.robot_connection import choose_recording_path, interrupt_on_termination
from understudy.ui.cli.robots_options import AgentOptions, TeamLogsOptions, TeamPushOptions, TeamStatusOptions


def show_status(options: TeamStatusOptions) -> None:
    """Show what each agent does, on whose order, and which are missing."""
    with _connect(options.file) as (team, network):
        answers = ask(network, AgentQuestion("status"))
    found = [answer.status for answer in answers.values() if answer.status is not None]
    missing = [name for name in team.agents if name not in answers]
    libraries = _find_differing(team, found)
    if options.as_json:
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


def show_logs(options: TeamLogsOptions) -> None:
    """Show what happened to each agent: orders, leaders, stops."""
    with _connect(options.file) as (team, network):
        check_agent_name(options.name, team.agents, what="agent", team=team.name)
        answers = ask(network, AgentQuestion("logs"), agent=options.name)
    if options.as_json:
        print_json({"logs": {agent: answer.log for agent, answer in answers.items()}})
    for line in (
        sorted(line for answer in answers.values() for line in answer.log) if not options.as_json else ()
    ):
        typer.echo(line)
    if not answers:
        typer.echo(
            _say_nobody(team.name) if options.name == "*" else f"{options.name} is not there.", err=True
        )
        raise typer.Exit(1)


def push_to_team(options: TeamPushOptions) -> None:
    """Hand a library to all agents of a team: all take it over and keep the former one, or all go back to it."""
    with _connect(options.file) as (team, network):
        by = f"{getpass.getuser()} in a terminal"
        files = read_library_files(options.library or team.library)
        results = push_library(partial(ask, network), files, agents=team.agents, by=by)
    if options.as_json:
        problems = {agent: result.problem for agent, result in results.items()}
        print_json(
            {"agents": problems, "libraries": {agent: each.library for agent, each in results.items()}}
        )
    else:
        typer.echo("\n".join(describe_push(results)))
    if any(result.problem or result.library != "new" for result in results.values()):
        raise typer.Exit(1)


def _say_nobody(team: str) -> str:
    return f"No agent of team {team} is there; start them with understudy team agent, or correct [agents.network]."


@contextmanager
def _connect(file: Path) -> Iterator[tuple[LoadedTeam, ZenohNetwork]]:
    """Load a team and join its network as a visitor."""
    team = load_team_plan(file)
    with join_team(team.name, team.make_network_options()) as network:
        yield team, network


def run_agent(options: AgentOptions) -> None:
    """Run one robot or one coordinator of a team, which decides for itself."""
    until = None if options.seconds is None else REAL_TIME() + options.seconds
    with interrupt_on_termination(), ExitStack() as recording:
        recorder = None
        if options.record is not None:
            load_team_plan(
                options.file, agent=options.name, library=options.library
            )  # what is wrong is told before a file is made
            recorder = recording.enter_context(
                RunRecorder(choose_recording_path(options.record, options.name))
            )
            typer.echo(f"Recording in {recorder.path}", err=True)
        while True:
            team = load_team_plan(options.file, agent=options.name, library=options.library)
            network = ZenohNetwork(team.name, team.make_network_options(options.name))
            try:
                process = AgentProcess(options.name, team, network, record=recorder)
            except BaseException:
                network.close()
                raise
            try:
                typer.echo(f"{options.name} runs in team {team.name}. Ctrl-C stops it.", err=True)
                process.run(until=lambda: until is not None and REAL_TIME() >= until)
            finally:
                try:
                    status = process.describe()
                finally:
                    process.close()
            if not process.restarts:  # with another library
                break
        if options.as_json:
            print_json(status)
