"""Reports: what the members of squads tell their coordinators, as it arrives, and who is still there to tell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from understudy.model.features import ReadingKey
from understudy.model.kinds import YES, Column
from understudy.runtime.team.comms import UP, Delayed, Radio
from understudy.runtime.team.members import Band
from understudy.runtime.team.roster import Roster

Bools: TypeAlias = NDArray[np.bool_]
SILENT_S = 1.0
"""Who has not been heard of for so long is counted no more."""


@runtime_checkable
class Failing(Protocol):
    """A body whose agents can fail: simulated robots that were frozen, squads that nobody is left of."""

    @property
    def failed(self) -> Bools:
        """Which agents are out of action [N]."""
        ...


class Reports:
    """What M members report, each of them a row of one of the bodies below. `drops` names a reading: who reads yes has
    dropped out, as who has failed or has not been heard of.
    """

    def __init__(
        self, roster: Roster, bands: Sequence[Band], radio: Radio | None, drops: str | None, tick_s: float
    ) -> None:
        self.roster, self.bands, self._radio, self._drops, self._tick_s = roster, bands, radio, drops, tick_s
        self._delayed: dict[ReadingKey | str, Delayed] = {}

    @property
    def perfect(self) -> bool:
        """Whether all arrives at once."""
        return self._radio is None

    def clear(self) -> None:
        """Nobody has reported anything yet."""
        self._delayed.clear()

    def readings(self, key: ReadingKey, now: float) -> Column:
        """What each member reads [M]; absent where it has no such reading."""
        values = np.full(len(self.roster), np.nan)
        for number, band in enumerate(self.bands):
            if key in band.layer.percept:
                there = self.roster.band == number
                values[there] = np.asarray(band.layer.percept[key])[self.roster.row[there]]
        return self._through(key, values, now)

    def flags(self, flag: str, answering: Column, issued: Column, now: float) -> Column:
        """Whose flag is up [M]. A report says when the order was given that it is about (`answering` [M]); where that
        is not the one that stands (`issued` [M]), it does not count.
        """
        up = np.zeros(len(self.roster))
        for number, band in enumerate(self.bands):
            there = self.roster.band == number
            up[there] = band.layer.runner.raised(flag)[self.roster.row[there]]
        if self._radio is None:
            return up
        up, about = self._through(f"flag {flag}", up, now), self._through("about", answering, now)
        return np.where(about == issued, up, 0.0)

    def counted(self, now: float) -> Bools:
        """Who is still there [M]: has not failed, is not stuck where that counts, has been heard of lately."""
        there = np.ones(len(self.roster), np.bool_)
        for number, band in enumerate(self.bands):
            if isinstance(band.layer.body, Failing):
                mine = self.roster.band == number
                there[mine] = ~band.layer.body.failed[self.roster.row[mine]]
        if self._radio is not None:
            heard = self._through("heard", np.where(there, now, np.nan), now)
            there = now - heard <= SILENT_S + self._radio.ticks * self._tick_s
        if self._drops is not None:
            there &= self.readings((self._drops, None), now) != YES
        return there

    def _through(self, key: ReadingKey | str, values: Column, now: float) -> Column:
        if self._radio is None:
            return values
        if key not in self._delayed:
            self._delayed[key] = Delayed(self._radio, UP)
        return self._delayed[key].through(values, round(now / self._tick_s))
