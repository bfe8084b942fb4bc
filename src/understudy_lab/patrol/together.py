"""What one teaching of four patrols together comes to in unseen worlds, and how that is told (Figure 4 C)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from understudy_lab.lesson_stats import lessons_of
from understudy_lab.patrol.evaluate import TICKS, rounds, worlds_of
from understudy_lab.patrol.four_patrols import HOMES, guarding, teach_all
from understudy_lab.patrol.metrics import cycles
from understudy_lab.patrol.tracks import Tracks, watch
from understudy_lab.statistics import told
from understudy_lab.study import Goal, Row, Table

WORLDS = 50
GOOD = 0.9
NUMBERS: Mapping[str, str] = {
    "cycles completed": "complete",
    "cycles": "cycles",
    "from capture to all told to hunt again, s": "cycle_s",
    "captures an hour": "captures_per_hour",
    "robots attacking when an intruder is caught, of 16": "attackers",
    "gathered though nothing was captured": "false_captures",
}
SHARES = ("complete", "false_captures")


def together(seed: int) -> Row:
    """One teaching of everybody, judged on its own unseen worlds."""
    taught = teach_all(seed)
    return {
        "together": judged(watch(guarding(taught, worlds_of(seed)[:WORLDS]), TICKS, homes=HOMES)),
        "lessons": [*lessons_of(taught.patrols), *lessons_of(taught.garrison)],
    }


def judged(tracks: Tracks) -> dict[str, Any]:
    """How four patrols do together: as one is judged, and how long cycles take, s (median, nine of ten)."""
    seconds = [cycle.seconds for cycle in cycles(tracks) if not np.isnan(cycle.seconds)]
    lasted = [round(float(each), 1) for each in np.quantile(seconds, (0.5, 0.9))] if seconds else None
    return {**rounds(tracks), "cycle_s": lasted}


def table(rows: Sequence[Row]) -> Table:
    """What holds over all teachings."""
    names = [lesson["name"] for lesson in rows[0]["lessons"]]
    examples = told([sum(lesson["examples"] for lesson in row["lessons"]) for row in rows])
    return Table(
        f"Four patrols under a coordinator of coordinators, {WORLDS} unseen worlds each: median (worst–best)",
        ("", "#together (C)"),
        [
            *((said, _told(rows, key)) for said, key in NUMBERS.items()),
            (f"examples for {', '.join(names[:-1])} and {names[-1]}", examples),
        ],
    )


def goal(rows: Sequence[Row]) -> Goal:
    """Nine of ten cycles."""
    complete = float(np.median(_values(rows, "complete")))
    what = "cycles completed by four squads, each with its own home"
    return Goal(what, f"{GOOD:.0%}", f"{complete:.1%}", complete >= GOOD)


def _values(rows: Sequence[Row], key: str) -> list[float]:
    found = [row["together"][key] for row in rows]
    return [each[0] if isinstance(each, list) else each for each in found if each is not None]


def _told(rows: Sequence[Row], key: str) -> str:
    digits = 0 if key in ("cycles", "captures_per_hour") else 1
    return told(_values(rows, key), digits, percent=key in SHARES)
