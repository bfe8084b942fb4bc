"""Automata as candidates: an automaton of the library is run over the recorded readings.

It may begin at any tick. How its levels stand after a tick follows from how they stood before, so the ways in which
they can stand are the states of one label, and the likeliest labels are still found exactly. The time in a state,
timers and counters are those of the run that has lasted longest in the same states.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from understudy.addons.recordings.candidates import (
    Candidate,
    Prediction,
    compute_behavior_commands,
)
from understudy.model.binding import NOTHING_BOUND, Binding, format_bound_name
from understudy.model.library import Library
from understudy.records.record import Floats, Ints, Record
from understudy.runtime.feature_columns import read_feature_column
from understudy.runtime.interpreter import Interpreter, StackFrame
from understudy.runtime.link import Program, link


@dataclass(frozen=True, slots=True)
class AutomatonCandidate(Candidate):
    """A candidate that is an automaton of a library, with the targets of its parameters."""

    library: Library
    behavior: str
    binding: Binding = NOTHING_BOUND

    @property
    def name(self) -> str:
        """The automaton with its targets, such as "deposit(station)"."""
        return format_bound_name(self.behavior, self.binding, self.library.parameters(self.behavior))

    def predict(self, drive: Record) -> Prediction:
        """Return the commands of the automaton in each way in which its levels can stand."""
        program = link(self.library, self.behavior, self.binding)
        return _Exploration(program, drive).explore()


class _Exploration:
    """The runs of a program that begin at all ticks of a drive, joined where their levels stand alike."""

    def __init__(self, program: Program, drive: Record) -> None:
        self._program, self._drive = program, drive
        self._interpreter = Interpreter(program)
        self._paths: dict[tuple[int, tuple[str, ...]], int] = {}
        columns = [read_feature_column(each, drive.percept, agents=drive.ticks) for each in program.features]
        self._rows = np.array(columns).T.tolist() if columns else [[]] * drive.ticks
        self._basics = [compute_behavior_commands(each, drive) for each in program.basics]

    def explore(self) -> Prediction:
        """Run the program from all ticks."""
        drive = self._drive
        entry = np.empty(drive.ticks, np.int64)
        steps: list[dict[int, int]] = []
        running: dict[int, tuple[StackFrame, ...]] = {}
        begins = {each.first for each in drive.episodes}
        for tick, row in enumerate(self._rows):
            now = float(drive.times[tick])
            if tick in begins:
                running = {}
            step, former = {}, running
            running = {}
            for state, frames in former.items():
                self._interpreter.restore(frames, now=now)
                step[state] = self._pulse(row, now, running)
            self._interpreter.start(now)
            entry[tick] = self._pulse(row, now, running)
            steps.append(step)
        count = len(self._paths)
        following: Ints = np.tile(np.arange(count), (drive.ticks, 1))
        for tick, step in enumerate(steps):
            for state, after in step.items():
                following[tick, state] = after
        commands: Floats = np.stack([self._basics[basic] for basic, _ in self._paths])
        return Prediction(commands, entry, following)

    def _pulse(self, row: list[float], now: float, running: dict[int, tuple[StackFrame, ...]]) -> int:
        """Pulse once, note how the levels stand, and return the number of it."""
        basic = self._interpreter.pulse(row, now)
        key = basic, self._interpreter.path
        state = self._paths.setdefault(key, len(self._paths))
        running.setdefault(state, self._interpreter.snapshot(now))
        return state
