"""Files of records in every form that a run can be written in, by the writers of the product."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from understudy.addons.bridges.datasets.lerobot import write_lerobot
from understudy.addons.bridges.datasets.minari import write_minari
from understudy.model.features import format_reading_label
from understudy.model.value_kinds import Column
from understudy.records.header import ReadingInfo, RunInfo
from understudy.records.record import POSE, Record
from understudy.records.record_tables import make_tick_table
from understudy.records.recorder import RunRecorder
from understudy.records.replay import ReplayBody
from understudy.records.table_files import write_table
from understudy.records.trace_writer import TraceColumns, write_trace


def write_as_trace(records: Sequence[Record], folder: Path) -> Path:
    """Trace robots that have the same ticks, readings and channels."""
    first, path = records[0], folder / "run.jsonl"
    columns = TraceColumns(
        readings={
            format_reading_label(key): ReadingInfo(str(first.find_kind(key)), first.find_unit(key))
            for key in first.values
        },
        commands={each.name: each.unit for each in first.channels},
    )
    about = {"scenario": "arena", "behavior": first.behavior, "kit": None, "library": "library"}
    run: dict[str, Any] = {**about, "world": "", "sorts": [], "binding": {}, "automata": {}}
    with write_trace(
        path,
        scenario="arena",
        seed=first.seed or 0,
        tick_s=first.tick_s,
        robots=len(records),
        run=run,
        columns=columns,
    ) as trace:
        for tick in range(first.ticks):
            trace.add(
                float(first.times[tick]),
                {name: np.array([_get_pose(each, name)[tick] for each in records]) for name in POSE},
                [each.states[tick] for each in records],
                readings={
                    format_reading_label(key): np.array([each.values[key][tick] for each in records])
                    for key in first.values
                },
                commands={
                    channel.name: np.array([each.commands[tick, column] for each in records])
                    for column, channel in enumerate(first.channels)
                },
            )
    return path


def _get_pose(record: Record, name: str) -> Column:
    return record.pose.get(name, np.full(record.ticks, np.nan))


def write_as_recording(records: Sequence[Record], folder: Path) -> Path:
    """Record robots that have the same ticks, readings and channels, with their presses."""
    path, body = folder / "run.mcap", ReplayBody(records)
    keys = [*records[0].values]
    ran = RunInfo(scenario="arena", seed=records[0].seed or 0, behavior=records[0].behavior)
    with RunRecorder(path, clock=lambda: body.time_s) as recorder:
        recorder.begin(body, names=[each.agent.replace(" ", "_") for each in records], ran=ran)
        for tick in range(records[0].ticks):
            for agent, record in enumerate(records):
                for press in (each for each in record.presses if each.tick == tick):
                    recorder.write_press(press.state, agent=agent)
            percept = body.sense(keys)
            commands = {
                channel.name: np.array([each.commands[tick, column] for each in records])
                for column, channel in enumerate(records[0].channels)
            }
            recorder.write_tick(
                body.time_s,
                percept,
                [each.states[tick] for each in records],
                commands=commands,
                at_s=body.time_s,
            )
            body.act({})
    return path


def _write_table(ending: str) -> Callable[[Sequence[Record], Path], Path]:
    def write(records: Sequence[Record], folder: Path) -> Path:
        path = folder / f"ticks.{ending}"
        write_table(make_tick_table(records), path)
        return path

    return write


def write_as_lerobot(records: Sequence[Record], folder: Path) -> Path:
    """Write a data set of LeRobot."""
    write_lerobot(records, folder / "set")
    return folder / "set"


def write_as_minari(records: Sequence[Record], folder: Path) -> Path:
    """Write a data set of Minari."""
    write_minari(records, folder / "set-v0")
    return folder / "set-v0"


WRITERS: Mapping[str, Callable[[Sequence[Record], Path], Path]] = {
    "csv": _write_table("csv"),
    "jsonl": _write_table("jsonl"),
    "parquet": _write_table("parquet"),
    "lerobot": write_as_lerobot,
    "minari": write_as_minari,
    "trace": write_as_trace,
    "mcap": write_as_recording,
}
"""The writer of each form, which returns the file or folder that it wrote."""
