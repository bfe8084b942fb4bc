"""Command `understudy studio`: train a robot in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.errors import SettingError
from understudy.ui.cli.options import (
    FAILURES,
    LIBRARY,
    FailuresOption,
    Json,
    KitName,
    LibraryOption,
    SameWorld,
    ScenarioName,
)
from understudy.ui.cli.recording_options import (
    DrivenBehaviors,
    DrivenFeatures,
    DriverNames,
    MapFile,
    RecordedAgent,
    RecordedTargets,
    TrustedDriver,
)
from understudy.ui.cli.robot_options import RobotFileOption, TeamFileOption, connect_twin
from understudy.ui.cli.robot_options import find_robots_file as real

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from understudy.robots.twin import Ground
    from understudy.ui.cli.commands.learn_from_drive import DriveOptions
    from understudy.ui.web.access import ListenAddress


def start_studio(
    scenario: ScenarioName = None,
    world: SameWorld = None,
    library: LibraryOption = LIBRARY,
    kit: KitName = None,
    host: Annotated[
        str,
        typer.Option("--host", help="Address to listen on; any but this machine's own needs a token."),
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port, or the next free one.")] = 8437,
    token: Annotated[
        str | None, typer.Option("--token", help="Token that pages need to connect; random if left out.")
    ] = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Do not open a browser.")] = False,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the world.")] = 0,
    failures: FailuresOption = FAILURES,
    robot: RobotFileOption = None,
    team: TeamFileOption = None,
    no_record: Annotated[
        bool, typer.Option("--no-record", help="Do not record the messages of real robots, nor drives.")
    ] = False,
    recording: Annotated[
        list[Path] | None,
        typer.Option(
            "--recording",
            metavar="FILE",
            help="Recording without presses, to review its labels; may be repeated.",
        ),
    ] = None,
    driver: DriverNames = None,
    trust: TrustedDriver = None,
    mapping: MapFile = None,
    name: Annotated[
        str | None, typer.Option("--name", "-n", metavar="NAME", help="Name of the recording's automaton.")
    ] = None,
    behaviors: DrivenBehaviors = None,
    features: DrivenFeatures = None,
    targets: RecordedTargets = None,
    agent: RecordedAgent = 0,
    drive: Annotated[
        bool, typer.Option("--drive", help="Drive the robot with a stick, and learn from the drive.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Train a robot in the browser: the page shows the world, and you press what the robot should do.

    It works without internet. Every example is saved before it is acknowledged; after an interruption, start the
    studio again and continue.

    [dim]understudy studio forage[/]

    [dim]understudy studio --world cart_pole:make[/]

    [dim]understudy studio --robot rover.toml[/]

    If the file of a team has agents, the studio opens the running team: it shows what each agent does, and trains
    robots and coordinators over the network.

    [dim]understudy studio --team team.toml --library library[/]

    With --recording it shows a recording of a driven robot on a timeline: the behavior of each span, commands and
    readings. You correct labels and boundaries, answer what is in doubt, and learn.

    [dim]understudy studio --recording drive.csv --map map.toml --features 'range(ball)'[/]

    Of several drivers it also shows where they contradict each other, and you say who is right.

    [dim]understudy studio --recording anna.csv --recording ben.csv --map map.toml[/]

    With --drive you drive a simulated robot yourself, with a gamepad, the mouse or the arrow keys: the labels appear
    while you drive, and you learn from them as from a recording.

    [dim]understudy studio forage --drive --features 'distance_to(station),angle_to(station)'[/]
    """
    from contextlib import ExitStack, closing

    from understudy.sim.body_world import BodyWorld
    from understudy.sim.kit import make_scenario_kit
    from understudy.sim.scenario.schema import Scenario
    from understudy.ui.cli.commands.learn_from_drive import DriveOptions
    from understudy.ui.cli.commands.learn_from_drivers import group_recordings
    from understudy.ui.cli.commands.studio_drive import DrivingOptions, drive_in_studio
    from understudy.ui.cli.options import (
        choose_scenario_name,
        find_kit,
        make_world_kit,
        open_world,
        parse_targets,
    )
    from understudy.ui.cli.output import print_json
    from understudy.ui.cli.running_team import has_agents, watch_team
    from understudy.ui.web.access import listen
    from understudy.ui.web.app import serve
    from understudy.ui.web.server import StudioServer
    from understudy.ui.web.session_host import SessionHost
    from understudy.ui.web.views.library import check_folder

    if recording:
        if real(robot, team, world=scenario or world) is not None or scenario or world or drive:
            problem, remedy = "is given beside a world or a robot", "name one of them"
            raise SettingError(where="studio", setting="--recording", problem=problem, remedy=remedy)
        options = DriveOptions(
            name,
            library,
            mapping,
            behaviors,
            features,
            None,
            kit,
            agent,
            targets=parse_targets(targets),
        )
        grouped = group_recordings(recording, driver or (), trust, where="studio")
        address = listen(host, port, token)
        _review_recordings(grouped, options, trust, address, quiet=no_browser, as_json=as_json)
        return
    for option, given in (
        ("--map", mapping),
        ("--driver", driver or None),
        ("--trust", trust),
        ("--targets", targets),
    ):
        if given is not None:
            raise _without_recording(option, "give --recording FILE")
    if drive:
        if real(robot, team, world=scenario or world) is not None:
            problem, remedy = "is given for real robots", "name a simulated world"
            raise SettingError(where="studio", setting="--drive", problem=problem, remedy=remedy)
        named = choose_scenario_name(scenario, world)
        driven = DrivingOptions(
            named, seed, library, kit, name, behaviors, features, agent, kept=not no_record
        )
        drive_in_studio(
            driven,
            lambda: listen(host, port, token),
            (lambda _: None) if no_browser else _open,
            as_json=as_json,
        )
        return
    for option, value in (("--name", name), ("--behaviors", behaviors), ("--features", features)):
        if value is not None:
            raise _without_recording(option, "give --recording FILE or --drive")
    with ExitStack() as leaving:
        watch = None
        if real(robot, team, world=scenario or world) is None:
            name = choose_scenario_name(scenario, world)
            opened = open_world(name)
            parts = make_world_kit(opened) if kit is None else find_kit(kit, name)
            ground: Ground | None = None
            if isinstance(opened, Scenario):
                found = opened
            else:
                ground = leaving.enter_context(closing(BodyWorld(opened, seed, name=name)))
                found = ground.scenario
        elif team is not None and has_agents(team):
            watch, twin = leaving.enter_context(watch_team(team))
            ground, found = twin, twin.scenario
            parts = make_scenario_kit(found) if kit is None else find_kit(kit, found.name)
        else:
            twin = leaving.enter_context(connect_twin(robot, team, record=None, recorded=not no_record))
            ground, found = twin, twin.scenario
            parts = make_scenario_kit(found) if kit is None else find_kit(kit, found.name)
        check_folder(library)
        address = listen(host, port, token)
        session_host = SessionHost(found, library, parts, seed=seed, ground=ground, failures=failures)
        if as_json:
            print_json({"world": found.name, "library": library, "link": address.link})
        else:
            typer.echo(f"The studio is at {address.link}  (Ctrl C ends it)")

        def ready() -> None:
            if not no_browser:
                _open(address.link)

        serve(StudioServer(session_host, watch=watch), address, ready=ready)


