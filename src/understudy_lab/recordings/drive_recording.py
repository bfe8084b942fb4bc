"""Recordings of simulated drivers: drives of many worlds at once, and what the driver meant in each tick."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.recorded_drive import DriveEpisode, RecordedDrive
from understudy.model.features import Percept, ReadingKey
from understudy.model.library import Kit
from understudy.runtime.body import Body
from understudy_lab.recordings.stick_driver import Stick, StickSettings

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class DriverStep(NamedTuple):
    """What drivers do in a tick in N worlds.

    `meant` is the index of the behavior that a driver means, `aimed` that of the basic behavior that the hand aims at
    for it, and `over` is true where the recording ends after this tick.
    """

    meant: Ints
    aimed: Ints
    over: NDArray[np.bool_]


class DriverProgram(Protocol):
    """A program by which drivers decide, from readings alone, in N worlds."""

    @property
    def keys(self) -> Sequence[ReadingKey]:
        """The readings that the drivers see, which are recorded."""
        ...

    def decide(self, percept: Percept) -> DriverStep:
        """Return what the drivers do in this tick."""
        ...


class MeantDrive(NamedTuple):
    """A recording, and the index of the behavior that the driver meant in each tick [T]."""

    recording: RecordedDrive
    meant: Ints


def list_aims(kit: Kit, moves: Sequence[str], channels: Sequence[str]) -> Floats:
    """Return the commands [M, C] of basic behaviors, which the hand aims at."""
    return np.array([[kit.behaviors[name].command.get(each, 0.0) for each in channels] for name in moves])


def record_drives(
    body: Body,
    program: DriverProgram,
    hand: StickSettings,
    moves: Sequence[str],
    *,
    kit: Kit,
    seconds: float,
    seeds: Sequence[int],
    place: str,
    buttons: Sequence[str] = (),
    pushes: Floats | None = None,
) -> MeantDrive:
    """Drive all robots of a body at once; return one recording with an episode for each.

    Parameters
    ----------
    body
        A body with a robot for each driver.
    program
        What the drivers decide.
    hand
        How they move the stick.
    moves
        The basic behaviors that the hand aims at, by the index that the program gives.
    kit
        The kit that has the commands of these behaviors.
    seconds
        The longest drive, s.
    seeds
        A seed for each robot, by which its episode is called; the first one is also that of the noise.
    place
        Name of what has a seed, such as "room".
    buttons
        The channels that are commanded by buttons.
    pushes
        What is added to the commands of robots that are pushed, which is not recorded, shape [ticks, N, C].

    Returns
    -------
    MeantDrive
        The recording, and what the driver meant in each tick.
    """
    keys, agents = list(program.keys), body.agents
    channels = [each.name for each in body.channels]
    aims, random = list_aims(kit, moves, channels), np.random.default_rng([seeds[0], 17])
    stick = Stick(hand, agents, len(channels), random, buttons=[channels.index(each) for each in buttons])
    ticks = round(seconds / body.tick_s)
    rows, meant, commands, ends = [], [], [], np.full(agents, ticks)
    for tick in range(ticks):
        percept = body.sense(keys)
        rows.append([percept[key].copy() for key in keys])
        step = program.decide(percept)
        stick_commands = stick.move(aims[step.aimed])
        meant.append(step.meant.copy())
        commands.append(stick_commands)
        ends = np.where(step.over & (ends == ticks), tick + 1, ends)
        if (ends < ticks).all():
            break
        obeyed = stick_commands if pushes is None else stick_commands + pushes[tick]
        body.act({name: obeyed[:, index].copy() for index, name in enumerate(channels)})
    table, stops = np.array(rows), ends.tolist()
    firsts = np.cumsum([0, *stops]).tolist()

    def join(columns: Floats) -> Floats:
        return np.concatenate([columns[:end, world] for world, end in enumerate(stops)])

    recording = RecordedDrive(
        np.concatenate([np.arange(end) * body.tick_s for end in stops]),
        {key: join(table[:, index]) for index, key in enumerate(keys)},
        join(np.array(commands)),
        tuple(body.channels),
        tuple(each for each in body.readings if each.name in {name for name, _ in keys}),
        tuple(dict.fromkeys(target for _, target in keys if target is not None)),
        body.tick_s,
        tuple(
            DriveEpisode(f"{place} {seed}", a, a + n)
            for seed, a, n in zip(seeds, firsts, stops, strict=False)
        ),
    )
    return MeantDrive(recording, join(np.array(meant)).astype(np.int64))
