"""Conditions in words, as descriptions of trees write them: "distance_to(station) is below 0.5 m and at_station is no".

A condition is one or more clauses. A clause compares a subject with a number, a label or a region; a clause without a
subject is about that of the clause before. "and" binds closer than "or".
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum
from math import isinf, pi

from understudy.errors import SettingError, join_names


class ClauseTest(StrEnum):
    """The test that a clause makes of its subject."""

    BELOW = "below"
    AT_MOST = "at most"
    AT_LEAST = "at least"
    ABOVE = "above"
    LABEL = "label"  # the subject has this label, such as yes
    ABSENT = "absent"
    IN = "in"  # it is in this region of the scenario
    RAISED = "raised"  # it is a flag that is up
    REACHED = "reached"  # it is the goal of the scenario

    @property
    def is_of_number(self) -> bool:
        """True if the subject is compared with a number."""
        return self in (ClauseTest.BELOW, ClauseTest.AT_MOST, ClauseTest.AT_LEAST, ClauseTest.ABOVE)


@dataclass(frozen=True, slots=True)
class Clause:
    """One test of one subject, such as "front is below 0.2 m".

    Parameters
    ----------
    subject
        What is tested: a feature or reading with its target, a flag, the goal, "distance(robot, food)", or a kind of
        things, "robot".
    comparison
        The test.
    number
        The threshold of a comparison with a number.
    unit
        Its unit; empty without one.
    name
        The label or region that is compared with.
    negated
        Whether the test must fail.
    """

    subject: str
    comparison: ClauseTest
    number: float = 0.0
    unit: str = ""
    name: str = ""
    negated: bool = False

    def __str__(self) -> str:
        no = "not " if self.negated else ""
        if self.comparison.is_of_number:
            unit = "" if not self.unit else self.unit if self.unit == "°" else f" {self.unit}"
            return f"{self.subject} is {self.comparison} {self.number:g}{unit}"
        if self.comparison is ClauseTest.IN:
            return f"{self.subject} is {no}in {self.name}"
        word = self.name if self.comparison is ClauseTest.LABEL else self.comparison
        return f"{self.subject} is {no}{word}"


@dataclass(frozen=True, slots=True)
class Condition:
    """A condition: it holds where all clauses of one of its alternatives hold."""

    alternatives: tuple[tuple[Clause, ...], ...]

    def __str__(self) -> str:
        return " or ".join(" and ".join(map(str, clauses)) for clauses in self.alternatives)

    @property
    def single(self) -> Clause | None:
        """Its only clause; None if there are several."""
        ((first, *others), *more) = self.alternatives
        return None if others or more else first


_NUMBER = r"[-−+]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|inf(?:inity)?\b|∞)"
_COMPARED = re.compile(rf"(below|at most|at least|above)\s+({_NUMBER})\s*(\S*)")
_IN = re.compile(r"(not\s+)?in\s+([\w-]+)")
_WORD = re.compile(r"(not\s+)?(?!(?:below|above|in)$)([\w-]+)")
_BETWEEN = re.compile(r"\bbetween (.+?) and ((?:(?! and | or ).)+)")
_REMEDY = (
    "write it as 'front is below 0.2 m', 'distance(robot, food) is at least 1 m', 'at_station is yes', "
    "'robot is in REGION', 'done is raised' or 'goal is reached', joined by and, or"
)


def parse_condition(text: str) -> Condition:
    """Parse a condition in words.

    Parameters
    ----------
    text
        The condition.

    Returns
    -------
    Condition
        The same as clauses. Names are not checked.

    Raises
    ------
    SettingError
        If a clause cannot be understood.
    """
    spread = _BETWEEN.sub(r"at least \1 and below \2", " ".join(text.split()))
    subject = ""
    alternatives = []
    for each in spread.split(" or "):
        clauses = []
        for part in each.split(" and "):
            clause = _parse_clause(part.strip(), subject, text)
            subject = clause.subject
            clauses.append(clause)
        alternatives.append(tuple(clauses))
    return Condition(tuple(alternatives))


def _parse_clause(part: str, subject: str, whole: str) -> Clause:
    before, verb, rest = part.partition(" is ")
    if verb:
        subject = before.strip()
    else:
        rest = part
    rest = rest.strip()
    if subject and (match := _COMPARED.fullmatch(rest)):
        number = float(match[2].replace("−", "-").replace("∞", "inf"))
        return Clause(subject, ClauseTest(match[1]), number=number, unit=match[3])
    if subject and (match := _IN.fullmatch(rest)):
        return Clause(subject, ClauseTest.IN, name=match[2], negated=bool(match[1]))
    if subject and (match := _WORD.fullmatch(rest)):
        word, negated = match[2], bool(match[1])
        for comparison in (ClauseTest.ABSENT, ClauseTest.RAISED, ClauseTest.REACHED):
            if word == comparison:
                return Clause(subject, comparison, negated=negated)
        return Clause(subject, ClauseTest.LABEL, name=word, negated=negated)
    place = f"in {whole!r:.80}, {part!r:.60}" if part != whole else f"{whole!r:.80}"
    raise SettingError(where="condition", setting=place, problem="cannot be understood", remedy=_REMEDY)


FACTORS = {
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "s": {"s": 1.0, "ms": 0.001, "min": 60.0},
    "rad": {"rad": 1.0, "°": pi / 180.0, "deg": pi / 180.0},
    "m/s": {"m/s": 1.0, "cm/s": 0.01},
    "rad/s": {"rad/s": 1.0, "°/s": pi / 180.0, "deg/s": pi / 180.0},
}
"""By the unit of a reading, the number of it in each unit that a threshold can have."""


def convert_threshold(number: float, unit: str, *, of: str, to: str) -> float:
    """Convert a threshold to the unit of what it is compared with.

    Parameters
    ----------
    number
        The threshold.
    unit
        Its unit, as written; empty without one.
    of
        The words for what it is compared with, for errors.
    to
        The unit of that; empty if it has none.

    Returns
    -------
    float
        The threshold in the unit `to`.

    Raises
    ------
    SettingError
        If the unit is missing, does not fit, or is needless.
    """
    factors = FACTORS.get(to, {to: 1.0} if to else {"": 1.0})
    if unit in factors:
        return number * factors[unit]
    if isinf(number) and not unit:
        return number
    written = f"{number:g}{'' if unit == '°' else ' '}{unit}" if unit else f"{number:g}"
    in_one_of = f"write it in {join_names(factors, word='or')}"
    if not to:
        problem, remedy = f"{written!r} has a unit, but {of} has none", f"write {number:g}"
    elif not unit:
        problem = f"{written!r} has no unit, but {of} is in {to}"
        remedy = f"write {_join(number, to)}" if len(factors) == 1 else in_one_of
    else:
        problem, remedy = f"{written!r} does not fit: {of} is in {to}", in_one_of
    raise SettingError(where="condition", setting="threshold", problem=problem, remedy=remedy)


def _join(number: float, unit: str) -> str:
    return f"{number:g} {unit}"
