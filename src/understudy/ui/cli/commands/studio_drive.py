"""Mode `understudy studio --drive`: drive a simulated robot in the browser, and learn from the drive."""

from __future__ import annotations

from datetime import datetime
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import typer

from understudy.clock import REAL_TIME
from understudy.errors import SettingError
from understudy.ui.cli.robot_options import FOLDER

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from understudy.model.library import Kit
    from understudy.segmentation.recorded_drive import RecordedDrive
    from understudy.ui.controller.live_drive import DrivenWorld
    from understudy.ui.web.access import ListenAddress
    from understudy.ui.web.drive_server import DriveServer


class DrivingOptions(NamedTuple):
    """Options of a drive in the studio; None for those that were not given."""

    world: str
    seed: int
    library: Path
    kit: str | None
    name: str | None
    behaviors: str | None
    features: str | None
    agent: int
    kept: bool


def drive_in_studio(
    options: DrivingOptions,
    listen: Callable[[], ListenAddress],
    show: Callable[[str], None],
    *,
    as_json: bool,
) -> None:
    """Serve the page on which a person drives a robot, until a signal ends it; `show` opens it in the browser."""
    from understudy.runtime.body import close_body
    from understudy.ui.cli.output import print_json
    from understudy.ui.cli.robot_options import interrupt_on_termination
    from understudy.ui.web.drive_app import serve_drive

    server, files = make_drive_server(options)
    try:
        address = listen()
        if as_json:
            print_json({"world": options.world, "library": options.library, "link": address.link})
        else:
            typer.echo(f"The drive is at {address.link}  (Ctrl C ends it)")
        with interrupt_on_termination():
            serve_drive(server, address, ready=lambda: show(address.link))
    finally:
        close_body(server.live.world)
        for path in files.paths:
            typer.echo(f"Recorded in {path}", err=True)


class DriveFiles:
    """The files in which a drive is kept, one trace for each of its worlds."""

    def __init__(self, options: DrivingOptions, world: DrivenWorld) -> None:
        self.folder = options.library.parent / FOLDER
        self.paths: list[Path] = []
        self._options, self._world = options, world

    def keep(self, drive: RecordedDrive, poses: NDArray[np.float64]) -> None:
        """Write the last episode of a drive, again if it went on since the last time."""
        from understudy.data.trace_drive import write_trace_drive
        from understudy.robots.recording.header import RunInfo
        from understudy.sim.catalog import locate_scenario
        from understudy.storage.atomic_write import convert_os_errors

        options = self._options
        with convert_os_errors(self.folder, "making the folder of recordings", remedy="give --no-record"):
            self.folder.mkdir(exist_ok=True)
        if len(self.paths) < len(drive.episodes):
            self.paths.append(self._choose_path())
        ran = RunInfo(
            scenario=locate_scenario(options.world),
            seed=self._world.seeds[0],
            kit=options.kit,
            library=str(options.library.resolve()),
        )
        write_trace_drive(
            self.paths[-1], drive, drive.episodes[-1], poses,
            robot=options.agent, robots=self._world.robots, ran=ran, scenario=self._world.scenario,
        )  # fmt: skip

    def _choose_path(self) -> Path:
        """Choose a file that is not there yet, called after the world and the time."""
        from understudy.sim.catalog import is_function

        world = self._options.world
        name = world.replace(":", "-") if is_function(world) else Path(world).stem
        stem = f"{name}-{datetime.now():%Y-%m-%dT%H-%M-%S}"
        again = (self.folder / f"{stem}{'' if number == 1 else f'-{number}'}.jsonl" for number in count(1))
        return next(place for place in again if not place.exists() and place not in self.paths)


def make_drive_server(
    options: DrivingOptions, *, wall: Callable[[], float] = REAL_TIME
) -> tuple[DriveServer, DriveFiles]:
    """Make the server of a drive in the world that the options name, and the files in which the drive is kept."""
    from understudy.segmentation.drive_kit import list_drive_features, make_candidates
    from understudy.segmentation.drive_recorder import DriveRecorder
    from understudy.training.lesson_design import parse_feature
    from understudy.ui.cli.options import open_behavior_library, parse_names
    from understudy.ui.controller.live_drive import DriveExplanation, LiveDrive
    from understudy.ui.controller.recording_review import RecordingReview
    from understudy.ui.controller.stick import lay_out_stick
    from understudy.ui.web.drive_server import DriveServer
    from understudy.ui.web.views.library import check_folder

    check_folder(options.library)
    world, kit = _open(options)
    files = DriveFiles(options, world)
    library = open_behavior_library(None, options.library, kit)
    blank = DriveRecorder(world).make_drive()
    candidates = make_candidates(library, blank, parse_names(options.behaviors))
    if not candidates:
        raise SettingError(
            where="studio",
            setting="--behaviors",
            problem="are none that could explain a drive",
            remedy="give --kit MODULE:NAME with your own",
        )
    names = parse_names(options.features)
    features = None if names is None else [parse_feature(library, each) for each in names]
    live = LiveDrive(
        world,
        lay_out_stick(world.channels, kit.behaviors),
        # The readings say nothing about features of the automaton itself, such as the time in a state.
        DriveExplanation(candidates, [each for each in features or () if not each.is_own]),
        lambda found: RecordingReview(
            found, library, features=features, folder=options.library, name=options.name or "driven"
        ),
        agent=options.agent,
        keep=files.keep if options.kept else None,
        wall=wall,
    )
    shown = list_drive_features(library, blank)
    folder = str(files.folder) if options.kept else None
    return DriveServer(live, kit, shown, folder=folder, wall=wall), files


def _open(options: DrivingOptions) -> tuple[DrivenWorld, Kit]:
    """Open the world and the kit of a drive."""
    from understudy.sim.body_world import BodyWorld
    from understudy.sim.scenario.schema import Scenario
    from understudy.sim.world import World
    from understudy.ui.cli.options import find_kit, make_world_kit, open_world

    opened = open_world(options.world)
    kit = make_world_kit(opened) if options.kit is None else find_kit(options.kit, options.world)
    world: DrivenWorld
    if isinstance(opened, Scenario):
        world = World(opened, [options.seed])
    else:
        world = BodyWorld(opened, options.seed, name=options.world)
    if options.agent >= world.robots:
        problem, remedy = f"is {options.agent}", f"count from 0 to {world.robots - 1}"
        raise SettingError(where="studio", setting="--agent", problem=problem, remedy=remedy)
    return world, kit
