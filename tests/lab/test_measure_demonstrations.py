"""Labels and automata are measured on demonstrations that are made here as those of PLUNDER are published."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from understudy_lab.recordings.measure_demonstrations import (
    AGREEMENT,
    LABELS,
    UNKNOWN,
    WITH_PAIRS,
    measure_folder,
)

SPEED, BRAKE, END = 12.0, -5.0, 200.0


def write_demonstration(path: Path, seed: int) -> None:
    """Write a drive to a stop sign: accelerate (0) to a speed, hold it (1), brake (2) in time."""
    random, rows = np.random.default_rng(seed), ["HA,LA.acc,pos,decMax,accMax,vMax,vel,target"]
    place, speed, last = 0.0, 0.0, 0.0
    for _ in range(60):
        brakes = END - place < speed**2 / (-2 * BRAKE) + 12
        action = 2 if brakes else 0 if speed < SPEED - 6 else 1
        acc = (min(last + 1, 4.0), last - np.clip(last, -1, 1), max(last - 1, BRAKE))[action]
        last = float(acc) + 0.1 * random.normal()
        rows.append(f"{action},{last:.4f},{place:.4f},{BRAKE},4,{SPEED},{speed:.4f},{END}")
        speed = max(0.0, speed + 0.4 * last)
        place += 0.4 * speed
    path.write_text("\n".join(rows) + "\n")


def test_shares_of_made_demonstrations(tmp_path: Path) -> None:
    (tmp_path / "stop-sign").mkdir()
    for number in range(6):
        write_demonstration(tmp_path / "stop-sign" / f"{number}.csv", number)
    measured = {row.what: row for row in measure_folder(tmp_path, "stop-sign", odd=True)}
    assert {what: len(row.shares) for what, row in measured.items()} == dict.fromkeys(
        (LABELS, UNKNOWN, AGREEMENT, WITH_PAIRS), 3
    )
    assert np.median(measured[LABELS].shares) >= 95
    assert "stop-sign   labels" in str(measured[LABELS])
