"""The latency of a robot: the time from a command to the motion that follows it, estimated from a recording.

Commands are compared with the rates at which readings change, at one shift after the other. Both are averaged over the
same few ticks, which dampens noise and leaves the shift between them as it is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from understudy.model.features import ReadingKey, format_reading_label
from understudy.model.value_kinds import Categorical, Column, Toroidal
from understudy.records.record import Record

LONGEST_S = 1.5
"""The longest latency, s, that is looked for."""
AVERAGED = 3
"""The number of ticks that are averaged."""
FEWEST_TICKS = 50
"""The fewest pairs of commands and rates from which a latency is estimated."""
LEAST_CORRELATION = 0.5
"""The correlation below which a reading does not tell when motion follows a command."""


@dataclass(frozen=True, slots=True)
class MotionLatency:
    """The time from a command on a channel to the motion that follows it.

    Parameters
    ----------
    channel
        Name of the channel.
    reading
        The reading whose change tells it, such as "range(ball)"; "place" for the speed along the path.
    seconds
        The latency, s.
    correlation
        Correlation of command and change at this latency, from -1 to 1.
    """

    channel: str
    reading: str
    seconds: float
    correlation: float


def estimate_motion_latencies(drive: Record) -> tuple[MotionLatency, ...]:
    """Estimate the latency of each command channel, by the reading that follows it most closely.

    Parameters
    ----------
    drive
        The drive.

    Returns
    -------
    tuple
        The latencies; channels are left out that no reading follows.
    """
    latencies = []
    rates = dict(_list_rates(drive))
    for index, channel in enumerate(drive.channels):
        followed = [
            latency
            for reading, (unit, rate) in rates.items()
            if unit in ("", channel.unit)
            for latency in [_compare(drive, index, reading, rate)]
            if latency is not None
        ]
        if followed:
            latencies.append(max(followed, key=lambda each: abs(each.correlation)))
    return tuple(latencies)


def _list_rates(drive: Record) -> Iterator[tuple[str, tuple[str, Column]]]:
    """Yield rates of change [T], 1/s, with the unit that a channel must have to be compared with them, by reading."""
    readings = {each.name: each for each in drive.readings}
    for key, column in drive.values.items():
        reading, label = readings[key[0]], format_reading_label(key)
        if isinstance(reading.kind, Categorical):
            continue
        if reading.unit in {each.unit for each in drive.channels if each.unit}:
            yield label, (reading.unit, column)
        else:
            period = reading.kind.period if isinstance(reading.kind, Toroidal) else None
            yield label, ("", _differentiate(drive, column, period))
    speed = _compute_speed(drive)
    if speed is not None:
        yield "place", ("", speed)


def _differentiate(drive: Record, column: Column, period: float | None) -> Column:
    """Return by how much a column changes until the next tick, per second; NaN at the end of episodes."""
    steps = np.diff(column, append=np.nan)
    if period is not None:
        steps = (steps + period / 2) % period - period / 2
    steps[[each.end - 1 for each in drive.episodes]] = np.nan
    rates: Column = steps / drive.tick_s
    return rates


def _compute_speed(drive: Record) -> Column | None:
    """Return the speed along the heading [T], m/s, if the drive has the place of the robot."""
    axes: list[Column] = []
    for name in ("x", "y"):
        key: ReadingKey = (name, None)
        if key not in drive.values:
            return None
        axes.append(_differentiate(drive, drive.values[key], None))
    heading = drive.values.get(("heading", None))
    if heading is None:
        return np.hypot(*axes)
    ahead: Column = axes[0] * np.cos(heading) + axes[1] * np.sin(heading)
    return ahead


def _compare(drive: Record, channel: int, reading: str, rate: Column) -> MotionLatency | None:
    """Return the latency at which a rate follows a channel most closely, unless that is at the end of the range."""
    longest = round(LONGEST_S / drive.tick_s)
    pairs: list[list[tuple[Column, Column]]] = [[] for _ in range(longest + 1)]
    for episode in drive.episodes:
        command = _average(drive.commands[episode.ticks, channel])
        follows = _average(rate[episode.ticks])
        for shift in range(min(longest + 1, len(command))):
            pairs[shift].append((command[: len(command) - shift], follows[shift:]))
    closeness = np.array([_correlate(each) for each in pairs])
    if np.isnan(closeness).all():
        return None
    best = int(np.nanargmax(np.abs(closeness)))
    correlation = float(closeness[best])
    if abs(correlation) < LEAST_CORRELATION or (best == longest and longest > 0):
        return None
    top = float(best)
    if 0 < best < longest:  # the top of a parabola through three points lies between ticks
        before, at, after = np.abs(closeness[best - 1 : best + 2]).tolist()
        curved = before - 2 * at + after
        top += 0.5 * (before - after) / curved if curved < 0 else 0.0
    return MotionLatency(drive.channels[channel].name, reading, top * drive.tick_s, correlation)


def _average(column: Column) -> Column:
    """Return the mean of a few ticks around each [T - 2]; NaN if one is absent."""
    if len(column) < AVERAGED:
        return np.empty(0)
    return np.convolve(column, np.full(AVERAGED, 1 / AVERAGED), mode="valid")


def _correlate(pairs: list[tuple[Column, Column]]) -> float:
    """Return the correlation of columns in pairs; NaN if there are too few, or one never changes."""
    if not pairs:
        return float("nan")
    first, second = (np.concatenate(each) for each in zip(*pairs, strict=True))
    present = np.isfinite(first) & np.isfinite(second)
    if present.sum() < FEWEST_TICKS or np.ptp(first[present]) == 0 or np.ptp(second[present]) == 0:
        return float("nan")
    return float(np.corrcoef(first[present], second[present])[0, 1])
