"""Lessons with the pairs of readings that are worth it, and what is said about them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from understudy.addons.recordings.lesson_from_drive import DriveLesson
from understudy.addons.recordings.propose_pairs import PairSearch, TakenPairs, propose_pairs
from understudy.addons.recordings.rerun_drive import LeftOut, measure_agreement
from understudy.addons.recordings.segment import Segmentation
from understudy.errors import join_names
from understudy.model.drawing import format_number_of
from understudy.model.features import BoundFeature


@dataclass(frozen=True, slots=True)
class TakenPairRow:
    """Pairs of readings that were taken, what they take the place of, and the ticks repeated before and after that."""

    pairs: list[str]
    instead_of: list[str]
    repeated_before: int
    repeated: int


@dataclass(frozen=True, slots=True)
class PairReport:
    """A search for pairs of readings as plain data.

    `taken` are the pairs that are features of the lesson. `fitting` is the number of pairs with fitting units, and
    `tried` that of those that were tried. `repeated` of `ticks` are repeated by automata that were learned without
    `left_out`.
    """

    taken: list[TakenPairRow]
    fitting: int
    tried: int
    left_out: LeftOut
    repeated: int
    ticks: int

    def list_sentences(self) -> Iterator[str]:
        """Yield what was tried and taken, in sentences."""
        were = "was" if self.tried == 1 else "were"
        fitting = format_number_of(self.fitting, "pair")
        tried = f"Of {fitting} of readings with fitting units, {self.tried} {were} tried"
        unseen = f"{format_number_of(self.ticks, 'tick')} of {self.left_out} left out of learning"
        if not self.taken:
            yield f"{tried}: with none of them, clearly more than {self.repeated} of {unseen} are repeated."
            return
        yield f"{tried}."
        for each in self.taken:
            verb = "is a feature" if len(each.pairs) == 1 else "are features"
            instead = f" instead of {join_names(each.instead_of)}" if each.instead_of else ""
            yield (
                f"{join_names(each.pairs)} {verb}{instead}: with that, {each.repeated} instead of "
                f"{each.repeated_before} of {unseen} are repeated."
            )


def take_pairs(
    segmentation: Segmentation,
    drive_lesson: DriveLesson,
    sides: Sequence[BoundFeature],
    make: Callable[[Sequence[BoundFeature]], DriveLesson],
    *,
    targets: Mapping[str, str] = MappingProxyType({}),
    report: Callable[[int, int], None] = lambda done, of: None,
) -> tuple[DriveLesson, PairReport]:
    """Search for pairs of readings that are worth it, and make the lesson again with them.

    Parameters
    ----------
    segmentation
        The drive with its labels.
    drive_lesson
        The lesson without them.
    sides
        Features that are readings, which may be sides of pairs.
    make
        Makes a lesson with the features that it gets, which name targets, not parameters.
    targets
        Targets of the automaton's parameters, by parameter.
    report
        Called after each measurement with the number of those done, and of all in this round.

    Returns
    -------
    tuple
        The lesson with the pairs, or the same one if no pair is worth it; and what was tried.
    """
    search = propose_pairs(segmentation, drive_lesson, sides, targets=targets, report=report)
    if not search.taken:
        return drive_lesson, _describe(search, (), search.agreement.repeated)
    grounded = [BoundFeature(each.feature, each.binding.substitute(targets)) for each in search.features]
    again = make(grounded)
    # Examples are made again, since which of them are in doubt depends on the values of all features.
    repeated = measure_agreement(segmentation, again, targets=targets).repeated
    before = search.taken[0].before.repeated
    if repeated <= before:
        return drive_lesson, _describe(search, (), before)
    return again, _describe(search, search.taken, repeated)


def _describe(search: PairSearch, taken: Sequence[TakenPairs], repeated: int) -> PairReport:
    rows = [
        TakenPairRow(
            list(map(str, each.features)),
            list(map(str, each.instead_of)),
            each.before.repeated,
            repeated if each is taken[-1] else each.after.repeated,
        )
        for each in taken
    ]
    return PairReport(
        rows, search.fitting, search.tried, search.agreement.left_out, repeated, search.agreement.ticks
    )