def _without_recording(option: str, remedy: str) -> SettingError:
    problem = "is given without a recording"
    return SettingError(where="studio", setting=option, problem=problem, remedy=f"{remedy}, or leave it out")


def _review_recordings(
    recordings: Mapping[str, Sequence[Path]],
    options: DriveOptions,
    trust: str | None,
    address: ListenAddress,
    *,
    quiet: bool,
    as_json: bool,
) -> None:
    """Segment the recordings of each driver, and serve the page on which they are reviewed."""
    import numpy as np

    from understudy.ui.cli.commands.learn_from_drivers import segment_drivers
    from understudy.ui.cli.output import print_json
    from understudy.ui.controller.recording_review import RecordingReview
    from understudy.ui.web.recording_app import serve_recording

    drives = segment_drivers(recordings, options)
    first = next(iter(drives.values()))
    review = RecordingReview(
        {name: each.found for name, each in drives.items()},
        first.library,
        features=first.features,
        folder=options.library or LIBRARY,
        name=options.name or "driven",
        trust=trust,
        targets=options.targets,
    )
    paths = [path for each in recordings.values() for path in each]
    known = [each.places for each in drives.values() if each.places is not None]
    places = np.concatenate(known) if len(known) == len(drives) else None
    if as_json:
        opened = paths[0] if len(paths) == 1 else paths
        print_json({"recording": opened, "library": options.library, "link": address.link})
    else:
        what = "recording is" if len(paths) == 1 else "recordings are"
        typer.echo(f"The {what} at {address.link}  (Ctrl C ends it)")

    def ready() -> None:
        if not quiet:
            _open(address.link)

    serve_recording(review, address, places=places, ready=ready)


def _open(link: str) -> None:
    """Open the page in the browser, in a thread; the socket already listens, so the page waits to be served."""
    import webbrowser
    from contextlib import suppress
    from threading import Thread

    def look() -> None:
        with suppress(webbrowser.Error, OSError):
            webbrowser.open(link)

    Thread(target=look, daemon=True).start()
