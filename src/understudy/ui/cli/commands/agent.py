"""Command `understudy agent`: run one member of a team in this process, on whatever computer that is."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from understudy.clock import REAL_TIME
from understudy.ui.cli.options import Json

TeamFileArgument = Annotated[
    Path, typer.Argument(metavar="TEAM", help="File of the team.", show_default=False)
]


def run_agent(
    file: TeamFileArgument,
    name: Annotated[
        str, typer.Option("--name", help="Name of the agent: of a robot, or of a squad.", show_default=False)
    ],
    library: Annotated[
        Path | None,
        typer.Option(help="Folder of the automata. By default as the team's file says.", show_default=False),
    ] = None,
    seconds: Annotated[
        float | None, typer.Option(help="Leave after so many seconds.", show_default=False, min=0.0)
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(
            help="Record all messages and decisions in a new file FILE.mcap, or in one in this folder.",
            show_default=False,
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Run one robot or one coordinator of a team, which decides for itself.

    Robots move once a person has armed them: understudy team arm.

    [dim]understudy agent team.toml --name scout_2[/]
    """
    from contextlib import ExitStack

    from understudy.robots.recording.recorder import RunRecorder
    from understudy.robots.team_network.agent_process import AgentProcess
    from understudy.robots.team_network.load_plan import load_team_plan
    from understudy.robots.team_network.zenoh_network import ZenohNetwork
    from understudy.ui.cli.output import print_json
    from understudy.ui.cli.robot_options import choose_recording_path, interrupt_on_termination

    until = None if seconds is None else REAL_TIME() + seconds
    with interrupt_on_termination(), ExitStack() as recording:
        recorder = None
        if record is not None:
            load_team_plan(file, agent=name, library=library)  # what is wrong is told before a file is made
            recorder = recording.enter_context(RunRecorder(choose_recording_path(record, name)))
            typer.echo(f"Recording in {recorder.path}", err=True)
        while True:
            team = load_team_plan(file, agent=name, library=library)
            network = ZenohNetwork(team.name, team.make_network_options(name))
            try:
                process = AgentProcess(name, team, network, record=recorder)
            except BaseException:
                network.close()
                raise
            try:
                typer.echo(f"{name} runs in team {team.name}. Ctrl-C stops it.", err=True)
                process.run(until=lambda: until is not None and REAL_TIME() >= until)
            finally:
                try:
                    status = process.describe()
                finally:
                    process.close()
            if not process.restarts:  # with another library
                break
        if as_json:
            print_json(status)
