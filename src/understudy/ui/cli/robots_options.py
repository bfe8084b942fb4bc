"""Options of the commands for real and simulated robots, and for teams whose agents run apart."""

from __future__ import annotations

from math import inf
from pathlib import Path
from typing import Annotated

import typer

from understudy.ui.cli.options import CommandOptions, RobotsFile


class RobotsCheckOptions(CommandOptions):
    """Connect to robots and show which readings arrive, their rate and age, and what is missing.

    No robot moves. The exit code is 1 if there is a problem.

    [dim]understudy robots check rover.toml[/]
    """

    file: RobotsFile
    seconds: Annotated[float, typer.Option(help="Time to listen, in seconds.", min=0.1, max=600.0)] = 3.0


class RobotsStopOptions(CommandOptions):
    """Stop a robot or a team, whatever program is driving it.

    The stop command is sent for two seconds, and an Understudy program that drives the robot is disarmed. The exit
    code is 1 if no message came from a robot.

    [dim]understudy robots stop rover.toml[/]
    """

    file: RobotsFile


class RobotStopsOptions(CommandOptions):
    """Show when and why a robot stopped itself or was stopped.

    [dim]understudy robots stops rover.toml[/]
    """

    file: Annotated[Path, typer.Argument(metavar="FILE", help="File of the robot.", show_default=False)]
    last: Annotated[int, typer.Option(help="Number of stops to show, newest last.", min=1)] = 20


class RobotColorOptions(CommandOptions):
    """Find the color by which a robot's camera detects an object, from images of it.

    The object has to fill the middle of each image. Alternatively, ball1.png can have a mask beside it,
    ball1.mask.png, which is white where the object is. With masks, the color range is made narrow enough to exclude
    the rest of the images. Take the images with the robot's own camera, in every lighting that will occur.

    [dim]understudy robots color images/ball --name ball --robot rover.toml[/]
    """

    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Folder with images of the object, PNG or JPEG.")
    ]
    name: Annotated[
        str, typer.Option("--name", "-n", help="Name of the target that has this color, such as ball.")
    ]
    robot: Annotated[
        Path | None, typer.Option("--robot", metavar="FILE", help="Write the color into this robot's file.")
    ] = None


class RobotLayoutOptions(CommandOptions):
    """Print a layout for Foxglove: the path, states, stops and diagnostics of a robot or of a team.

    Write it to a file and import that in Foxglove: Layouts > Import from file. It is JSON, with `--json` in one line.

    [dim]understudy robots layout rover.toml > rover.foxglove.json[/]
    """

    file: RobotsFile


class SimulateOptions(CommandOptions):
    """Simulate the robots of a world with physics (MuJoCo), each as a ROS 2 robot in its own namespace.

    They publish Range, LaserScan, Odometry, Image and positions of targets, and obey Twist. They stop after 0.15 s
    without a command.

    [dim]understudy robots simulate soccer --write-files .[/]
    """

    world: Annotated[str, typer.Argument(metavar="WORLD", help="A built-in scenario, or a scenario file.")]
    seed: Annotated[int, typer.Option(help="Seed of the initial positions.", min=0, max=2**63 - 1)] = 0
    domain: Annotated[int, typer.Option(help="ROS 2 domain (ROS_DOMAIN_ID).", min=0, max=232)] = 0
    rate: Annotated[
        float,
        typer.Option(metavar="HZ", help="Simulation ticks, and so messages, per second.", min=5.0, max=100.0),
    ] = 20.0
    router: Annotated[
        str | None, typer.Option(metavar="ENDPOINT", help="Use Zenoh through this router instead of DDS.")
    ] = None
    write_files: Annotated[
        Path | None,
        typer.Option("--write-files", metavar="DIR", help="Write the robots' files to this folder first."),
    ] = None
    apart: Annotated[bool, typer.Option("--apart", help="Run each robot in its own process.")] = False
    only: Annotated[
        str | None,
        typer.Option("--only", metavar="NAME", help="Run only this robot, or only the referee.", hidden=True),
    ] = None
    parent: Annotated[
        int, typer.Option("--parent", metavar="PID", help="Process that started this one.", hidden=True)
    ] = 0
    seconds: Annotated[
        float, typer.Option(help="End after this many seconds; run until Ctrl-C if left out.", min=0.1)
    ] = inf


