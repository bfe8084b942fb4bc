"""What an experiment came to when it was published, and whether a run comes to the same."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isclose
from pathlib import Path
from typing import Any

import msgspec

from understudy.experiments.catalog import folder_of
from understudy.experiments.experiment import Experiment, Findings, Row
from understudy.model.atomic import failing, write

EXPECTED = "expected.json"
CLOSE = 1e-6
"""Machines differ in their last digits; counts must agree."""


@dataclass(frozen=True)
class Result:
    """A run of an experiment: its findings with the rows behind them."""

    experiment: str
    question: str
    seeds: Sequence[int]
    quick: bool
    findings: Findings
    rows: Sequence[Row]


def save(result: Result, path: Path) -> None:
    """Put a result in a file, a row a line."""
    head = msgspec.json.format(msgspec.json.encode(replace(result, rows=[])), indent=1)
    rows = b",\n".join(msgspec.json.encode(row) for row in result.rows)
    with failing(path, "writing the result"):
        write(path, head.replace(b'"rows": []', b'"rows": [\n' + rows + b"\n ]") + b"\n")


def published(name: str) -> Result | None:
    """The published result; None where there is none yet."""
    path = folder_of(name) / EXPECTED
    if not path.is_file():
        return None
    return read(path)


def read(path: Path) -> Result:
    """A result out of a file."""
    return msgspec.json.decode(path.read_bytes(), type=Result)


def differences(rows: Sequence[Row], known: Result, experiment: Experiment) -> list[str]:
    """Where rows are not as the published ones of the same tasks, in words; rows that were not published are new."""
    by_task = {_task(row): row for row in known.rows}
    found = []
    for row in rows:
        before = by_task.get(_task(row))
        if before is not None:
            found += [f"{_named(row)}: {each}" for each in _differing(before, row, experiment.varies)]
    return found


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


def _task(row: Row) -> bytes:
    return msgspec.json.encode(row["task"], order="sorted")


def _named(row: Row) -> str:
    return " ".join(str(value) for value in row["task"].values())
