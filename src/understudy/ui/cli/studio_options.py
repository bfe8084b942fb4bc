"""Options of the commands that serve a page: the studio, a drive, and the review of recordings."""

from __future__ import annotations

from typing import Annotated

import typer

from understudy.ui.cli.lesson_options import (
    AutomatonName,
    DriveFiles,
    DrivenBehaviors,
    DrivenFeatures,
    DriverNames,
    MapFile,
    RecordedAgent,
    RecordedTargets,
    TrustedDriver,
)
from understudy.ui.cli.options import (
    FAILURES,
    LIBRARY,
    CommandOptions,
    FailuresOption,
    KitName,
    LibraryOption,
    NoRecording,
    RobotsFile,
    ScenarioOptions,
    SeedOption,
)


class PageOptions(CommandOptions):
    """Where a page is served, who may connect, and whether a browser opens it."""

    library: LibraryOption = LIBRARY
    kit: KitName = None
    host: Annotated[
        str, typer.Option("--host", help="Address to listen on; any but this machine's own needs a token.")
    ] = "127.0.0.1"
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port, or the next free one.")] = 8437
    token: Annotated[
        str | None, typer.Option("--token", help="Token that pages need to connect; random if left out.")
    ] = None
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Do not open a browser.")] = False


class StudioOptions(ScenarioOptions, PageOptions):
    """Train a robot in the browser: the page shows the world, and you press what the robot should do.

    It works without internet. Every example is saved before it is acknowledged; after an interruption, start the
    studio again and continue.

    [dim]understudy studio forage[/]

    [dim]understudy studio cart_pole:make[/]

    Real robots: understudy robots studio. Drive a robot yourself: understudy drive.
    """

    seed: SeedOption = 0
    failures: FailuresOption = FAILURES


class RobotsStudioOptions(PageOptions):
    """Train real robots in the browser.

    If the file of a team has agents, the studio opens the running team: it shows what each agent does, and trains
    robots and coordinators over the network.

    [dim]understudy robots studio rover.toml[/]

    [dim]understudy robots studio team.toml --library library[/]
    """

    file: RobotsFile
    no_record: NoRecording = False


class DrivingOptions(ScenarioOptions, PageOptions):
    """Drive a simulated robot in the browser, with a gamepad, the mouse or the arrow keys, and learn from the drive.

    The labels appear while you drive, and you learn from them as from a recording.

    [dim]understudy drive forage --features 'distance_to(station),angle_to(station)'[/]
    """

    name: AutomatonName = None
    behaviors: DrivenBehaviors = None
    features: DrivenFeatures = None
    agent: RecordedAgent = 0
    seed: SeedOption = 0
    no_record: Annotated[bool, typer.Option("--no-record", help="Do not record the drive.")] = False


class ReviewOptions(PageOptions):
    """Review recordings of a driven robot in the browser: correct labels and boundaries, answer doubts, and learn.

    The page shows a timeline with the behavior of each span, commands and readings. Of several drivers it also shows
    where they contradict each other, and you say who is right.

    [dim]understudy review drive.csv --map map.toml --features 'range(ball)'[/]

    [dim]understudy review anna.csv ben.csv --map map.toml[/]
    """

    recordings: DriveFiles
    driver: DriverNames = None
    trust: TrustedDriver = None
    mapping: MapFile = None
    name: AutomatonName = None
    behaviors: DrivenBehaviors = None
    features: DrivenFeatures = None
    targets: RecordedTargets = None
    agent: RecordedAgent = 0
