"""Commands as tables: what each robot is told, checked before anything moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, UnknownName
from understudy.model.kinds import Column
from understudy.sim.kit import COLUMNS


def make_command_table(
    commands: Mapping[str, Column], *, agents: int, channels: Sequence[str], where: str
) -> NDArray[np.float64]:
    """Commands as a table [N, 5], whose columns are COLUMNS and none left out; an unusable one raises."""
    table = np.zeros((agents, len(COLUMNS)))
    for channel, column in commands.items():
        if channel not in channels:
            raise UnknownName(what="channel", name=channel, where=where, known=channels)
        table[:, COLUMNS.index(channel)] = _column(channel, column, agents)
    return table


def _column(channel: str, column: Column, agents: int) -> Column:
    try:
        values: Column = np.asarray(column, np.float64)
    except (TypeError, ValueError) as error:
        raise DefinitionError(
            what=f"command {channel!r}",
            problem=f"it is {column!r:.60}",
            remedy="give one finite number per robot",
        ) from error
    if values.shape != (agents,):
        raise DefinitionError(
            what=f"command {channel!r}",
            problem=f"it has shape {values.shape}",
            remedy=f"give one value per robot: shape ({agents},)",
        )
    wrong = np.flatnonzero(~np.isfinite(values))
    if len(wrong):
        raise DefinitionError(
            what=f"command {channel!r}",
            problem=f"it is {values[wrong[0]]} for robot {wrong[0]}",
            remedy="give finite numbers",
        )
    return values
