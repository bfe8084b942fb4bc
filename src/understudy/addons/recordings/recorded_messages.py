"""Tables of messages: what a robot would have read at each tick, from the messages that were recorded.

A column is a topic and a field of its messages, such as /cmd_vel.linear.x, or whatever a robot file can say of a topic.
Ticks are the commands, if they came regularly; otherwise ticks follow the clock.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from math import inf, isnan, nan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.mapping_file import (
    UNITS,
    WIDEST_RAD,
    CommandColumn,
    ReadingColumn,
    RecordingMap,
)
from understudy.addons.recordings.message_files import open_message_file
from understudy.addons.recordings.recorded_inputs import COMMAND, TIME, InputSamples, RecordedInputs
from understudy.addons.recordings.recorded_table import RecordedTable
from understudy.addons.recordings.recorded_topics import MessageFile
from understudy.addons.recordings.row_times import GAP_STEPS, SHORTEST_GAP_S
from understudy.addons.robots.inputs import compute_ranges_and_bearings
from understudy.errors import FileError
from understudy.model.features import ReadingKey, format_reading_label
from understudy.model.value_kinds import Column

REGULAR = 0.9
"""The share of commands that come about as far apart as usual, from which on each of them is a tick."""
FASTEST_S, SLOWEST_S = 0.005, 1.0
"""The shortest and longest tick that is chosen by itself, s."""
SOON_S = 1e-9


def read_messages(path: Path | str, mapping: RecordingMap | None) -> RecordedTable:
    """Read what a mapping names; column time_s has the time in s since the first message.

    A reading is as it last was, and absent once it is older than the mapping says. A topic that cannot be decoded is
    left out. If the file is damaged, what comes before is used.
    """
    path, omissions = Path(path), list[str]()
    if mapping is None:
        raise FileError(
            path=path,
            place="",
            problem="it has messages, and no mapping file says which fields are readings and commands",
            remedy="give --map MAP.toml, or the robot's file; a recording of `understudy run` needs neither",
        )
    with ExitStack() as stack:
        return _read_table(open_message_file(path, omissions, stack), mapping, omissions)


def _read_table(file: MessageFile, mapping: RecordingMap, omissions: list[str]) -> RecordedTable:
    gap_s = mapping.gap_s or SHORTEST_GAP_S
    recorded = RecordedInputs(file, mapping, omissions, stale_s=gap_s)
    samples = recorded.play()
    commands = [samples[f"{COMMAND}{each.name}"] for each in mapping.commands]
    for column, sampled in zip(mapping.commands, commands, strict=True):
        if not len(sampled.times):
            topic = column.column.partition(".")[0]
            problem = recorded.describe_problem(topic)
            reason = f" ({problem})" if problem else ""
            recorded.refuse(
                f"topic {topic!r}", f"it has no message that can be read{reason}", "map another topic"
            )
    tick_s, ticks = _choose_ticks(file, mapping, samples, commands, omissions)
    values: dict[ReadingKey, Column] = {}
    for name, source in recorded.inputs.sources.items():
        if not name.startswith(COMMAND) and name != TIME:
            stale_s = source.stale_s
            if (
                name in recorded.held and len(samples[name].times) > 1
            ):  # a slow sensor is not absent in between
                stale_s = max(stale_s, GAP_STEPS * float(np.median(np.diff(samples[name].times))))
            values.update(zip(source.keys, _sample(samples[name], ticks, stale_s).T, strict=True))
    _refuse_wide_angles(recorded, values)
    readings = [*recorded.columns.values(), *_add_places(recorded, mapping, values, len(ticks))]
    recorded.note_problems()
    columns = {TIME: _convert_times(file, mapping, samples, ticks, recorded, omissions)}
    columns |= {each.column: values[each.quantity, each.target] for each in readings}
    for each, sampled in zip(mapping.commands, commands, strict=True):
        columns[f"{COMMAND}{each.name}"] = _sample_new(sampled, ticks) * UNITS[each.unit][1] * each.scale
    cells: Any = np.column_stack(list(columns.values()))
    return RecordedTable(
        file.path,
        tuple(columns),
        range(1, len(ticks) + 1),
        _restore_texts(recorded.texts, columns) if recorded.texts else cells,
        omissions,
        "tick",
        RecordingMap(
            format=mapping.format,
            time=TIME,
            tick_s=tick_s,
            gap_s=mapping.gap_s,
            readings=tuple(readings),
            commands=tuple(
                CommandColumn(
                    column=f"{COMMAND}{each.name}", channel=each.name, unit=UNITS[each.unit][0], rest=each.rest,
                    hold_s=each.hold_s,
                )
                for each in mapping.commands
            ),
            behaviors=mapping.behaviors,
            world=mapping.world,
        ),
    )  # fmt: skip


def _choose_ticks(
    file: MessageFile,
    mapping: RecordingMap,
    samples: Mapping[str, InputSamples],
    commands: Sequence[InputSamples],
    omissions: list[str],
) -> tuple[float | None, Column]:
    """Choose the moments of ticks, s since the first message, and the length of a tick, unless its moments say it."""
    main = commands[0].times
    steps = np.diff(main)
    usual = float(np.median(steps)) if len(steps) else inf
    heard = np.sort(np.concatenate([each.times for each in samples.values()]))
    if np.ptp(heard) == 0:
        return mapping.tick_s, main  # which is refused as any other table without times
    regular = 0 < usual <= SLOWEST_S and float(np.mean(np.abs(steps - usual) <= usual / 2)) >= REGULAR
    if regular and (mapping.tick_s is None or abs(usual - mapping.tick_s) <= usual / 10):
        gap_s = mapping.gap_s or max(SHORTEST_GAP_S, GAP_STEPS * usual)
        return mapping.tick_s, _fill_pauses(main, heard, usual, gap_s)
    others = [
        each.times for name, each in samples.items() if not name.startswith(COMMAND) and len(each.times) > 2
    ]
    fastest = max(others, key=len, default=None)
    spacing = usual if fastest is None else float(np.median(np.diff(fastest)))
    tick_s = mapping.tick_s or float(f"{min(max(spacing, FASTEST_S), SLOWEST_S):.3g}")
    if not regular:
        omissions.append(
            f"{file.path}: commands came only now and then; ticks of {tick_s:g} s follow the clock"
        )
    gap_s = mapping.gap_s or max(SHORTEST_GAP_S, GAP_STEPS * tick_s)
    heard = heard[heard >= min(each.times[0] for each in commands)]
    pieces = np.split(heard, np.flatnonzero(np.diff(heard) > gap_s) + 1)
    return tick_s, np.concatenate([np.arange(each[0], each[-1] + tick_s / 2, tick_s) for each in pieces])


def _fill_pauses(commands: Column, heard: Column, tick_s: float, gap_s: float) -> Column:
    """Return the times of commands, with ticks in the pauses between them in which other messages came."""
    ticks = [commands]
    for at in np.flatnonzero(np.diff(commands) > 2 * tick_s).tolist():
        begin, end = commands[at], commands[at + 1]
        inside = heard[(heard >= begin) & (heard <= end)]
        for piece in np.split(inside, np.flatnonzero(np.diff(inside) > gap_s) + 1):
            last = min(piece[-1], end - tick_s / 2)
            numbers = np.arange(np.ceil((piece[0] - begin) / tick_s), np.floor((last - begin) / tick_s) + 1)
            ticks.append(begin + tick_s * numbers[numbers > 0])
    return np.sort(np.concatenate(ticks))


def _sample(samples: InputSamples, ticks: Column, stale_s: float) -> NDArray[np.float64]:
    """Return the last values of an input at each tick [T, K]; NaN where there are none, or they are too old."""
    if not len(samples.times):
        return np.full((len(ticks), samples.values.shape[1]), nan)
    at = np.searchsorted(samples.times, ticks + SOON_S, side="right") - 1
    last = np.maximum(at, 0)
    sampled: NDArray[np.float64] = samples.values[last].copy()
    sampled[(at < 0) | (ticks - samples.heard[last] > stale_s)] = nan
    return sampled


def _sample_new(samples: InputSamples, ticks: Column) -> Column:
    """Return the command that came since the tick before, at each tick; NaN where none came."""
    at = np.searchsorted(samples.times, ticks + SOON_S, side="right") - 1
    is_new = np.diff(at, prepend=-1) > 0
    sampled: Column = np.where(is_new & (at >= 0), samples.values[np.maximum(at, 0), 0], nan)
    return sampled


def _refuse_wide_angles(recorded: RecordedInputs, values: Mapping[ReadingKey, Column]) -> None:
    """Refuse an angle in radians that is so large that it must be in degrees."""
    for each in recorded.columns.values():
        widest = float(np.nanmax(np.abs(values[each.quantity, each.target]), initial=0.0))
        if each.unit == "rad" and widest > WIDEST_RAD:
            problem = f"it reaches {widest:g}, which is no angle in rad"
            recorded.refuse(f"reading {each.quantity!r}", problem, 'write unit = "deg" in the mapping file')


def _add_places(
    recorded: RecordedInputs, mapping: RecordingMap, values: dict[ReadingKey, Column], count: int
) -> list[ReadingColumn]:
    """Add ranges and bearings of targets, and return the columns of all readings that no field of a message has."""
    if mapping.targets:
        keys = list(values)
        rows = zip(*(values[key].tolist() for key in keys), strict=True) if keys else ((),) * count
        readings = [
            compute_ranges_and_bearings(mapping.targets, dict(zip(keys, row, strict=True))) for row in rows
        ]
        for key in readings[0] if readings else ():
            values[key] = np.array([each[key] for each in readings])
    named = {(each.quantity, each.target) for each in recorded.columns.values()}
    about = {each.name: each for each in recorded.inputs.readings}
    return [
        ReadingColumn(
            column=format_reading_label(key), name=key[0], target=key[1], unit=about[key[0]].unit,
            kind=str(about[key[0]].kind), doc=about[key[0]].doc,
        )
        for key in recorded.inputs.keys
        if key not in named and key in values
    ]  # fmt: skip


def _convert_times(
    file: MessageFile,
    mapping: RecordingMap,
    samples: Mapping[str, InputSamples],
    ticks: Column,
    recorded: RecordedInputs,
    omissions: list[str],
) -> Column:
    """Return the times of ticks: when messages arrived, or by the stamps that the mapping names."""
    if mapping.time in (None, TIME):
        return ticks
    arrived, stamps = samples[TIME].times, samples[TIME].values[:, 0]
    good = ~np.isnan(stamps) & (stamps != 0)
    place = f"column {mapping.time!r}"
    if not good.any():
        recorded.refuse(
            place, "its stamps are all 0, or no times", f'write time = "{TIME}" for the times of arrival'
        )
    if not good.all():
        count = int((~good).sum())
        omissions.append(
            f"{file.path}, {place}: {count} stamps are 0 or none; the times of arrival stand in for them"
        )
    arrived, stamps = arrived[good], stamps[good]
    lag = arrived + (file.first_ns or 0) * 1e-9 - stamps
    if np.ptp(lag) > SHORTEST_GAP_S:
        omissions.append(
            f"{file.path}, {place}: some messages arrived {np.ptp(lag):.3g} s later after their stamps than others; "
            "other topics are put between them by when they arrived"
        )
    times: Column = np.interp(ticks, arrived, stamps)
    times += np.minimum(ticks - arrived[0], 0.0) + np.maximum(ticks - arrived[-1], 0.0)
    return times


def _restore_texts(
    texts: Mapping[str, Mapping[str, float]], columns: Mapping[str, Column]
) -> list[list[Any]]:
    """Return rows of cells in which the numbers of texts are the texts again."""
    restored: list[list[Any]] = []
    for label, column in columns.items():
        names = list(texts.get(label, ()))
        cells = column.tolist()
        restored.append([None if isnan(each) else names[int(each)] for each in cells] if names else cells)
    return [list(row) for row in zip(*restored, strict=True)]
