"""Drives of recorded runs: what a robot sensed and was commanded in one of our recordings or traces, no presses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.recorded_drive import DriveEpisode, RecordedDrive, join_drives, select_ticks
from understudy.errors import FileError, SettingError, join_names
from understudy.judging.episodes.episode import Episode
from understudy.judging.episodes.run_episodes import read_trace_episodes
from understudy.judging.run_header import TraceHeader, read_trace, trace_entry
from understudy.judging.run_trace import ReadingInfo, TraceColumns, write_trace
from understudy.model.features import ReadingKey, format_reading_label
from understudy.records.header import RunInfo
from understudy.records.reader import Recording
from understudy.runtime.body import Channel, Reading
from understudy.sim.scenario.schema import Scenario


class TraceDrive(NamedTuple):
    """The drive of one robot of a trace, the header of the trace, and where the robot was at each tick [T, 2], m."""

    drive: RecordedDrive
    header: TraceHeader
    places: NDArray[np.float64]


def read_trace_drive(path: Path | str, *, robot: int = 0) -> TraceDrive:
    """Read what one robot sensed and did in a traced run.

    Parameters
    ----------
    path
        The trace, as JSON lines or Parquet.
    robot
        Index of the robot, from 0.

    Returns
    -------
    TraceDrive
        The drive, with one episode for each piece in which the robot had commands, the header of the trace, and
        the robot's places.

    Raises
    ------
    FileError
        If the file is no trace, or one of an earlier version, which has no commands.
    SettingError
        If it has no such robot.
    """
    path = Path(path)
    header, _ = read_trace(path)
    episode = next((each for each in read_trace_episodes(path) if each.agent == f"robot {robot}"), None)
    if episode is None:
        remedy = f"count from 0 to {header.robots - 1}"
        raise SettingError(where=str(path), setting="--agent", problem=f"is {robot}", remedy=remedy)
    if not episode.commands or not episode.readings:
        missing = "readings" if episode.commands else "commands"
        remedy = "run it again with `understudy run --trace`, of this version"
        raise FileError(path=path, place="", problem=f"the trace has no {missing}", remedy=remedy)
    whole = _make_drive(episode)
    drive, ticks = _leave_out_ticks(whole, path, robot, remedy="trace another run")
    return TraceDrive(drive, header, np.column_stack([episode.pose["x"], episode.pose["y"]])[ticks])


def make_episodes_drive(episodes: Sequence[Episode], path: Path | str, *, robot: int = 0) -> RecordedDrive:
    """Make a drive of what one robot sensed and did in the episodes of a file that other programs read, too.

    Parameters
    ----------
    episodes
        The episodes, as `read_tick_episodes` reads them of a table.
    path
        The file or folder, for errors.
    robot
        Index of the agent among those that have commands, from 0.

    Returns
    -------
    RecordedDrive
        The drive, with at least one episode for each of the file's; its `omissions` say what the file does not hold.

    Raises
    ------
    FileError
        If there are no readings or commands.
    SettingError
        If there is no such agent.
    """
    path = Path(path)
    driven = [each for each in episodes if each.commands and each.readings]
    agents = list(dict.fromkeys(each.agent for each in driven))
    if not agents:
        remedy = "export a run whose commands were recorded, such as one of understudy run --trace"
        raise FileError(
            path=path, place="", problem="it has no ticks with readings and commands", remedy=remedy
        )
    if not 0 <= robot < len(agents):
        remedy = f"count from 0 to {len(agents) - 1}: they are {join_names(agents)}"
        raise SettingError(where=str(path), setting="--agent", problem=f"is {robot}", remedy=remedy)
    drives = [
        _leave_out_ticks(_make_drive(each), path, robot, remedy="export another run")[0]
        for each in driven
        if each.agent == agents[robot]
    ]
    whole = join_drives(drives)
    if driven[0].units:
        return whole
    sentence = (
        f"{path}: it does not say units and kinds of readings; numbers were taken as distances, not as angles"
    )
    return replace(whole, omissions=(*whole.omissions, sentence))


def _make_drive(episode: Episode) -> RecordedDrive:
    """Make a drive of an episode, which has no pieces yet."""
    labels = {label: _parse_label(label) for label in episode.readings}
    return RecordedDrive(
        times=episode.times,
        values={key: episode.readings[label] for label, key in labels.items()},
        commands=np.column_stack(list(episode.commands.values())),
        channels=tuple(Channel(name, unit=episode.channel_units.get(name, "")) for name in episode.commands),
        readings=tuple(
            {
                name: Reading(name, episode.kinds[label], episode.units.get(label, ""), target is not None)
                for label, (name, target) in labels.items()
            }.values()
        ),
        targets=tuple(dict.fromkeys(target for _, target in labels.values() if target is not None)),
        tick_s=episode.tick_s,
        episodes=(),
    )


def _leave_out_ticks(
    drive: RecordedDrive, path: Path, robot: int, *, remedy: str
) -> tuple[RecordedDrive, NDArray[np.intp]]:
    """Leave out the ticks without commands, and divide the drive there and at pauses; return the other ticks, too."""
    ticks = np.flatnonzero(np.isfinite(drive.commands).all(axis=1))
    if not len(ticks) or not np.ptp(drive.commands[ticks], axis=0).any():
        problem = "its commands never change, so there is no motion to learn from"
        raise FileError(path=path, place="", problem=problem, remedy=remedy)
    apart = (np.diff(ticks) > 1) | (np.abs(np.diff(drive.times[ticks])) > 2 * drive.tick_s)
    starts = [0, *(np.flatnonzero(apart) + 1).tolist(), len(ticks)]
    episodes = tuple(DriveEpisode(path.name, first, end) for first, end in pairwise(starts))
    lost = drive.ticks - len(ticks)
    omissions = (f"{path}: robot {robot} has no command in {lost} ticks; left out",) if lost else ()
    return replace(select_ticks(drive, ticks, episodes), omissions=omissions), ticks


def write_trace_drive(
    path: Path | str,
    drive: RecordedDrive,
    episode: DriveEpisode,
    poses: NDArray[np.float64],
    *,
    robot: int,
    robots: int,
    ran: RunInfo,
    scenario: Scenario,
) -> None:
    """Write an episode of a person's drive as a trace, which `read_trace_drive` reads.

    Parameters
    ----------
    path
        The file, which is replaced; its name ends in .jsonl or .parquet.
    drive
        The drive.
    episode
        The episode.
    poses
        The x and y (m) and the heading (rad) of the robot after each tick of the drive, shape [T, 3].
    robot
        Index of the robot, from 0.
    robots
        The number of robots in its world.
    ran
        The world and the kit of the drive.
    scenario
        The scenario of the world.
    """
    kinds = {each.name: each for each in drive.readings}
    labels = {key: format_reading_label(key) for key in drive.values}
    columns = TraceColumns(
        readings={
            label: ReadingInfo(str(kinds[name].kind), kinds[name].unit) for (name, _), label in labels.items()
        },
        commands={channel.name: channel.unit for channel in drive.channels},
    )
    with write_trace(
        path,
        scenario=scenario.name,
        seed=ran.seed,
        tick_s=drive.tick_s,
        robots=robots,
        run=trace_entry(ran, scenario),
        columns=columns,
    ) as trace:
        channels = [channel.name for channel in drive.channels]
        for tick in range(episode.first, episode.end):
            trace.add_robot(
                float(drive.times[tick]),
                robot,
                poses[tick].tolist(),
                readings={label: float(drive.values[key][tick]) for key, label in labels.items()},
                commands=dict(zip(channels, drive.commands[tick].tolist(), strict=True)),
            )


def _parse_label(label: str) -> ReadingKey:
    """Return the name and the target of a reading from its label, such as "range(ball)"."""
    name, opened, target = label.partition("(")
    return (name, target.removesuffix(")")) if opened else (label, None)


def make_recorded_drive(recording: Recording, *, robot: int = 0) -> RecordedDrive:
    """Make a drive of what one robot of a recording sensed, and was commanded.

    Parameters
    ----------
    recording
        The recording, as `read_recording` reads it.
    robot
        Index of the robot, from 0.

    Returns
    -------
    RecordedDrive
        The drive; an episode ends where ticks without commands or a pause follow.

    Raises
    ------
    FileError
        If it has no commands, as recordings of earlier versions, or they never change.
    SettingError
        If it has no such robot.
    """
    path, head = recording.path, recording.head
    if not 0 <= robot < len(head.names):
        remedy = f"count from 0 to {len(head.names) - 1}"
        raise SettingError(where=str(path), setting="--agent", problem=f"is {robot}", remedy=remedy)
    channels = [each for each in head.channels if each.name in recording.commands]
    if not channels:
        remedy = "record it again with this version, or give --map MAP.toml with the topic of the commands"
        raise FileError(path=path, place="", problem="it has no commands by tick", remedy=remedy)
    whole = RecordedDrive(
        times=recording.times,
        values={key: recording.values[:, index, robot] for index, key in enumerate(recording.keys)},
        commands=np.column_stack([recording.commands[each.name][:, robot] for each in channels]),
        channels=tuple(channels),
        readings=tuple(head.readings),
        targets=tuple(head.targets),
        tick_s=head.tick_s,
        episodes=(),
    )
    drive, _ = _leave_out_ticks(whole, path, robot, remedy="give a recording of a drive")
    present = {key: column for key, column in drive.values.items() if np.isfinite(column).any()}
    return replace(drive, values=present)
