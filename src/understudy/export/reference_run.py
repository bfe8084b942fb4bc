"""The reference of an export: what the interpreter answers to rows of readings, tick by tick."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

import numpy as np

from understudy.errors import DefinitionError
from understudy.export.hierarchy import Hierarchy
from understudy.export.single_functions import compute_in_single
from understudy.model.features import BoundFeature, Feature, Percept, ReadingsView, call_user_function
from understudy.runtime.body import ISSUED, ORDER
from understudy.runtime.feature_columns import read_feature_column
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.program import Program


@dataclass(frozen=True, slots=True)
class ReferenceTick:
    """The answer to one row of readings.

    `path` has the index of the state of every level, the root first; `flags` the flag that each level has raised, as an
    index of `Hierarchy.flags`, -1 if none; `commands` a value for each channel.
    """

    path: tuple[int, ...]
    flags: tuple[int, ...]
    basic: int
    commands: tuple[float, ...]


class ReferenceRun:
    """An interpreter that takes rows of readings in the order of `Hierarchy.readings`.

    With `single_precision`, functions compute in 32-bit floats.
    """

    def __init__(self, program: Program, hierarchy: Hierarchy, *, single_precision: bool = False) -> None:
        self.program, self.hierarchy = program, hierarchy
        self.interpreter = Interpreter(program)
        self._type = np.float32 if single_precision else np.float64
        self._flags = {flag: index for index, flag in enumerate(hierarchy.flags)}
        self._features, self._functions = self._prepare_functions()
        self._computes = any(at < 0 for at in hierarchy.features)
        self._commands = [
            tuple(basic.command.get(channel.name, channel.rest) for channel in hierarchy.channels)
            for basic in hierarchy.basics
        ]

    def start(self, now: float) -> None:
        """Start the root again at a time, s."""
        self.interpreter.start(now)

    def pulse(self, readings: Sequence[float], now: float) -> ReferenceTick:
        """Return the answer to a row of readings at a time, s; UnderstudyError if a function cannot use them."""
        basic = self.interpreter.pulse(self._row(readings), now)
        active = self.interpreter.active
        return ReferenceTick(
            tuple(machine.state for machine in active),
            tuple(-1 if machine.flag is None else self._flags[machine.flag] for machine in active),
            basic,
            self._command(basic, readings, now),
        )

    def _row(self, readings: Sequence[float]) -> list[float]:
        if not self._computes:
            return [readings[at] for at in self.hierarchy.features]
        percept = self._percept(readings)
        row = []
        with np.errstate(all="ignore"):
            for at, bound in zip(self.hierarchy.features, self._features, strict=True):
                column = readings[at] if at >= 0 else read_feature_column(bound, percept, agents=1)[0]
                row.append(float(column))
        return row

    def _prepare_functions(self) -> tuple[list[BoundFeature], list[Callable[..., Any] | None]]:
        """Prepare the functions of features and basic behaviors, in the precision of the export."""
        features = list(self.program.features)
        functions = [ground.behavior.function for ground in self.program.basics]
        if self._type is np.float64:
            return features, functions
        for index, bound in enumerate(features):
            if isinstance(bound.feature, Feature) and bound.feature.function is not None:
                computed = compute_in_single(bound.feature.function, bound.feature.parameters)
                features[index] = replace(bound, feature=replace(bound.feature, function=computed))
        for index, ground in enumerate(self.program.basics):
            if ground.behavior.function is not None:
                functions[index] = compute_in_single(ground.behavior.function, ground.behavior.parameters)
        return features, functions

    def _percept(self, readings: Sequence[float]) -> Percept:
        return {
            (slot.reading, slot.target): np.array([value], self._type)
            for slot, value in zip(self.hierarchy.readings, readings, strict=True)
        }

    def _command(self, basic: int, readings: Sequence[float], now: float) -> tuple[float, ...]:
        hierarchy, ground = self.hierarchy, self.program.basics[basic]
        if hierarchy.is_coordinator:
            issued = float(self.interpreter.behavior_start_s == now)
            values = {ORDER: float(basic if ground.behavior.order is not None else 0), ISSUED: issued}
            return tuple(values[channel.name] for channel in hierarchy.channels)
        function = self._functions[basic]
        if function is None:
            return self._commands[basic]
        percept = self._percept(readings)
        views = [ReadingsView(percept, ground.binding[each]) for each in ground.behavior.parameters]
        with np.errstate(all="ignore"):
            found = call_user_function(f"behavior {ground}", function, [ReadingsView(percept), *views])
        command = []
        for channel in hierarchy.channels:
            value = float(np.broadcast_to(found.get(channel.name, channel.rest), (1,))[0])
            if not isfinite(value):
                raise DefinitionError(
                    what=f"behavior {ground}",
                    problem="its command is not finite",
                    remedy="return finite numbers",
                )
            command.append(value)
        return tuple(command)
