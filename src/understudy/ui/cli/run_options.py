"""Options of runs, of what measures them, and of what explains them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from understudy.ui.cli.lesson_options import MapFile
from understudy.ui.cli.options import (
    LIBRARY,
    BehaviorName,
    Bind,
    CommandOptions,
    KitName,
    LibraryOption,
    RobotsFile,
    ScenarioOptions,
    SeedOption,
)

JSON = "json"


class RunOptions(CommandOptions):
    """Options that say what runs."""

    behavior: BehaviorName = None
    bind: Bind = None
    kit: KitName = None


class SimulatedRunOptions(ScenarioOptions, RunOptions):
    """Run a behavior in a scenario's world, on all robots that have it, and show, draw or record the run.

    Behaviors are the automata of the library, and the basic behaviors of the scenario's robots.

    [dim]understudy run --library demo/library --behavior forage --seed 7[/]

    [dim]understudy run --behavior goto --bind A=station --record goto.gif[/]

    [dim]understudy run patrol --behavior forwards --seconds 20[/]

    The automata of a squad are in a subfolder of the squad's name, and its coordinators run them. If robot types
    differ, each has a subfolder of its name, too. SORT/BEHAVIOR selects the behavior of one squad or type.

    Real robots: understudy robots run. Decide again over a recording: understudy replay.
    """

    behavior: BehaviorName = None
    library: LibraryOption = LIBRARY
    seed: SeedOption = 0
    record: Annotated[
        Path | None,
        typer.Option(
            "--record", "-r", metavar="OUT.gif|png|mcap", help="Draw or record the run instead of showing it."
        ),
    ] = None
    trace: Annotated[
        Path | None,
        typer.Option(
            "--trace", metavar="OUT.jsonl|OUT.parquet", help="Save the positions and states of the robots."
        ),
    ] = None
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds",
            min=0.1,
            max=86_400,
            help="End after this time (simulated seconds) instead of the scenario's limit.",
            show_default=False,
        ),
    ] = None
    speed: Annotated[
        float, typer.Option("--speed", min=0.1, max=1000, help="Playback speed, as a multiple of real time.")
    ] = 8.0


class RobotRunOptions(RunOptions):
    """Run a behavior on real robots. A person arms them in the terminal, and any key stops them.

    [dim]understudy robots run rover.toml --behavior servo[/]
    """

    file: RobotsFile
    behavior: BehaviorName = None
    library: LibraryOption = LIBRARY
    record: Annotated[
        str | None,
        typer.Option(
            "--record",
            "-r",
            metavar="FILE.mcap|none",
            help="File of the recording, or none; a new file beside that of the robot if left out.",
            show_default=False,
        ),
    ] = None
    seconds: Annotated[
        float | None,
        typer.Option("--seconds", min=0.1, max=86_400, help="End after this time, in s.", show_default=False),
    ] = None


class ReplayOptions(RunOptions):
    """Decide again over a recording, and show where decisions differ.

    The exit code is 1 if any differs. Over a recording of another program (CSV, bags and others), an automaton runs on
    its readings, and the ticks of the driver are counted that it repeats.

    [dim]understudy run --record run.mcap[/], then [dim]understudy replay run.mcap --library corrected[/]

    [dim]understudy replay drive.csv --map map.toml --library mine[/]
    """

    recording: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="Recording of a run, simulated or real, or of a drive.", show_default=False
        ),
    ]
    mapping: MapFile = None
    library: Annotated[
        Path | None,
        typer.Option(
            "--library", "-l", help="Folder of the library; as recorded if left out.", show_default=False
        ),
    ] = None


class EvaluateOptions(ScenarioOptions, RunOptions):
    """Evaluate a behavior in many worlds of a scenario; all its robots run it, or follow their coordinators.

    The world can be a body of your own, too, such as a Gymnasium environment; give --goal and --limit then.

    A world is a success if the behavior raises its flag done, or its only one, within the scenario's time limit. A
    behavior without such a flag has to reach the scenario's goal by then. Where there is a hand-written controller to
    compare with, as for foraging by a single robot, the limit is three times its time in the same world. --goal and
    --limit replace these. A goal that was chosen for the behavior when it was taught counts instead, unless --goal,
    --metric or --limit is given.

    With --against or --against-behavior, both are run in the same worlds, and compared pair by pair: success with
    McNemar's exact test, numbers with Wilcoxon's signed-rank test.

    [dim]understudy eval --library demo/library --behavior forage --seeds 1000:1100[/]

    [dim]understudy eval arena --library mine --behavior goto --bind A=red_flag[/]

    [dim]understudy eval cart_pole:make --behavior balance --goal truncated --limit 11[/]

    [dim]understudy eval --library mine --against demo/library --behavior forage --metric food_stored --format latex[/]
    """

    behavior: BehaviorName = None
    library: LibraryOption = LIBRARY
    seeds: Annotated[
        str,
        typer.Option("--seeds", metavar="A:B", help="Seeds of the worlds, from A up to but not including B."),
    ] = "0:100"
    goal: Annotated[
        str | None,
        typer.Option(
            "--goal",
            metavar="NAME",
            help="Flag, or reading that is yes or no, that counts as success: 'at_station'.",
            show_default=False,
        ),
    ] = None
    metric: Annotated[
        list[str] | None,
        typer.Option(
            "--metric", metavar="NAME", help="Reading to measure at the end of each world; can be repeated."
        ),
    ] = None
    limit_s: Annotated[
        float | None,
        typer.Option(
            "--limit", metavar="SECONDS", help="Time limit of each world, in simulated s.", show_default=False
        ),
    ] = None
    against: Annotated[
        Path | None,
        typer.Option(
            "--against",
            metavar="FOLDER",
            help="Library to compare with in the same worlds.",
            show_default=False,
        ),
    ] = None
    against_behavior: Annotated[
        str | None,
        typer.Option(
            "--against-behavior",
            metavar="NAME",
            help="Behavior to compare with in the same worlds; the same one if left out.",
            show_default=False,
        ),
    ] = None
    jobs: Annotated[
        int, typer.Option("--jobs", "-j", metavar="N", help="Processes to share the worlds, at most.")
    ] = 1
    each: Annotated[bool, typer.Option("--each", help="Print one row per world.")] = False
    layout: Annotated[
        str | None,
        typer.Option(
            "--format",
            metavar="FORMAT",
            help="Print json, or a table for a paper: markdown, latex or csv.",
            show_default=False,
        ),
    ] = None
    as_json: Annotated[bool, typer.Option("--json", help="Old spelling of --format json.", hidden=True)] = (
        False
    )

    @property
    def prints_json(self) -> bool:
        """Whether one JSON object is printed."""
        return self.as_json or self.layout == JSON


class WhyOptions(CommandOptions):
    """Explain what a robot did at one moment: the decision of each level, its reason, and the examples.

    For a trace, the run is simulated again up to that moment. For a recording (.mcap), of simulated or real robots,
    decisions are made again from the recorded readings. If the library has changed since, stored former versions are
    used. If none of them matches the run, the command says so and exits with code 1.

    [dim]understudy run --library demo/library --seed 7 --trace run.jsonl[/]

    [dim]understudy why run.jsonl --time 12.5[/]

    For recordings of agents (`understudy team merge`), it also explains who ordered that, when and why, from the
    recordings of their computers. Times count from the beginning of the file.

    [dim]understudy why team.mcap --agent scout_2 --time 12.5[/]
    """

    run: Annotated[
        Path,
        typer.Argument(help="Trace or recording written by `understudy run`."),
    ]
    time_s: Annotated[
        float | None,
        typer.Option("--time", "-t", min=0, help="Time of the moment, in seconds.", show_default=False),
    ] = None
    agent: Annotated[
        str,
        typer.Option(
            "--agent", "-a", help="Index of the robot, from 0; or name of an agent of a team, or of a squad."
        ),
    ] = "0"
    library: Annotated[
        Path | None,
        typer.Option(
            "--library",
            "-l",
            help="Folder of the library, if it was moved since the run.",
            show_default=False,
        ),
    ] = None
    world: Annotated[
        str | None,
        typer.Option(
            "--world", "-w", metavar="SCENARIO", help="Scenario, if its file was moved since the run."
        ),
    ] = None
    kit: KitName = None


class WorldsOptions(CommandOptions):
    """List the built-in scenarios and those of installed packages, or print the file of one to copy and change.

    Of a function MODULE:NAME that makes a body of your own, print its readings, channels and behaviors.

    [dim]understudy worlds patrol > mine.toml[/]

    [dim]understudy worlds cart_pole:make[/]
    """

    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[SCENARIO]",
            help="Print the file of this scenario, or what a body of your own (MODULE:NAME) offers.",
            show_default=False,
        ),
    ] = None


class PrepareOptions(CommandOptions):
    """Compile the learner and the kernels of scenarios ahead of time, for images and classrooms.

    Nothing needs it: kernels run as plain Python until they are compiled in the background.

    [dim]understudy prepare forage patrol[/]
    """

    scenarios: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENARIO]...",
            help="Built-in scenarios or scenario files; all built-in ones if left out.",
            show_default=False,
        ),
    ] = None
