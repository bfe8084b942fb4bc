"""Lists of failing worlds: all that a folder has, the worst first, and after each the one that differs most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot
from pathlib import Path

from understudy.errors import UnderstudyError
from understudy.falsification.failing_world import FACTS_FILE, FailingWorld, read_failing_world
from understudy.storage.atomic_write import convert_os_errors


@dataclass(frozen=True, slots=True)
class FailureList:
    """The failing worlds of a folder, in order, and a sentence about each that cannot be read."""

    worlds: tuple[FailingWorld, ...]
    problems: tuple[str, ...] = ()


def list_failing_worlds(folder: Path | str) -> FailureList:
    """List the failing worlds that a folder has, in the order in which they are best corrected.

    See `order_failing_worlds` for the order. A world that cannot be read is left out, and a sentence says why.

    Parameters
    ----------
    folder
        The folder, such as `failures`. If there is none, the list is empty.

    Returns
    -------
    FailureList
        The failing worlds, and what is wrong with those that cannot be read.

    Raises
    ------
    FileError
        If the folder cannot be read.
    """
    folder = Path(folder)
    if not folder.exists():
        return FailureList(())
    with convert_os_errors(folder, "reading the failing worlds", remedy="name a folder"):
        found = sorted(each for each in folder.iterdir() if (each / FACTS_FILE).is_file())
    worlds, problems = list[FailingWorld](), list[str]()
    for each in found:
        try:
            worlds.append(read_failing_world(each))
        except UnderstudyError as error:
            problems.append(str(error))
    return FailureList(order_failing_worlds(worlds), tuple(problems))


def order_failing_worlds(worlds: Sequence[FailingWorld]) -> tuple[FailingWorld, ...]:
    """Order failing worlds: the worst first, then always the one that differs most from those before it.

    The worst is the one with the least robustness. So the first few show different mistakes, and a mistake that many
    worlds share comes once before it comes again. If two differ equally, the worse of them comes first.

    Parameters
    ----------
    worlds
        The failing worlds.

    Returns
    -------
    tuple[FailingWorld, ...]
        The same worlds in order.
    """
    left = sorted(worlds, key=lambda each: (each.facts.robustness, each.folder.name))
    found = left[:1]
    left = left[1:]
    apart = [compare_failures(each, found[0]) for each in left]
    while left:
        row = apart.index(max(apart))  # the first is the worst of those that are as far
        found.append(left.pop(row))
        apart.pop(row)
        apart = [
            min(known, compare_failures(each, found[-1])) for known, each in zip(apart, left, strict=True)
        ]
    return tuple(found)


def compare_failures(one: FailingWorld, other: FailingWorld) -> float:
    """Compute how much two failures differ, from 0 to about 3.

    It is the distance of the places where they went wrong, in diagonals of the larger arena, plus 1 if the robots were
    in different innermost states, plus 1 if different behaviors or properties failed. A place that was not kept counts
    as the same place.

    Parameters
    ----------
    one
        A failing world.
    other
        The one that it is compared with.

    Returns
    -------
    float
        The difference.
    """
    mine, its = one.facts, other.facts
    found = float(mine.states[-1:] != its.states[-1:])
    found += (mine.behavior, mine.property) != (its.behavior, its.property)
    if mine.place is not None and its.place is not None:
        diagonal = max(hypot(*each.trial.scenario.size) for each in (one, other))
        found += hypot(mine.place[0] - its.place[0], mine.place[1] - its.place[1]) / diagonal
    return found
