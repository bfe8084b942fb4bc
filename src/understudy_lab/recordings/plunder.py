"""Demonstrations published with PLUNDER: how they are read, and the action models that their README gives.

Patton, Rahmani, Missula, Biswas and Dillig, Programming-by-Demonstration for Long-Horizon Robot Tasks (2023).
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from understudy.addons.recordings.candidates import CommandModel
from understudy.model.features import ReadingsView
from understudy.model.value_kinds import Column, Continuous
from understudy.records.record import Episode, Record
from understudy.runtime.body import Channel, Reading

TRUTH, COMMAND = "HA", "LA."


@dataclass(frozen=True, slots=True)
class Demonstration:
    """A demonstration, and the true action of each tick, which serves only to score labels."""

    drive: Record
    truth: Column


def read_demonstration(path: Path) -> Demonstration:
    """Read one demonstration."""
    with path.open(newline="") as file:
        rows = [[cell.strip() for cell in row] for row in csv.reader(file) if row]
    table = np.array(rows[1:], np.float64)
    columns = dict(zip(rows[0], table.T, strict=True))
    channels = [name for name in columns if name.startswith(COMMAND)]
    named = [name for name in columns if name not in (TRUTH, *channels)]
    times = np.arange(len(table), dtype=np.float64)
    drive = Record(
        times,
        {(name, None): columns[name] for name in named},
        np.column_stack([columns[name] for name in channels]),
        tuple(Channel(name.removeprefix(COMMAND)) for name in channels),
        tuple(Reading(name, Continuous()) for name in named),
        (),
        1.0,
        (Episode(path.name, 0, len(table)),),
    )
    return Demonstration(drive, columns[TRUTH])


def read_demonstrations(folder: Path, *, parity: int) -> list[Demonstration]:
    """Read the demonstrations of a folder with even (0) or odd (1) numbers."""
    paths = sorted(folder.glob("*.csv"), key=lambda each: int(each.stem))
    return [read_demonstration(each) for each in paths if int(each.stem) % 2 == parity]


def accelerate(robot: ReadingsView, last: ReadingsView, *, rate: float = 1.0) -> Mapping[str, Column]:
    """Accelerate more from tick to tick, up to the limit."""
    return {"acc": np.minimum(last.acc + rate, robot.accMax)}


def hold(robot: ReadingsView, last: ReadingsView, *, rate: float = 1.0) -> Mapping[str, Column]:
    """Let the acceleration go back to 0."""
    return {"acc": last.acc - np.clip(last.acc, -rate, rate)}


def decelerate(robot: ReadingsView, last: ReadingsView, *, rate: float = 1.0) -> Mapping[str, Column]:
    """Brake more from tick to tick, up to the limit."""
    return {"acc": np.maximum(last.acc - rate, robot.decMax)}


def _steer(
    robot: ReadingsView,
    last: ReadingsView,
    acc: Column | float,
    heading: Column | float,
    limits: tuple[float, float, float],
) -> Mapping[str, Column]:
    turn, more, less = limits
    return {
        "steer": last.steer + np.clip(heading - robot.heading - last.steer, -turn, turn),
        "acc": last.acc + np.clip(acc - last.acc, -less, more),
    }


def _keep_lane(robot: ReadingsView, distance: float) -> Column:
    return np.arctan((4 * np.round(robot.y / 4) - robot.y) / distance)


def go_faster(
    robot: ReadingsView, last: ReadingsView, *, speed: float = 45.0, distance: float = 30.0, turn: float = 0.08,
    more: float = 4.0, less: float = 6.0,
) -> Mapping[str, Column]:  # fmt: skip
    """Accelerate to a speed and keep the lane."""
    return _steer(robot, last, speed - robot.vx, _keep_lane(robot, distance), (turn, more, less))


def go_slower(
    robot: ReadingsView, last: ReadingsView, *, distance: float = 30.0, turn: float = 0.08, more: float = 4.0,
    less: float = 6.0,
) -> Mapping[str, Column]:  # fmt: skip
    """Take the speed of the car ahead and keep the lane."""
    return _steer(robot, last, robot.f_vx - robot.vx, _keep_lane(robot, distance), (turn, more, less))


def turn_left(
    robot: ReadingsView, last: ReadingsView, *, brake: float = 0.5, heading: float = 0.15, turn: float = 0.08,
    more: float = 4.0, less: float = 6.0,
) -> Mapping[str, Column]:  # fmt: skip
    """Change to the lane at the left."""
    return _steer(robot, last, -brake, -heading, (turn, more, less))


def turn_right(
    robot: ReadingsView, last: ReadingsView, *, brake: float = 0.5, heading: float = 0.15, turn: float = 0.08,
    more: float = 4.0, less: float = 6.0,
) -> Mapping[str, Column]:  # fmt: skip
    """Change to the lane at the right."""
    return _steer(robot, last, -brake, heading, (turn, more, less))


def move_to_cube(
    robot: ReadingsView, last: ReadingsView, *, gain: float = 5.0, wide: float = 0.6
) -> Mapping[str, Column]:
    """Move to the cube with an open gripper."""
    return {
        "vx": gain * (robot.bx - robot.x),
        "vy": gain * (robot.by - robot.y),
        "vz": gain * (robot.bz - robot.z),
        "end": np.full_like(robot.x, wide),
    }


def move_to_target(
    robot: ReadingsView, last: ReadingsView, *, gain: float = 5.0, wide: float = 0.6, close: float = 0.3,
    shut: float = -0.3,
) -> Mapping[str, Column]:  # fmt: skip
    """Close the gripper, then move to the target."""
    closed = last.end < shut
    goal = {axis: np.where(closed, getattr(robot, f"t{axis}"), getattr(robot, f"b{axis}")) for axis in "xyz"}
    return {
        **{f"v{axis}": gain * (goal[axis] - getattr(robot, axis)) for axis in "xyz"},
        "end": np.clip(last.end - close, -wide, wide),
    }


STEER = {"turn": (0.02, 0.3), "more": (1.0, 10.0), "less": (1.0, 10.0)}
UNKNOWN: Mapping[str, tuple[float, float]] = {
    "rate": (0.2, 4.0),
    "speed": (25.0, 70.0),
    "distance": (5.0, 100.0),
    **STEER,
    "brake": (-3.0, 3.0),
    "heading": (0.02, 0.5),
    "gain": (0.5, 15.0),
    "wide": (0.2, 1.0),
    "close": (0.05, 1.0),
    "shut": (-0.6, 0.6),
}
"""The ranges in which constants are looked for where they are not given."""

MODELS: Mapping[str, Sequence[CommandModel]] = {
    "stop-sign": tuple(CommandModel(each.__name__, each) for each in (accelerate, hold, decelerate)),
    "merge": tuple(
        CommandModel(each.__name__, each) for each in (go_faster, go_slower, turn_left, turn_right)
    ),
    "pick-place": tuple(CommandModel(each.__name__, each) for each in (move_to_cube, move_to_target)),
}
"""The action models of each folder, in the order of the numbers of the true actions."""


def with_unknown(model: CommandModel) -> CommandModel:
    """Return a model all of whose constants are to be found."""
    own = {name: UNKNOWN[name] for name in model.constants}
    return CommandModel(model.name, model.function, own)
