"""Libraries that lie near a folder that is none."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from understudy.errors import join_names
from understudy.storage.library_folder import VERSIONS, count_automata

MOST_FOLDERS, MOST_NAMED, DEEPEST = 2000, 5, 3
"""How many folders are looked at, how many libraries are named, and how many levels below a folder are looked at."""


def describe_near_libraries(named: Path, command: str) -> list[str]:
    """Return a sentence that names the libraries near a folder that is none, and how to name one; else nothing."""
    found = find_near_libraries(named)
    if not found:
        return []
    shown = [f"{folder} ({_count(number)})" for folder, number in list(found.items())[:MOST_NAMED]]
    rest = [f"{len(found) - len(shown)} more"] if len(found) > len(shown) else []
    first = str(next(iter(found)))
    if " " in first:
        first = f"'{first}'"
    return [f"Libraries near: {join_names([*shown, *rest])}. Name one of them: {command} {first}"]


def _count(number: int) -> str:
    return f"{number} automaton" if number == 1 else f"{number} automata"


def find_near_libraries(named: Path) -> dict[Path, int]:
    """Find the libraries in the folders below and beside the working folder and a named one, nearest first.

    Parameters
    ----------
    named
        A folder that is no library, or that is not there.

    Returns
    -------
    dict
        The number of automata of each, by its folder as it can be named from here.
    """
    here = Path()
    bases = [here, named, named.parent, here.absolute().parent, named.absolute().parent.parent]
    found: dict[Path, int] = {}
    left = MOST_FOLDERS
    looked: set[Path] = set()
    for base in bases:
        for folder in _walk(base, DEEPEST if base in (here, named) else DEEPEST - 1):
            if left == 0:
                return found
            left -= 1
            real = folder.resolve()
            if real in looked:
                continue
            looked.add(real)
            inside = any(parent.resolve() in map(Path.resolve, found) for parent in folder.absolute().parents)
            if not inside and (number := count_automata(folder)):
                found[Path(os.path.relpath(folder))] = number
    return found


def _walk(base: Path, depth: int) -> Iterator[Path]:
    """Yield a folder and those in it, level by level, without hidden ones and former versions."""
    level = [base] if base.is_dir() else []
    for _ in range(depth + 1):
        yield from level
        level = [child for folder in level for child in _list_folders(folder)]


def _list_folders(folder: Path) -> list[Path]:
    try:
        found = sorted(each for each in folder.iterdir() if each.is_dir() and not each.is_symlink())
    except OSError:
        return []
    return [each for each in found if each.name[0] != "." and each.name not in (VERSIONS, "node_modules")]
