"""Commands `understudy drive` and `understudy review`: drive a robot in the browser, and correct recordings."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import typer

from understudy.addons.bridges.environments.body_maker import find_world
from understudy.addons.recordings.drive_kit import list_drive_features, make_candidates
from understudy.addons.recordings.drive_recorder import DriveRecorder
from understudy.addons.recordings.run_drives import write_trace_drive
from understudy.clock import REAL_TIME
from understudy.errors import SettingError
from understudy.records.header import RunInfo
from understudy.records.record import find_places
from understudy.runtime.body import close_body
from understudy.sim.body_world import BodyWorld
from understudy.sim.catalog import is_function, locate_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World
from understudy.storage.atomic_write import convert_os_errors
from understudy.training.lesson_design import parse_feature
from understudy.ui.cli.commands.learn_from_drivers import group_recordings, segment_drivers
from understudy.ui.cli.commands.studio import announce_page, listen_for_page
from understudy.ui.cli.lesson_options import DriveOptions
from understudy.ui.cli.named_inputs import choose_kit, open_behavior_library
from understudy.ui.cli.options import choose_options, parse_names, parse_targets
from understudy.ui.cli.robot_connection import FOLDER, interrupt_on_termination
from understudy.ui.cli.studio_options import DrivingOptions
from understudy.ui.controller.live_drive import DriveExplanation, DrivenWorld, LiveDrive
from understudy.ui.controller.recording_review import RecordingReview
from understudy.ui.controller.stick import lay_out_stick
from understudy.ui.web.drive_app import serve_drive
from understudy.ui.web.drive_server import DriveServer
from understudy.ui.web.recording_app import serve_recording
from understudy.ui.web.views.library import check_folder

if TYPE_CHECKING:
    from understudy.model.library import Kit
    from understudy.records.record import Record
    from understudy.ui.cli.studio_options import ReviewOptions


def drive_robot(options: DrivingOptions) -> None:
    """Drive a simulated robot in the browser, with a gamepad, the mouse or the arrow keys, and learn from the drive."""
    server, files = make_drive_server(options)
    try:
        address = listen_for_page(options)
        facts = {"world": options.world_name, "library": options.library}
        show = announce_page(options, "The drive is", facts, address)
        with interrupt_on_termination():
            serve_drive(server, address, ready=show)
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

    def keep(self, drive: Record) -> None:
        """Write the last episode of a drive, again if it went on since the last time."""
        options = self._options
        with convert_os_errors(self.folder, "making the folder of recordings", remedy="give --no-record"):
            self.folder.mkdir(exist_ok=True)
        if len(self.paths) < len(drive.episodes):
            self.paths.append(self._choose_path())
        ran = RunInfo(
            scenario=locate_scenario(options.world_name),
            seed=self._world.seeds[0],
            kit=options.kit,
            library=str(options.library.resolve()),
        )
        write_trace_drive(
            self.paths[-1], drive, drive.episodes[-1],
            robot=options.agent, robots=self._world.robots, ran=ran, scenario=self._world.scenario,
        )  # fmt: skip

    def _choose_path(self) -> Path:
        """Choose a file that is not there yet, called after the world and the time."""
        world = self._options.world_name
        name = world.replace(":", "-") if is_function(world) else Path(world).stem
        stem = f"{name}-{datetime.now():%Y-%m-%dT%H-%M-%S}"
        again = (self.folder / f"{stem}{'' if number == 1 else f'-{number}'}.jsonl" for number in count(1))
        return next(place for place in again if not place.exists() and place not in self.paths)


def make_drive_server(
    options: DrivingOptions, *, wall: Callable[[], float] = REAL_TIME
) -> tuple[DriveServer, DriveFiles]:
    """Make the server of a drive in the world that the options name, and the files in which the drive is kept."""
    check_folder(options.library)
    world, kit = _open(options)
    files = DriveFiles(options, world)
    library = open_behavior_library(None, options.library, kit)
    blank = DriveRecorder(world).make_drive()
    candidates = make_candidates(library, blank, parse_names(options.behaviors))
    if not candidates:
        raise SettingError(
            where="drive",
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
        keep=None if options.no_record else files.keep,
        wall=wall,
    )
    shown = list_drive_features(library, blank)
    folder = None if options.no_record else str(files.folder)
    return DriveServer(live, kit, shown, folder=folder, wall=wall), files


def _open(options: DrivingOptions) -> tuple[DrivenWorld, Kit]:
    """Open the world and the kit of a drive."""
    opened = find_world(options.world_name)
    kit = choose_kit(options.kit, opened)
    world: DrivenWorld
    if isinstance(opened, Scenario):
        world = World(opened, [options.seed])
    else:
        world = BodyWorld(opened, options.seed, name=options.world_name)
    if options.agent >= world.robots:
        problem, remedy = f"is {options.agent}", f"count from 0 to {world.robots - 1}"
        raise SettingError(where="drive", setting="--agent", problem=problem, remedy=remedy)
    return world, kit


def review_recordings(options: ReviewOptions) -> None:
    """Review recordings of a driven robot in the browser: correct labels and boundaries, answer doubts, and learn."""
    recordings = group_recordings(options.recordings, options.driver or (), options.trust, where="review")
    drives = segment_drivers(recordings, choose_options(DriveOptions, options))
    first = next(iter(drives.values()))
    review = RecordingReview(
        {name: each.found for name, each in drives.items()},
        first.library,
        features=first.features,
        folder=options.library,
        name=options.name or "driven",
        trust=options.trust,
        targets=parse_targets(options.targets),
    )
    paths = [path for each in recordings.values() for path in each]
    found = (find_places(each.found.drive) for each in drives.values())
    known = [each for each in found if each is not None]
    places = np.concatenate(known) if len(known) == len(drives) else None
    address = listen_for_page(options)
    opened = paths[0] if len(paths) == 1 else paths
    what = "The recording is" if len(paths) == 1 else "The recordings are"
    show = announce_page(options, what, {"recording": opened, "library": options.library}, address)
    serve_recording(review, address, places=places, ready=show)
