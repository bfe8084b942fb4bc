"""Conditions that can never hold, or always do, so that the property about them decides nothing."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from understudy.errors import SettingError, join_names
from understudy.judging.properties.condition import FACTORS, Clause, ClauseTest, Condition
from understudy.model.property import PropertyKind

COUNTED = ("distance(", "covered", "delivered", "gathered")
"""How subjects begin that are never below 0."""
Limit = tuple[float, bool]
"""A number, and whether it is itself left out."""


def check_condition(kind: PropertyKind, condition: Condition) -> None:
    """Refuse a condition that can never hold, and one that always holds where it must not.

    Parameters
    ----------
    kind
        The kind of the property that is about the condition.
    condition
        The condition.

    Raises
    ------
    SettingError
        If no readings satisfy one of its alternatives, or if it is to hold never, or never for long, and holds
        wherever its readings are there.
    """
    for clauses in condition.alternatives:
        for subject, own in _group(clauses).items():
            if _is_empty(subject, own):
                raise _refuse(
                    " and ".join(map(str, own)),
                    "can never hold" if len(own) == 1 else "can never hold at once",
                    "join them by 'or', or correct a limit" if len(own) > 1 else "correct the limit",
                )
    if kind is PropertyKind.ALWAYS:
        return
    alone = [clauses[0] for clauses in condition.alternatives if len(clauses) == 1]
    for subject, own in _group(alone).items():
        if _is_everything(subject, own):
            words = join_names(map(str, own), word="or")
            raise _refuse(
                words, "always holds, so that the property cannot hold", "name what must not happen"
            )


def _refuse(words: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where="condition", setting=repr(words), problem=problem, remedy=remedy)


def _group(clauses: Sequence[Clause]) -> dict[str, list[Clause]]:
    groups: dict[str, list[Clause]] = {}
    for each in clauses:
        groups.setdefault(each.subject, []).append(each)
    return groups


def _is_empty(subject: str, clauses: Sequence[Clause]) -> bool:
    """Return whether clauses about one subject exclude each other."""
    low, high = _intersect(subject, [each for each in clauses if each.comparison.is_of_number])
    if low[0] > high[0] or (low[0] == high[0] and (low[1] or high[1])):
        return True
    if any(_negate(each) in clauses for each in clauses):
        return True
    labels = {each.name for each in clauses if each.comparison is ClauseTest.LABEL and not each.negated}
    absent = any(each.comparison is ClauseTest.ABSENT and not each.negated for each in clauses)
    measured = any(each.comparison.is_of_number or each.comparison is ClauseTest.LABEL for each in clauses)
    return len(labels) > 1 or (absent and measured)


def _is_everything(subject: str, clauses: Sequence[Clause]) -> bool:
    """Return whether one of some clauses about one subject always holds, where it is measured."""
    if any(_negate(each) in clauses for each in clauses if not each.comparison.is_of_number):
        return True
    numbers = [each for each in clauses if each.comparison.is_of_number]
    if len({_measure(each)[1] for each in numbers}) != 1:
        return False
    limits = [_find_limits(each) for each in numbers]
    least: Limit = (0.0, True) if subject.startswith(COUNTED) else (-inf, True)
    if any(low <= least and high[0] == inf for low, high in limits):
        return True
    # Half lines cover all numbers if the highest from below meets the lowest from above.
    highest = max((high for low, high in limits if low[0] == -inf), key=_order_high, default=None)
    lowest = min((low for low, high in limits if high[0] == inf), default=None)
    if highest is None or lowest is None:
        return highest is not None and highest[0] == inf
    return highest[0] > lowest[0] or (highest[0] == lowest[0] and not (highest[1] and lowest[1]))


def _intersect(subject: str, clauses: Sequence[Clause]) -> tuple[Limit, Limit]:
    """Return the limits of the numbers that all clauses allow; all numbers if their units do not fit together."""
    low: Limit = (0.0, False) if subject.startswith(COUNTED) else (-inf, True)  # what is infinite is absent
    high: Limit = (inf, True)
    if len({_measure(each)[1] for each in clauses}) > 1:
        return low, high
    for each in clauses:
        lower, upper = _find_limits(each)
        low, high = max(low, lower), min(high, upper, key=_order_high)
    return low, high


def _order_high(limit: Limit) -> tuple[float, bool]:
    return limit[0], not limit[1]


def _find_limits(clause: Clause) -> tuple[Limit, Limit]:
    """Return the limits of the numbers for which a clause holds."""
    number, _ = _measure(clause)
    if clause.comparison in (ClauseTest.BELOW, ClauseTest.AT_MOST):
        return (-inf, False), (number, clause.comparison is ClauseTest.BELOW)
    return (number, clause.comparison is ClauseTest.ABOVE), (inf, False)


def _measure(clause: Clause) -> tuple[float, str]:
    """Return the limit of a clause in the first unit of its kind, and that unit."""
    for unit, factors in FACTORS.items():
        if clause.unit in factors:
            return clause.number * factors[clause.unit], unit
    return clause.number, clause.unit


def _negate(clause: Clause) -> Clause:
    return Clause(
        clause.subject, clause.comparison, clause.number, clause.unit, clause.name, not clause.negated
    )
