"""Where behaviors raised a flag, beside where it was shown: success by a flag is the robot's own word.

A feature is read when the flag is raised, and compared with the values at which the demonstrator pressed it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from understudy.judging.behavior_run import BehaviorRun
from understudy.judging.rollout import Instant, Monitor
from understudy.learning.shown_ranges import ShownRange, describe_range, find_shown_range
from understudy.model.library import Library
from understudy.model.value_kinds import Column


@dataclass(frozen=True)
class RaisedRange:
    """The values of a feature at which agents raised a flag, in N worlds.

    Parameters
    ----------
    flag
        The flag.
    shown
        The values at which it was pressed.
    values
        The value in each world [N, agents]; NaN where the flag was not raised in time, or the feature was absent.
    raised
        In which worlds it was raised by all agents [N].
    """

    flag: str
    shown: ShownRange
    values: NDArray[np.float64]
    raised: NDArray[np.bool_]

    @property
    def agrees(self) -> NDArray[np.bool_]:
        """In which worlds all agents raised the flag at values that agree with what was shown [N]."""
        inside: NDArray[np.bool_] = self.raised & self.shown.contains(self.values).all(axis=1)
        return inside

    @property
    def elsewhere(self) -> int:
        """The number of worlds in which the flag was raised at a value that was not shown."""
        return int((self.raised & ~self.agrees).sum())

    @property
    def beyond(self) -> int:
        """The number of worlds in which the flag was raised beyond what was shown, where nothing says that it is wrong.

        People do not press at the same place twice, so values close to those shown do not count.
        """
        return int((self.agrees & ~self.shown.is_near(self.values).all(axis=1)).sum())

    @property
    def leaves_shown(self) -> bool:
        """Whether the flag was raised where it was not shown, in any world."""
        return self.elsewhere > 0 or self.beyond > 0

    def describe(self) -> str:
        """Return what happened in words: "done at 0.11 to 0.46 m of distance_to(A), shown at 0.17 to 0.44 m"."""
        feature, ends = self.shown.feature, self.find_ends()
        if ends is None:
            return f"{self.flag} was never raised; it was shown where {feature} is {self.shown.describe()}"
        counts = {"elsewhere": self.elsewhere, "beyond that": self.beyond}
        away = ", ".join(f"{where} in {count}" for where, count in counts.items() if count)
        away = f"; {away} of {int(self.raised.sum())} worlds" if away else ""
        where = f"{self.flag} where {feature} is {describe_range(feature, *ends)}"
        return f"{where}, shown at {self.shown.describe()}{away}"

    def find_ends(self) -> tuple[float, float] | None:
        """Return the first and the last value at which the flag was raised; None if it never was, or all are absent."""
        present = self.values[self.raised]
        present = present[~np.isnan(present)]
        return self.shown.find_ends(present) if len(present) else None

    @classmethod
    def concatenate(cls, parts: list[Self]) -> Self:
        """Join the results of several batches of worlds, in order."""
        values = np.concatenate([each.values for each in parts])
        return replace(parts[0], values=values, raised=np.concatenate([each.raised for each in parts]))


class RaisedReader(Monitor):
    """Observer that reads the values of a feature at which agents raise a flag.

    Parameters
    ----------
    run
        The behavior in B worlds.
    flag
        The flag.
    shown
        The values at which it was pressed.
    is_alone
        Whether nothing else moves what an agent reads once it has raised the flag, as it stays where it is then.
        Otherwise what an agent decided on are the values of the look before.
    stride
        The number of ticks between two looks; 1 unless it `is_alone`.
    """

    def __init__(
        self, run: BehaviorRun, flag: str, shown: ShownRange, *, is_alone: bool, stride: int = 1
    ) -> None:
        super().__init__(run.worlds, stride=stride)
        self.flag, self.shown = flag, shown
        self._run, self._read, self._is_alone = run, run.find_reading(str(shown.feature)).read, is_alone
        self._before: Column | None = None
        self._were = np.zeros((run.worlds, 1), np.bool_)
        self._values = np.full((run.worlds, 1), np.nan)

    def look(self, now: Instant) -> None:
        """Read the values of agents that have raised the flag since the last look."""
        values, raised = self._read(), self._run.find_raised_agents(self.flag)
        if self._before is None:
            self._before, self._values, self._were = (
                values,
                np.full_like(values, np.nan),
                np.zeros_like(raised),
            )
        new = raised & ~self._were
        self._values[new] = (values if self._is_alone else self._before)[new]
        self._before, self._were = values, raised

    def finish(self, raised: NDArray[np.bool_]) -> RaisedRange:
        """Return the results, given in which worlds the flag was raised in time [B]."""
        values = np.where(raised[:, None], self._values, np.nan)
        return RaisedRange(self.flag, self.shown, values, raised)


def describe_raised(flag: str | None, raised: RaisedRange | None) -> str:
    """Return where a flag that counts as success was raised, or that it counts anywhere; empty without a flag."""
    if raised is not None:
        return raised.describe()
    return f"{flag} counts wherever it is raised: nothing shown says where it is right" if flag else ""


def find_shown_goal(library: Library, behavior: str, flag: str | None) -> ShownRange | None:
    """Find at which values of which feature a behavior's flag was pressed; None if its lesson does not say."""
    taught = library.taught.get(behavior)
    lesson = None if taught is None else taught.lesson
    return None if lesson is None or flag is None else find_shown_range(lesson, flag)
