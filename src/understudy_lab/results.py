"""Results of experiments: rows in a file as soon as they are computed, and comparison with what was published.

So an interrupted run can be continued.
"""

from __future__ import annotations

import gzip
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from math import isclose
from pathlib import Path
from statistics import median
from typing import Any

import msgspec

from understudy.storage.atomic_write import convert_os_errors, write_atomically
from understudy_lab.sources import PACKAGES, find_sources, hash_sources
from understudy_lab.study import Row, Study, StudyFindings, Task, find_experiment, folder_of

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


EXPECTED = ("expected.json", "expected.json.gz")
"""The possible file names of a published result; it is compressed if it would exceed a megabyte."""
CLOSE = 1e-6
"""The relative tolerance for numbers, because machines differ in their last digits; counts must agree."""
NEAR, ENOUGH = 0.2, 10
"""The allowed gap between medians of varying shares, and the number of seeds needed to compare them."""


@dataclass(frozen=True)
class StudyResult:
    """The result of a run of an experiment: its findings and the rows behind them."""

    experiment: str
    question: str
    seeds: Sequence[int]
    quick: bool
    findings: StudyFindings
    rows: Sequence[Row]


def save(result: StudyResult, path: Path) -> None:
    """Write a result to a file, one row per line; compressed if its name ends in `.gz`."""
    head = msgspec.json.format(msgspec.json.encode(replace(result, rows=[])), indent=1)
    rows = b",\n".join(msgspec.json.encode(row) for row in result.rows)
    with convert_os_errors(path, "writing the result"):
        text = head.replace(b'"rows": []', b'"rows": [\n' + rows + b"\n ]") + b"\n"
        write_atomically(path, gzip.compress(text, mtime=0) if path.suffix == ".gz" else text)


def load_published(name: str) -> StudyResult | None:
    """Return the published result of an experiment, or None if there is none."""
    path = find_published(name)
    return None if path is None else read(path)


def find_published(name: str) -> Path | None:
    """Find the file of an experiment's published result; None where there is none yet."""
    return next((path for each in EXPECTED if (path := folder_of(name) / each).is_file()), None)


def read(path: Path) -> StudyResult:
    """Read a result from a file."""
    data = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
    return msgspec.json.decode(data, type=StudyResult)


def differences(rows: Sequence[Row], published: StudyResult, experiment: Study) -> list[str]:
    """Return sentences on where rows differ from the published ones of the same tasks.

    Of values that vary between machines, only the medians over seeds are compared, if there are at least ENOUGH seeds.
    """
    differing = []
    for before, row in _pairs(rows, published):
        differing += [f"{_named(row)}: {each}" for each in _differing(before, row, experiment.varies)]
    for name, pairs in _by_all_but_seed(_pairs(rows, published)).items():
        if len(pairs) >= ENOUGH:
            differing += [f"{name}: {each}" for each in _far_apart(pairs, experiment.varies)]
    return differing


def list_uncompared(rows: Sequence[Row], published: StudyResult, experiment: Study) -> list[str]:
    """Return sentences on what `differences` cannot compare."""
    pairs = _pairs(rows, published)
    sentences = []
    if new := len(rows) - len(pairs):
        sentences.append(
            f"{new} {'piece was' if new == 1 else 'pieces were'} not published, and not compared."
        )
    few = any(len(each) < ENOUGH for each in _by_all_but_seed(pairs).values())
    if few and any(set(at) & set(experiment.varies) for _, row in pairs for at, _ in _numbers(row)):
        sentences.append(
            f"With fewer than {ENOUGH} seeds, what varies from machine to machine is not compared: "
            f"{'; '.join(experiment.varies)}."
        )
    return sentences


def _pairs(rows: Sequence[Row], published: StudyResult) -> list[tuple[Row, Row]]:
    """Return pairs of the published row and the new row of the same task."""
    by_task = {_key(row["task"]): row for row in published.rows}
    return [(by_task[_key(row["task"])], row) for row in rows if _key(row["task"]) in by_task]


def _by_all_but_seed(pairs: Sequence[tuple[Row, Row]]) -> dict[str, list[tuple[Row, Row]]]:
    groups: dict[str, list[tuple[Row, Row]]] = {}
    for before, row in pairs:
        name = " ".join(str(value) for key, value in row["task"].items() if key != "seed") or "all"
        groups.setdefault(name, []).append((before, row))
    return groups


def _far_apart(pairs: Sequence[tuple[Row, Row]], varies: Sequence[str]) -> Iterator[str]:
    """Yield the varying shares whose medians differ; numbers that are not shares are not compared."""
    both = [(dict(_numbers(before)), dict(_numbers(row))) for before, row in pairs]
    for at in both[0][0]:
        numbers = [(before[at], row[at]) for before, row in both if at in before and at in row]
        if not set(at) & set(varies) or not all(0 <= before <= 1 for before, _ in numbers):
            continue
        before, now = (median(each) for each in zip(*numbers, strict=True))
        if abs(now - before) > NEAR:
            yield f"median of {'.'.join(at)} is {now:.0%}, published was {before:.0%}"


def _numbers(value: Any, at: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], float]]:
    """Yield each number in plain data with its path."""
    if isinstance(value, Mapping | list):
        for key, each in value.items() if isinstance(value, Mapping) else enumerate(value):
            yield from _numbers(each, (*at, str(key)))
    elif isinstance(value, int | float):
        yield at, float(value)


def _differing(before: Any, now: Any, varies: Sequence[str], at: str = "") -> list[str]:
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        keys = [key for key in {**before, **now} if key not in varies]
        return [
            each
            for key in keys
            for each in _differing(before.get(key), now.get(key), varies, f"{at}.{key}" if at else str(key))
        ]
    if isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        pairs = enumerate(zip(before, now, strict=True))
        return [each for k, (a, b) in pairs for each in _differing(a, b, varies, f"{at}[{k}]")]
    if isinstance(before, float) and isinstance(now, float | int):
        same = isclose(before, now, rel_tol=CLOSE, abs_tol=CLOSE)
    else:
        same = bool(before == now)
    return [] if same else [f"{at} is {now!r:.40}, published was {before!r:.40}"]


def _named(row: Row) -> str:
    return " ".join(str(value) for value in row["task"].values())
