"""Teach until it holds: whether what was taught works in a wanted share of new worlds, and if not, where it goes wrong.

Each version of an automaton is tested in worlds of its own, one batch after the other, until an interval that is valid
at every look lies on one side of the wanted share. A world in which it went wrong is the next situation to teach in; it
never counts for a later version. The best version so far is kept, since a press can make it worse.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count, islice

from understudy.addons.checks.falsification.new_worlds import JudgedWorlds, Mistake
from understudy.judging.intervals import count_fewest_trials, interval_of_share_at_any_time
from understudy.judging.properties.run_property import Verdict
from understudy.judging.rollout import Progress, skip_progress
from understudy.learning.fisher_test import compute_fisher_p
from understudy.model.library import Library

WANTED = 0.95
"""The share of new worlds in which a behavior has to work."""
ERROR = 0.05
"""The probability with which anything that is said about any version of an automaton may be wrong, all together."""
MORE_WORLDS = 50
"""The number of worlds that are added at a time while it is not decided."""
MOST_WORLDS = 1_000
"""The largest number of worlds for one version."""
WORSE_P = 0.001
"""The p-value up to which a version is said to work in fewer worlds than the best before (Fisher's exact test).

No world is run twice, so the worlds of two versions are independent samples. That the best of several is picked, and
that each test ends as soon as it decides, makes small values likelier: of ten equal versions, one looks worse at 0.01
in a quarter of all lessons, at 0.001 in 1 to 4 of 100. Intervals at any time that lie apart would be wrong more rarely,
but overlook most falls from 90 to 80 %.
"""


@dataclass(frozen=True, slots=True, eq=False)
class HoldingResult:
    """The result of testing one version of an automaton in new worlds.

    Parameters
    ----------
    library
        The library with this version.
    verdict
        Whether it works in the wanted share of worlds.
    held
        The number of worlds in which it works.
    worlds
        The number of worlds that were run.
    interval
        An interval of the share, valid at every look, and for all versions together.
    mistakes
        The worlds in which it does not work.
    """

    library: Library
    verdict: Verdict
    held: int
    worlds: int
    interval: tuple[float, float]
    mistakes: tuple[Mistake, ...]

    @property
    def share(self) -> float:
        """The share of worlds in which it works."""
        return self.held / self.worlds

    def is_worse(self, than: HoldingResult) -> bool:
        """Return whether it works in fewer worlds than another version, by more than chance."""
        failed, former = self.worlds - self.held, than.worlds - than.held
        return compute_fisher_p(failed, self.worlds, former, than.worlds) <= WORSE_P


@dataclass
class HoldingTest:
    """Tests versions of an automaton, each in new worlds, until it is decided whether it works in a share of them.

    Parameters
    ----------
    make_worlds
        Makes the worlds of some seeds.
    first_seed
        The first seed. Each world is run for one version only.
    wanted
        The share of worlds in which it has to work.
    avoided
        Seeds of worlds that are not evidence, such as those taught in; it is looked at whenever seeds are chosen.
    """

    make_worlds: Callable[[Sequence[int]], JudgedWorlds]
    first_seed: int
    wanted: float = WANTED
    avoided: Collection[int] = ()
    versions: int = 0
    """The number of versions that were tested."""
    best: HoldingResult | None = None
    """The result with the largest share of worlds in which it works, of several the last; None before the first."""
    _seeds: Iterator[int] = field(init=False)

    def __post_init__(self) -> None:
        self._seeds = (seed for seed in count(self.first_seed) if seed not in self.avoided)

    def test(
        self,
        library: Library,
        behavior: str,
        bindings: Sequence[Mapping[str, str]],
        *,
        progress: Progress = skip_progress,
    ) -> HoldingResult:
        """Test the next version.

        Parameters
        ----------
        library
            The library with this version.
        behavior
            Name of the behavior.
        bindings
            The targets that it is run with, in turn.
        progress
            Function called repeatedly with the number of completed worlds and their total; an exception that it raises
            ends the test.

        Returns
        -------
        HoldingResult
            The result: undecided if MOST_WORLDS worlds did not decide it.

        Raises
        ------
        SettingError
            If the behavior has no goal of its own, and the scenario none.
        UnboundParameter
            If a parameter is not bound to a target.
        """
        self.versions += 1
        level = 1.0 - ERROR / (self.versions * (self.versions + 1))  # these sum up to ERROR
        held, worlds, mistakes = 0, 0, list[Mistake]()
        size = count_fewest_trials(self.wanted, level=level)
        while True:
            for number, binding in enumerate(bindings):
                some = list(islice(self._seeds, len(range(number, size, len(bindings)))))
                results = self.make_worlds(some).run(library, behavior, binding, progress=progress)
                held, worlds = held + int(results.works.sum()), worlds + len(some)
                mistakes += results.mistakes
            low, high = interval_of_share_at_any_time(held, worlds, level=level)
            verdict = Verdict.HOLDS if low >= self.wanted else Verdict.UNDECIDED
            verdict = Verdict.FAILS if high < self.wanted else verdict
            if verdict is not Verdict.UNDECIDED or worlds >= MOST_WORLDS:
                break
            size = MORE_WORLDS
        result = HoldingResult(library, verdict, held, worlds, (low, high), tuple(mistakes))
        if self.best is None or result.share >= self.best.share:
            self.best = result
        return result

    def find_better(self, result: HoldingResult) -> HoldingResult | None:
        """Return the best result if another one has fewer worlds in which it works, by more than chance."""
        return self.best if self.best is not None and result.is_worse(self.best) else None
