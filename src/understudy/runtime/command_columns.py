"""Acting: from the basic behavior that each agent runs to the columns of commands for a body."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, UnknownName
from understudy.model.features import Percept, ReadingKey, ReadingsView, call_user_function
from understudy.model.value_kinds import Column
from understudy.runtime.body import (
    ISSUED,
    ORDER,
    SKILL,
    Body,
    OrderReceiver,
    SkillPerformer,
    list_reading_keys,
)
from understudy.runtime.feature_columns import check_float_column, check_targets
from understudy.runtime.link import GroundBehavior


class CommandColumns:
    """The commands of ground basic behaviors for one body.

    `table` [B, C] has the command of each behavior by channel. `computed` are the behaviors that are functions, for
    which the body must sense `keys`.
    """

    def __init__(self, basics: Sequence[GroundBehavior], body: Body) -> None:
        self.channels = [channel.name for channel in body.channels]
        self.rest = np.array([channel.rest for channel in body.channels])
        self.basics = tuple(basics)
        self.table = np.tile(self.rest, (len(basics), 1))
        self.computed = [index for index, ground in enumerate(basics) if ground.behavior.function]
        self.keys: tuple[ReadingKey, ...] = list_reading_keys(body) if self.computed else ()
        for index, ground in enumerate(basics):
            check_targets(body, ground.binding)
            for channel, value in ground.behavior.command.items():
                if channel not in self.channels:
                    raise self._unknown(channel, ground)
                self.table[index, self.channels.index(channel)] = value
            if SKILL in ground.behavior.command and isinstance(body, SkillPerformer):
                number = body.index_skill(ground.behavior.name, ground.binding)
                self.table[index, self.channels.index(SKILL)] = number
            if ground.behavior.order is not None:
                self.table[index, self._order(ground)] = self._numbered(body, ground)

    def commands(
        self, running: NDArray[np.intp] | NDArray[np.int32], percept: Percept, entered: Callable[[], Column]
    ) -> NDArray[np.float64]:
        """Return the commands [C, N] of agents that run the basic behaviors `running` [N] since `entered` [N]."""
        commands: NDArray[np.float64] = np.take(self.table.T, running, axis=1)  # a row per channel
        for index in self.computed:
            chosen = running == index
            if chosen.any():
                for channel, column in self._compute(index, percept, chosen).items():
                    commands[self.channels.index(channel), chosen] = column
        if ISSUED in self.channels:
            commands[self.channels.index(ISSUED)] = entered()
        return commands

    def _compute(self, index: int, percept: Percept, chosen: NDArray[np.bool_]) -> dict[str, Column]:
        """Compute the commands, by channel, of the agents that run a basic behavior which is a function."""
        ground = self.basics[index]
        function = ground.behavior.function
        if function is None:
            return {}
        targets = [
            ReadingsView(percept, ground.binding[parameter]) for parameter in ground.behavior.parameters
        ]
        result = call_user_function(f"behavior {ground}", function, [ReadingsView(percept), *targets])
        remedy = "return a command: a number for every agent, by channel"
        if not isinstance(result, Mapping):
            raise DefinitionError(
                what=f"behavior {ground}", problem=f"it returned {result!r:.60}", remedy=remedy
            )
        computed = {}
        for channel, values in result.items():
            if channel not in self.channels:
                raise self._unknown(channel, ground)
            what = f"behavior {ground}, channel {channel!r}"
            column = check_float_column(values, what=what, remedy=remedy)
            if column.shape not in ((), chosen.shape):
                problem = f"it returned shape {column.shape} for {len(chosen)} agents"
                raise DefinitionError(what=what, problem=problem, remedy=remedy)
            column = np.broadcast_to(column, chosen.shape)
            wrong = np.flatnonzero(chosen & ~np.isfinite(column))
            if len(wrong):
                raise DefinitionError(
                    what=f"behavior {ground}",
                    problem=f"its command for channel {channel!r} is not finite for agent {wrong[0]}: "
                    f"it is {column[wrong[0]]}",
                    remedy="return a finite number for every agent, or leave the channel out",
                )
            computed[channel] = column[chosen]
        return computed

    def _order(self, ground: GroundBehavior) -> int:
        if ORDER not in self.channels:
            raise self._unknown(ORDER, ground)
        return self.channels.index(ORDER)

    @staticmethod
    def _numbered(body: Body, ground: GroundBehavior) -> int:
        order = ground.behavior.order
        return (
            body.index_order(order.substitute(ground.binding))
            if isinstance(body, OrderReceiver) and order
            else 0
        )

    def _unknown(self, channel: str, ground: GroundBehavior) -> UnknownName:
        where = f"the body, for behavior {ground},"
        return UnknownName(what="channel", name=channel, where=where, known=self.channels)
