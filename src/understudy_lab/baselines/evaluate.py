"""Many policies judged at once: each in the same unseen worlds, all of them side by side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from understudy.model.features import Percept
from understudy.runtime.body import Commands, list_reading_keys
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import link
from understudy_lab.baselines.demonstrations import LibraryAt
from understudy_lab.baselines.inputs import Policy
from understudy_lab.baselines.recording_body import RESTING
from understudy_lab.baselines.tasks import BaselineTask


def success_of_policies(
    exercise: BaselineTask, policies: Sequence[Policy], seeds: Sequence[int]
) -> list[float]:
    """The share of the worlds in which each policy succeeds."""
    world = exercise.world([seed for _ in policies for seed in seeds])
    keys, each = list_reading_keys(world), len(seeds)
    channels = [channel.name for channel in world.channels]
    table = np.zeros((len(exercise.basics) + 1, len(channels)))  # the last one rests
    for row, commands in zip(table, exercise.commands, strict=False):
        for name, value in commands.items():
            row[channels.index(name)] = value

    def decide(percept: Percept) -> Commands:
        raw = np.stack([percept[key] for key in keys], axis=1)
        chosen = np.concatenate(
            [policy.decide(raw[k * each : (k + 1) * each]) for k, policy in enumerate(policies)]
        )
        return dict(zip(channels, table[np.where(chosen == RESTING, len(table) - 1, chosen)].T, strict=True))

    return _shares(exercise.judge(world, decide, keys), len(policies))


def success_of_libraries(
    exercise: BaselineTask, taught: Sequence[LibraryAt], seeds: Sequence[int]
) -> list[float]:
    """The same for libraries; none succeeds that does not have the whole task yet."""
    root = exercise.topics[-1].name
    whole = [each for each in taught if root in each.library.taught]
    if not whole:
        return [0.0] * len(taught)
    world = exercise.world([seed for _ in whole for seed in seeds])
    programs = [link(each.library, root, exercise.targets) for each in whole]
    engine = Engine(world, [program for program in programs for _ in seeds])
    shares = _shares(exercise.judge(world, engine.decide, engine.keys), len(whole))
    return [0.0] * (len(taught) - len(whole)) + shares


def _shares(well: np.ndarray[tuple[int], np.dtype[np.bool_]], parts: int) -> list[float]:
    return [round(float(part.mean()), 4) for part in np.split(well, parts)]
