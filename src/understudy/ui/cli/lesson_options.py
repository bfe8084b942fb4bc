"""Options of the commands that teach in the terminal, and of those that learn from tables and recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from understudy.errors import SettingError
from understudy.ui.cli.options import (
    FAILURES,
    LIBRARY,
    WORLD,
    CommandOptions,
    FailuresOption,
    KitName,
    LibraryOption,
    NoRecording,
    SeedOption,
)

DriverNames: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--driver",
        metavar="NAME",
        help="Name of the driver of each recording, in their order; those of their files if left out.",
    ),
]
TrustedDriver: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--trust",
        metavar="NAME",
        help="Driver who is right where drivers contradict each other: such examples of others are left out.",
    ),
]
MapFile: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--map",
        metavar="MAP.toml",
        help="Which columns, or fields of messages, of a recording are readings and commands: a mapping file, or the "
        "file of the robot.",
    ),
]
DrivenBehaviors: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--behaviors",
        metavar="A,B(C)",
        help="Behaviors and automata that may explain the commands of a recording without presses.",
    ),
]
DrivenFeatures: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--features",
        metavar="A,B(C)",
        help="Features that decisions depend on, also 'A / B' and 'A - B'; those of a drive also help to find when its "
        "driver switched.",
    ),
]
RecordedTargets: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--targets",
        metavar="A=TARGET",
        help="Targets of the parameters during the recording; a drive to them teaches to drive to any.",
    ),
]
RecordedAgent: TypeAlias = Annotated[
    int, typer.Option("--agent", "-a", min=0, help="Index of the robot in the recording, from 0.")
]
DriveFiles: TypeAlias = Annotated[
    list[Path],
    typer.Argument(
        metavar="FILE...",
        help="Drives: CSV, JSON lines, Parquet or MCAP, with --map also bags of ROS. Several make one lesson.",
        show_default=False,
    ),
]
AutomatonName: TypeAlias = Annotated[str | None, typer.Option("--name", "-n", help="Name of the automaton.")]
LessonFlags: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--flags", metavar="A,B", help="Flags it can raise; done and failed, if shown, if left out."
    ),
]
LessonParameters: TypeAlias = Annotated[
    str | None, typer.Option("--parameters", metavar="A,B", help="Parameters, to be bound to targets later.")
]
Reaction: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--reaction",
        min=0.0,
        max=1.0,
        metavar="SECONDS",
        help="Reaction time by which presses are shifted earlier.",
    ),
]
PressesFile: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--presses",
        metavar="FILE.csv",
        help="Presses as a table time_s,state; those in the recording if left out.",
    ),
]
PressedStates: TypeAlias = Annotated[
    str | None,
    typer.Option("--states", metavar="A,B(C)", help="States of the automaton; those pressed if left out."),
]
SessionNumber: TypeAlias = Annotated[
    int | None,
    typer.Option(
        "--session", min=1, help="Number of the session in the recording, from 1; the last if left out."
    ),
]


class LessonOptions(CommandOptions):
    """What is taught in the terminal; None for what the program asks."""

    name: Annotated[
        str, typer.Argument(help="Name of the automaton; new, or in the library to continue its lesson.")
    ]
    library: LibraryOption = LIBRARY
    states: Annotated[
        str | None,
        typer.Option(
            "--states", metavar="A,B(C)", help="States: basic behaviors and automata of the library."
        ),
    ] = None
    features: Annotated[
        str | None, typer.Option("--features", metavar="A,B(C)", help="Features that decisions depend on.")
    ] = None
    parameters: LessonParameters = None
    targets: Annotated[
        str | None,
        typer.Option("--targets", metavar="A=TARGET", help="Targets of the parameters during teaching."),
    ] = None
    flags: Annotated[
        str | None, typer.Option("--flags", metavar="A,B", help="Flags it can raise, such as done.")
    ] = None
    watched: Annotated[
        bool | None,
        typer.Option(
            "--watched/--plain",
            help="Learn from silence or not; as in the existing lesson, or not, if left out.",
        ),
    ] = None
    reaction: Reaction = None
    kit: KitName = None


class TeachOptions(LessonOptions):
    """Teach a robot with the keyboard: drive it by pressing behaviors, and it learns when to switch.

    The program asks for everything that is not chosen here. It works over SSH; after a lost connection, the same
    command continues the session.

    [dim]understudy teach goto --parameters A --states forward,rotate_left,rotate_right --flags done --features
    'distance_to(A),angle_to(A)' --targets A=station[/]

    [dim]understudy teach balance --world cart_pole:make[/]

    Real robots: understudy robots teach.
    """

    world: Annotated[
        str | None,
        typer.Option(
            "--world",
            "-w",
            metavar="SCENARIO",
            help=f"Scenario to teach in; {WORLD} if left out.",
            show_default=False,
        ),
    ] = None
    seed: SeedOption = 0
    failures: FailuresOption = FAILURES


class RobotTeachOptions(LessonOptions):
    """Teach a real robot with the keyboard, as understudy teach does in a simulated world.

    [dim]understudy robots teach rover.toml servo[/]
    """

    file: Annotated[Path, typer.Argument(metavar="FILE", help="File of the robot.", show_default=False)]
    no_record: NoRecording = False


class LearnOptions(CommandOptions):
    """What is done with what is learned from a table or a recording."""

    predict: Annotated[
        Path | None,
        typer.Option(
            "--predict", metavar="ROWS.csv", help="Predict the next state for each row of this table."
        ),
    ] = None
    library: Annotated[
        Path | None, typer.Option("--library", "-l", help="Save the automaton to this folder; needs --name.")
    ] = None
    name: AutomatonName = None

    def check_name(self) -> None:
        """Refuse a library without a name, and a name without a library.

        No name is assumed: saving would replace an automaton of that name, which may be another one.
        """
        if (self.library is None) == (self.name is None):
            return
        if self.name is None:
            missing = "--name"
            remedy = f"give the name to save the automaton under in {self.library}, such as --name driven"
        else:
            missing = "--library"
            remedy = f"give the folder of the library to save {self.name!r} in, such as --library library"
        raise SettingError(where="learn", setting=missing, problem="is missing", remedy=remedy)


class LearnTableOptions(LearnOptions):
    """Learn an automaton's transition functions from a table of examples.

    Columns are state, next, kind (directive, default, confirmation or watched), and one for each feature. The header
    of a feature includes its kind: distance:continuous, bearing:toroidal(6.283185307179586),
    ready:categorical(no|yes). An empty cell is an absent reading.

    [dim]understudy learn table lesson.csv --predict rows.csv --json[/]
    """

    table: Annotated[
        Path, typer.Argument(metavar="LESSON.csv", help="Table of examples.", show_default=False)
    ]
    flags: LessonFlags = None


class LearnRecordingOptions(LearnOptions):
    """Learn from a recording and presses, which have the same effect as in a session: a directive and a default each.

    An automaton that the library has already is taught on.

    [dim]understudy learn recording drive.mcap --presses presses.csv --features 'distance_to(station)'[/]
    """

    recording: Annotated[
        Path, typer.Argument(metavar="FILE.mcap", help="Recording of `understudy run`.", show_default=False)
    ]
    presses: PressesFile = None
    states: PressedStates = None
    features: DrivenFeatures = None
    flags: LessonFlags = None
    parameters: LessonParameters = None
    targets: RecordedTargets = None
    reaction: Reaction = None
    agent: RecordedAgent = 0
    session: SessionNumber = None
    kit: KitName = None


class DriveOptions(LearnOptions):
    """What a drive is, and what may explain it; None for what was not given."""

    mapping: MapFile = None
    behaviors: DrivenBehaviors = None
    define: Annotated[
        list[str] | None,
        typer.Option(
            "--define",
            metavar="'NAME: CHANNEL VALUE, ...'",
            help="A behavior that may explain a recording, by its constant commands; may be repeated.",
        ),
    ] = None
    split: Annotated[
        list[str] | None,
        typer.Option(
            "--split",
            metavar="'STATE after STATE'",
            help="Give a state of its own to where a state follows certain others; may be repeated.",
        ),
    ] = None
    features: DrivenFeatures = None
    targets: RecordedTargets = None
    reaction: Reaction = None
    agent: RecordedAgent = 0
    kit: KitName = None


class LearnDriveOptions(DriveOptions):
    """Learn from recordings of a person who drove: the commands say which behavior was meant at each tick.

    [dim]understudy learn drive drive.csv --map map.toml --behaviors forward,left,right[/]
    """

    recordings: DriveFiles
    driver: Annotated[
        str, typer.Option("--driver", metavar="NAME", help="Name of the driver.", show_default=False)
    ] = ""
    pairs: Annotated[
        bool,
        typer.Option(
            "--pairs/--no-pairs",
            help="Take quotients and differences of readings as features where more is repeated of drives left out.",
        ),
    ] = True


class LearnDriversOptions(DriveOptions):
    """Learn one lesson from drives of several people: it says who showed what, and where they contradict each other.

    [dim]understudy learn drivers anna.csv ben.csv --map map.toml --trust anna[/]
    """

    recordings: DriveFiles
    driver: DriverNames = None
    trust: TrustedDriver = None
