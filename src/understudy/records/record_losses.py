"""What each form of a file cannot hold of a record: it is said when the file is written, and stands in docs/data.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum

import numpy as np

from understudy.errors import join_names
from understudy.model.features import format_reading_label
from understudy.model.value_kinds import Toroidal
from understudy.records.record import Record


class Fact(StrEnum):
    """A fact of a record that some form of a file has no place for."""

    KINDS = "units and kinds of readings"
    PRESSES = "presses (export the table of presses)"
    RUN = "the seed and the name of the automaton (export the table of episodes)"
    LAST_COMMAND = "the command of the last tick of an episode"
    POSE = "the place of the robot"
    INFINITE = "infinite readings, which become absent"
    PRESS_KINDS = "the kinds of examples that presses recorded"


LOSSES: Mapping[str, tuple[Fact, ...]] = {
    "csv": (Fact.KINDS, Fact.PRESSES, Fact.RUN),
    "jsonl": (Fact.KINDS, Fact.PRESSES, Fact.RUN, Fact.INFINITE),
    "parquet": (Fact.PRESSES, Fact.RUN, Fact.INFINITE),
    "lerobot": (),
    "minari": (Fact.LAST_COMMAND,),
    "trace": (Fact.PRESSES, Fact.INFINITE),
    "mcap": (Fact.POSE, Fact.PRESS_KINDS),
}
"""The facts that each form cannot hold: tables of ticks by their ending, data sets, traces, and recordings of runs."""


def describe_losses(records: Sequence[Record], form: str) -> list[str]:
    """Return a sentence about each fact that records have and a form has no place for."""
    return [f"it has no place for {_describe(fact, records)}" for fact in LOSSES[form] if _has(fact, records)]


def _has(fact: Fact, records: Sequence[Record]) -> bool:
    return any(
        {
            Fact.KINDS: bool(each.readings),
            Fact.PRESSES: bool(each.presses),
            Fact.RUN: each.seed is not None or bool(each.behavior),
            Fact.LAST_COMMAND: bool(each.channels),
            Fact.POSE: bool(each.pose),
            Fact.INFINITE: any(np.isinf(column).any() for column in each.values.values()),
            Fact.PRESS_KINDS: any(press.kind is not None for press in each.presses),
        }[fact]
        for each in records
    )


def _describe(fact: Fact, records: Sequence[Record]) -> str:
    """Describe a fact; of kinds, which readings are on a circle, since that is what is misread."""
    angles = [
        format_reading_label(key)
        for key in dict.fromkeys(key for each in records for key in each.values)
        if any(key in each.values and isinstance(each.find_kind(key), Toroidal) for each in records)
    ]
    if fact is not Fact.KINDS or not angles:
        return str(fact)
    return f"{fact}, and that {join_names(angles)} {'is' if len(angles) == 1 else 'are'} on a circle; Parquet has"
