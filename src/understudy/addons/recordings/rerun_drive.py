"""Automata run over the readings of a drive, to compare what they would have done with its labels."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from understudy.addons.recordings.drive_examples import make_recording, name_state
from understudy.addons.recordings.drive_kit import remove_functions
from understudy.addons.recordings.recorded_drive import Ints, RecordedDrive
from understudy.addons.recordings.segment import Segmentation
from understudy.model.library import Library
from understudy.records.replay import ReplayBody
from understudy.runtime.link import link
from understudy.runtime.run_loop import Run

OTHER = -1
"""The index of a state that is no label, such as start or a flag."""


def run_over_drive(
    library: Library,
    automaton: str,
    drive: RecordedDrive,
    names: tuple[str, ...],
    *,
    targets: Mapping[str, str] = MappingProxyType({}),
) -> Ints:
    """Run an automaton over the readings of a drive, restarted at each episode.

    Nothing moves the robot: at each tick the readings are the recorded ones; decisions of the automaton have no effect.

    Parameters
    ----------
    library
        The library with the automaton.
    automaton
        Its name.
    drive
        The drive.
    names
        The labels, whose states are named as `to_lesson` names them.
    targets
        Targets of the automaton's parameters, by parameter.

    Returns
    -------
    array, shape [T]
        Index of the label whose state the automaton is in at each tick; `OTHER` for other states.
    """
    bare = remove_functions(library)
    program = link(bare, automaton, targets)
    indices = {name_state(name): index for index, name in enumerate(names)}
    states = np.full(drive.ticks, OTHER, np.int64)
    for episode in drive.episodes:
        run = Run.from_program(ReplayBody(make_recording(drive, episode)), program)
        for tick in range(episode.first, episode.end):
            run.tick()
            states[tick] = indices.get(run.path(0)[0], OTHER)
    return states


def measure_agreement(segmentation: Segmentation, states: Ints) -> float:
    """Measure the share of ticks, from 0 to 1, at which an automaton was in the state of the label.

    Parameters
    ----------
    segmentation
        The labels; ticks that nothing explains do not count.
    states
        What `run_over_drive` returned.

    Returns
    -------
    float
        The share; 1 without any tick that counts.
    """
    counted = segmentation.labels < len(segmentation.candidates)
    return float((states == segmentation.labels)[counted].mean()) if counted.any() else 1.0
