"""Rosters: who is in which squad, as rows of the bodies below."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Member(NamedTuple):
    """One member of a squad: a row of one of the bodies below, in a role (the index of each)."""

    band: int
    row: int
    role: int


@dataclass(frozen=True, eq=False)
class Roster:
    """The M members of S squads, squad after squad: their body, their row there, their role, their squad [M each]."""

    squads: int
    band: NDArray[np.intp]
    row: NDArray[np.intp]
    role: NDArray[np.intp]
    squad: NDArray[np.intp]

    @classmethod
    def of(cls, squads: Sequence[Sequence[Member]], worlds: int = 1, rows: Sequence[int] = ()) -> Roster:
        """The squads of one world, or of as many side by side, whose bodies have so many `rows` for each world."""
        members = [member for squad in squads for member in squad]
        band, row, role = np.array(members, np.intp).reshape(-1, 3).T
        squad = np.repeat(np.arange(len(squads)), [len(squad) for squad in squads])
        step = np.array(rows, np.intp)[band] if len(rows) else np.zeros_like(band)
        world = np.repeat(np.arange(worlds), len(members))
        return cls(
            worlds * len(squads),
            np.tile(band, worlds),
            np.tile(row, worlds) + world * np.tile(step, worlds),
            np.tile(role, worlds),
            np.tile(squad, worlds) + world * len(squads),
        )

    def __len__(self) -> int:
        return len(self.row)

    def of_squads(self, chosen: NDArray[np.bool_]) -> NDArray[np.intp]:
        """The members of these squads [S]."""
        return np.flatnonzero(chosen[self.squad])
