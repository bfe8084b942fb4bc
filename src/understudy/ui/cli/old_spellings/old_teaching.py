"""Old spellings of commands that teach: `learn`, `teach --robot`, and `studio` with a robot, a recording or a drive."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from understudy.errors import SettingError
from understudy.records.trace_reader import is_trace
from understudy.ui.cli.commands.learn_from_drive import learn_drive
from understudy.ui.cli.commands.learn_from_drivers import group_recordings, learn_drivers
from understudy.ui.cli.commands.learn_from_recording import learn_recording
from understudy.ui.cli.commands.learn_table import learn_table
from understudy.ui.cli.commands.studio import serve_robots_studio, start_studio
from understudy.ui.cli.commands.studio_drive import drive_robot, review_recordings
from understudy.ui.cli.commands.teach import teach, teach_on_robot
from understudy.ui.cli.lesson_options import (
    DriveOptions,
    DriverNames,
    LearnDriveOptions,
    LearnDriversOptions,
    LearnRecordingOptions,
    LearnTableOptions,
    LessonFlags,
    LessonParameters,
    MapFile,
    PressedStates,
    PressesFile,
    RecordedTargets,
    RobotTeachOptions,
    SessionNumber,
    TeachOptions,
    TrustedDriver,
)
from understudy.ui.cli.old_spellings import OldOptions, RecordingOption, RobotFileOption, TeamFileOption
from understudy.ui.cli.options import NoRecording, choose_options
from understudy.ui.cli.robot_connection import find_robots_file
from understudy.ui.cli.studio_options import DrivingOptions, ReviewOptions, StudioOptions

OF_RECORDINGS = (
    "presses", "states", "features", "parameters", "targets", "reaction", "agent", "session", "kit", "mapping",
    "behaviors", "define", "split", "driver", "trust",
)  # fmt: skip
"""Options that only apply to recordings."""
OF_PRESSES = ("presses", "states", "flags", "parameters", "session")
"""Options that only apply to recordings with presses; traces have several robots, too."""
OF_REVIEWS = ("mapping", "driver", "trust", "targets")
"""Options that only apply to recordings."""
OF_DRIVES = ("name", "behaviors", "features")
"""Options that apply to recordings and to a drive."""


class OldLearnOptions(OldOptions, DriveOptions):
    """Learn from a table, or from recordings with or without presses."""

    lesson: Annotated[Path | None, typer.Argument(metavar="[LESSON.csv]", show_default=False)] = None
    recording: RecordingOption = None
    driver: DriverNames = None
    trust: TrustedDriver = None
    presses: PressesFile = None
    states: PressedStates = None
    flags: LessonFlags = None
    parameters: LessonParameters = None
    session: SessionNumber = None


def old_learn(options: OldLearnOptions) -> None:
    """Learn from a table, or from recordings with or without presses."""
    options.check_name()  # what is missing comes first
    lesson, recordings = options.lesson, options.recording
    if (lesson is None) != bool(recordings):
        problem = "is missing" if lesson is None else "is one too many beside a recording"
        remedy = "give either a table, or --recording FILE"
        raise SettingError(where="learn", setting="LESSON.csv", problem=problem, remedy=remedy)
    if not recordings:
        problem, remedy = "is not used with a table", "leave it out, or give --recording"
        options.refuse_given(OF_RECORDINGS, where="learn", problem=problem, remedy=remedy)
        learn_table(choose_options(LearnTableOptions, options, table=lesson))
    elif any(_is_drive(each, options) for each in recordings):
        _learn_drives(options, recordings)
    else:
        _refuse_drivers(options, recordings)
        learn_recording(choose_options(LearnRecordingOptions, options, recording=recordings[0]))


def _is_drive(recording: Path, options: OldLearnOptions) -> bool:
    """Return whether a recording is to be segmented, because nothing else says what its driver meant."""
    if options.mapping is not None or (options.behaviors or options.define) is not None:
        return True
    return recording.suffix.lower() != ".mcap"


def _learn_drives(options: OldLearnOptions, recordings: list[Path]) -> None:
    """Learn from drives, of one driver or of several; refuse options that only apply to recordings with presses."""
    problem = "is not used with a recording whose behaviors are found from its commands"
    remedy = "leave it out, or give neither --map nor --behaviors"
    for each in recordings:
        refused = OF_PRESSES if is_trace(each) else (*OF_PRESSES, "agent")
        options.refuse_given(refused, where="learn", problem=problem, remedy=remedy)
    drivers = list(group_recordings(recordings, options.driver or (), options.trust))
    if len(drivers) == 1:
        learn_drive(choose_options(LearnDriveOptions, options, recordings=recordings, driver=drivers[0]))
    else:
        learn_drivers(choose_options(LearnDriversOptions, options, recordings=recordings))


def _refuse_drivers(options: OldLearnOptions, recordings: Sequence[Path]) -> None:
    """Refuse several recordings with presses, and options that apply only to drives."""
    if len(recordings) > 1:
        problem, remedy = "is given several times", "give recordings with presses one by one"
        raise SettingError(where="learn", setting="--recording", problem=problem, remedy=remedy)
    problem, remedy = "is not used with a recording of presses", "leave it out, or give a drive"
    options.refuse_given(("driver", "trust"), where="learn", problem=problem, remedy=remedy)


class OldTeachOptions(TeachOptions):
    """Teach a robot with the keyboard, simulated or real."""

    robot: RobotFileOption = None
    no_record: NoRecording = False


def old_teach(options: OldTeachOptions) -> None:
    """Teach a robot with the keyboard, simulated or real."""
    file = find_robots_file(options.robot, None, world=options.world)
    if file is None:
        teach(options)
    else:
        teach_on_robot(choose_options(RobotTeachOptions, options, file=file))


class OldStudioOptions(OldOptions, StudioOptions, DrivingOptions):
    """Train a robot in the browser, review recordings there, or drive a robot."""

    robot: RobotFileOption = None
    team: TeamFileOption = None
    recording: RecordingOption = None
    mapping: MapFile = None
    driver: DriverNames = None
    trust: TrustedDriver = None
    targets: RecordedTargets = None
    drive: Annotated[bool, typer.Option("--drive", help="Drive the robot with a stick.")] = False


def old_studio(options: OldStudioOptions) -> None:
    """Train a robot in the browser, review recordings there, or drive a robot."""
    world = options.scenario or options.world
    is_real = find_robots_file(options.robot, options.team, world=world) is not None
    if options.recording:
        if is_real or world or options.drive:
            raise _refuse("--recording", "is given beside a world or a robot", "name one of them")
        review_recordings(choose_options(ReviewOptions, options, recordings=options.recording))
        return
    problem, remedy = "is given without a recording", "give --recording FILE, or leave it out"
    options.refuse_given(OF_REVIEWS, where="studio", problem=problem, remedy=remedy)
    if options.drive:
        if is_real:
            raise _refuse("--drive", "is given for real robots", "name a simulated world")
        drive_robot(choose_options(DrivingOptions, options))
        return
    remedy = "give --recording FILE or --drive, or leave it out"
    options.refuse_given(OF_DRIVES, where="studio", problem=problem, remedy=remedy)
    if is_real:
        files, is_recorded = (options.robot, options.team), not options.no_record
        serve_robots_studio(
            options, *files, is_recorded=is_recorded, seed=options.seed, failures=options.failures
        )
    else:
        start_studio(choose_options(StudioOptions, options))


def _refuse(option: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where="studio", setting=option, problem=problem, remedy=remedy)
