"""The results of a batch of runs: which worlds finished, when, and with how much food."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import Column


@dataclass(frozen=True)
class Outcomes:
    """The results of N worlds, as columns of shape [N]."""

    seconds: Column
    """Time to finish, in s. NaN if the limit came first."""
    limit_s: Column
    """Time limit of each world, in s."""
    delivered: NDArray[np.int64]
    """Units of food delivered within that time."""
    gathered: NDArray[np.int64]
    """Boxes gathered within that time."""

    @property
    def finished(self) -> NDArray[np.bool_]:
        """True for each world [N] that finished in time."""
        return ~np.isnan(self.seconds)

    @property
    def success(self) -> float:
        """The share of worlds that finished in time."""
        return float(self.finished.mean())

    @property
    def food_per_s(self) -> Column:
        """Food delivered per second until the world finished or reached its limit [N]; NaN if no time passed."""
        spent = np.where(self.finished, self.seconds, self.limit_s)
        rate: Column = np.divide(self.delivered, spent, out=np.full(len(spent), np.nan), where=spent > 0)
        return rate

    def select(self, rows: Sequence[int]) -> Outcomes:
        """Return the outcomes of some worlds, given their rows."""
        return Outcomes(*(getattr(self, each.name)[list(rows)] for each in fields(self)))

    @classmethod
    def concatenate(cls, parts: Sequence[Outcomes]) -> Outcomes:
        """Join the outcomes of several batches, in order."""
        return cls(*(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(cls)))
