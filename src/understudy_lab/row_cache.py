"""Storage of rows in a file as soon as they are computed, so that an interrupted run can be continued."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import msgspec

from understudy.storage.atomic_write import convert_os_errors, write_atomically
from understudy_lab.sources import PACKAGES, find_sources, hash_sources
from understudy_lab.study import Row, Task, find_experiment, folder_of

NAME = "rows.jsonl"


class RowCache:
    """The rows of one experiment by task, in memory and, if a folder is given, in a file there.

    Rows that another version of the program wrote are moved aside and never mixed with new ones.

    Parameters
    ----------
    experiment
        The name of the experiment.
    folder
        The folder of the file. None: rows are only in memory.
    name
        The name of the file.
    change
        Whether rows may be added. If not, rows of another version are ignored, and the file stays as it is.
    """

    def __init__(
        self, experiment: str, folder: Path | None = None, name: str = NAME, *, change: bool = True
    ) -> None:
        self._rows: dict[bytes, Row] = {}
        self._path = None if folder is None else folder / name
        self.put_aside = False
        """Whether rows of another version were found and moved aside."""
        if self._path is None:
            return
        self._head = {"experiment": experiment, "source": fingerprint(experiment)}
        if not change:
            with convert_os_errors(self._path, "reading results"):
                self._rows = self._load(self._path) or {}
            self._path = None
            return
        with convert_os_errors(self._path, "keeping results"):
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._begin(self._path)

    def __contains__(self, task: Task) -> bool:
        return _key(task) in self._rows

    def __getitem__(self, task: Task) -> Row:
        return self._rows[_key(task)]

    def __len__(self) -> int:
        return len(self._rows)

    def keep(self, row: Row) -> None:
        """Store a row, which contains its task."""
        self._rows[_key(row["task"])] = row
        if self._path is not None:
            with convert_os_errors(self._path, "keeping a result"), self._path.open("ab") as file:
                file.write(msgspec.json.encode(row) + b"\n")

    def replace(self, rows: Sequence[Row]) -> None:
        """Replace all rows, also those in the file, by these."""
        self._rows = {_key(row["task"]): row for row in rows}
        if self._path is not None:
            lines = [self._head, *rows]
            write_atomically(self._path, b"".join(msgspec.json.encode(line) + b"\n" for line in lines))

    def _begin(self, path: Path) -> None:
        rows = self._load(path)
        if rows is None and path.exists() and path.read_bytes().strip():
            path.replace(path.with_suffix(".former.jsonl"))
            self.put_aside = True
        self.replace(list((rows or {}).values()))

    def _load(self, path: Path) -> dict[bytes, Row] | None:
        """Read the rows of a file; None if there is none of this version of the program."""
        lines = path.read_bytes().split(b"\n") if path.exists() else []
        if not lines or _read(lines[0]) != self._head:
            return None
        rows = [row for line in lines[1:] if (row := _read(line)) is not None]  # one may be cut off
        return {_key(row["task"]): row for row in rows}


def _read(line: bytes) -> dict[str, Any] | None:
    try:
        return msgspec.json.decode(line, type=dict[str, Any])
    except msgspec.DecodeError:
        return None


def _key(task: Task) -> bytes:
    return msgspec.json.encode(task, order="sorted")


@cache
def fingerprint(experiment: str) -> str:
    """Return a hash of all source files that an experiment's rows depend on."""
    return hash_sources(find_row_sources(experiment))


def find_row_sources(experiment: str) -> set[Path]:
    """Return all source files that an experiment's rows depend on."""
    own = folder_of(experiment) / "study.py"
    if own.is_file():
        return find_sources([own])
    module = sys.modules[find_experiment(experiment).work.__module__]
    package = sys.modules[module.__name__.partition(".")[0]]
    packages = [Path(path) for path in getattr(package, "__path__", ())]
    return find_sources([Path(str(module.__file__))], [*PACKAGES, *packages])
