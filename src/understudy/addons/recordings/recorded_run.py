"""Drives from our own recordings: what a robot sensed and was commanded in a recorded run, without its presses."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from understudy.addons.recordings.recorded_drive import DriveEpisode, RecordedDrive
from understudy.errors import FileError, SettingError
from understudy.records.reader import Recording


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
    commands = np.column_stack([recording.commands[each.name][:, robot] for each in channels])
    usable = np.flatnonzero(np.isfinite(commands).all(axis=1))
    if not len(usable) or not np.ptp(commands[usable], axis=0).any():
        problem = "its commands never change, so there is no motion to learn from"
        raise FileError(path=path, place="", problem=problem, remedy="give a recording of a drive")
    apart = (np.diff(usable) > 1) | (np.abs(np.diff(recording.times[usable])) > 2 * head.tick_s)
    starts = [0, *(np.flatnonzero(apart) + 1).tolist(), len(usable)]
    columns = recording.values[usable, :, robot]
    present = [index for index in range(columns.shape[1]) if np.isfinite(columns[:, index]).any()]
    lost = recording.ticks - len(usable)
    return RecordedDrive(
        times=recording.times[usable],
        values={recording.keys[index]: columns[:, index].copy() for index in present},
        commands=commands[usable],
        channels=tuple(channels),
        readings=tuple(head.readings),
        targets=tuple(head.targets),
        tick_s=head.tick_s,
        episodes=tuple(DriveEpisode(path.name, first, end) for first, end in pairwise(starts)),
        omissions=(f"{path}: robot {robot} has no command in {lost} ticks; left out",) if lost else (),
    )