class TeamOptions(CommandOptions):
    """The team that a command is for."""

    file: Annotated[Path, typer.Argument(metavar="TEAM", help="File of the team.", show_default=False)]


class TeamAgentOptions(TeamOptions):
    """The agents of a team that a command is for."""

    name: Annotated[
        str, typer.Option("--name", help="Name of one agent. By default all.", show_default=False)
    ] = "*"


class AgentOptions(TeamOptions):
    """Run one robot or one coordinator of a team, which decides for itself.

    Robots move once a person has armed them: understudy team arm.

    [dim]understudy team agent team.toml --name scout_2[/]
    """

    name: Annotated[
        str, typer.Option("--name", help="Name of the agent: of a robot, or of a squad.", show_default=False)
    ]
    library: Annotated[
        Path | None,
        typer.Option(
            "--library",
            "-l",
            help="Folder of the automata. By default as the team's file says.",
            show_default=False,
        ),
    ] = None
    seconds: Annotated[
        float | None, typer.Option(help="Leave after so many seconds.", show_default=False, min=0.0)
    ] = None
    record: Annotated[
        Path | None,
        typer.Option(
            help="Record all messages and decisions in a new file FILE.mcap, or in one in this folder.",
            show_default=False,
        ),
    ] = None


class TeamStatusOptions(TeamOptions):
    """Show what each agent does, on whose order, and which are missing.

    The exit code is 1 if an agent is missing.

    [dim]understudy team status team.toml[/]
    """


class TeamArmOptions(TeamAgentOptions):
    """Let the robots of a team move. A person confirms it in the terminal.

    [dim]understudy team arm team.toml[/]
    """


class TeamStopOptions(TeamAgentOptions):
    """Stop and disarm the robots of a team at once.

    The exit code is 1 if a robot's agent did not answer: look whether the robot stands.

    [dim]understudy team stop team.toml[/]
    """


class TeamLogsOptions(TeamAgentOptions):
    """Show what happened to each agent: orders, leaders, stops.

    The exit code is 1 if no agent answers.

    [dim]understudy team logs team.toml --name scout_2[/]
    """


class TeamPushOptions(TeamOptions):
    """Hand a library to all agents of a team: all take it over and keep the former one, or all go back to it.

    The robots must be disarmed. The exit code is 1 if an agent is missing, refuses, or does not answer; then the output
    says which library each agent has.

    [dim]understudy team push team.toml --library library[/]
    """

    library: Annotated[
        Path | None,
        typer.Option(
            "--library",
            "-l",
            help="Folder of the automata. By default as the team's file says.",
            show_default=False,
        ),
    ] = None


class TeamMergeOptions(CommandOptions):
    """Merge the recordings of a team's agents into one file with one clock.

    The computers need no common clock: how far each is ahead is found from the messages that they exchanged. The
    largest error of each is printed, and stored in the file.

    [dim]understudy team merge team.mcap patrol_0.mcap scout_1.mcap scout_2.mcap[/]

    [dim]understudy why team.mcap --agent scout_2 --time 12.5[/]
    """

    out: Annotated[Path, typer.Argument(metavar="OUT", help="The new file.", show_default=False)]
    recordings: Annotated[
        list[Path],
        typer.Argument(
            metavar="RECORDING...", help="Recordings of agents, from their computers.", show_default=False
        ),
    ]
    reference: Annotated[
        str | None,
        typer.Option(
            help="Agent whose clock the new file has. By default that of the first recording.",
            show_default=False,
        ),
    ] = None
