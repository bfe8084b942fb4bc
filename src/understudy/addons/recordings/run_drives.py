"""Drives of recorded runs: what a robot sensed and was commanded in one of our recordings or traces, no presses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from understudy.errors import FileError, SettingError, join_names
from understudy.judging.run_header import trace_entry
from understudy.model.features import format_reading_label
from understudy.records.header import ReadingInfo, RunInfo
from understudy.records.join_records import join_records
from understudy.records.record import POSE, Episode, Record, select_ticks
from understudy.records.trace_writer import TraceColumns, write_trace
from understudy.sim.scenario.schema import Scenario


def choose_agent(records: Sequence[Record], path: Path | str, agent: int = 0) -> Record:
    """Return what one agent of a file sensed and was commanded, as one record with the motion of a drive.

    Parameters
    ----------
    records
        The records of the file, as `read_records` reads them.
    path
        The file or folder, for errors.
    agent
        Index of the agent among those that have commands, from 0.

    Returns
    -------
    Record
        The record, whose episodes end where ticks without commands or a pause follow.

    Raises
    ------
    FileError
        If there are no readings or commands, or the commands never change.
    SettingError
        If there is no such agent.
    """
    path = Path(path)
    driven = [each for each in records if each.channels and each.values]
    agents = list(dict.fromkeys(each.agent for each in driven))
    if not agents:
        missing = "commands" if any(each.values for each in records) else "readings"
        remedy = (
            "record it again with this version, as `understudy run --trace` does, or give --map MAP.toml with the "
            "topic or column of the commands"
        )
        raise FileError(path=path, place="", problem=f"it has no {missing} by tick", remedy=remedy)
    if not 0 <= agent < len(agents):
        remedy = f"count from 0 to {len(agents) - 1}: they are {join_names(agents)}"
        raise SettingError(where=str(path), setting="--agent", problem=f"is {agent}", remedy=remedy)
    parts = [_leave_out_ticks(each, path) for each in driven if each.agent == agents[agent]]
    moving = [each for each in parts if each.ticks]
    whole = join_records(moving or parts)
    if not whole.ticks or not np.ptp(whole.commands, axis=0).any():
        problem = "its commands never change, so there is no motion to learn from"
        raise FileError(path=path, place="", problem=problem, remedy="give a recording of a drive")
    return replace(whole, omissions=tuple(dict.fromkeys(whole.omissions)))


def _leave_out_ticks(record: Record, path: Path) -> Record:
    """Leave out the ticks without commands, and divide the record there and at pauses."""
    ticks = np.flatnonzero(np.isfinite(record.commands).all(axis=1))
    if not len(ticks):
        return select_ticks(record, ticks, ())
    apart = (np.diff(ticks) > 1) | (np.abs(np.diff(record.times[ticks])) > 2 * record.tick_s)
    starts = [0, *(np.flatnonzero(apart) + 1).tolist(), len(ticks)]
    episodes = tuple(Episode(path.name, first, end) for first, end in pairwise(starts))
    lost = record.ticks - len(ticks)
    omissions = (f"{path}: {record.agent} has no command in {lost} ticks; left out",) if lost else ()
    return replace(select_ticks(record, ticks, episodes), omissions=(*record.omissions, *omissions))


def write_trace_drive(
    path: Path | str,
    drive: Record,
    episode: Episode,
    *,
    robot: int,
    robots: int,
    ran: RunInfo,
    scenario: Scenario,
) -> None:
    """Write an episode of a person's drive as a trace, which `read_trace_records` reads.

    Parameters
    ----------
    path
        The file, which is replaced; its name ends in .jsonl or .parquet.
    drive
        The drive.
    episode
        The episode.
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
            trace.add(
                float(drive.times[tick]),
                {name: drive.pose[name][[tick]] for name in POSE},
                [()],
                readings={label: drive.values[key][[tick]] for key, label in labels.items()},
                commands={name: drive.commands[[tick], column] for column, name in enumerate(channels)},
                robots=[robot],
            )
