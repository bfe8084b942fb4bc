"""Synthetic drivers of a robot that goes to and fro before a ball: their aims, noise, and reaction times."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from understudy import DriveLesson, Library, make_candidates, make_drive_kit, read_recorded_drive, segment
from understudy.addons.recordings.lesson_from_drive import to_lesson
from understudy.records.record import Record

TICK_S = 0.05
MOVES = {"forward": {"drive": 0.8}, "back": {"drive": -0.5}}
MAP = """format = "understudy-recording-map/1"
time = "time_s"
[[readings]]
column = "range(ball)"
name = "range"
target = "ball"
unit = "m"
[[commands]]
column = "command.drive"
channel = "drive"
[behaviors.forward]
drive = 0.8
[behaviors.back]
drive = -0.5
"""


@dataclass(frozen=True)
class Driver:
    """A driver who goes back at `near` m from the ball, and forward again at 3 m.

    The stick goes `gain` of the way to its aim in a tick, with a noise, `reaction_s` after the readings. `unsure` is
    the spread (m) of the distances at which they turn.
    """

    near: float = 1.0
    noise: float = 0.03
    gain: float = 1.0
    reaction_s: float = 0.0
    unsure: float = 0.0
    seed: int = 0

    def drive(self, seconds: float = 90.0) -> list[str]:
        """Rows of a table of the drive; the robot's speed changes from turn to turn, as on slopes."""
        random = np.random.default_rng(self.seed)
        rows, seen, late = ["time_s,range(ball),command.drive"], [3.0], round(self.reaction_s / TICK_S)
        wish, stick, slope, turn = 0.8, 0.8, 1.0, self.near
        for tick in range(round(seconds / TICK_S)):
            distance = seen[max(0, len(seen) - 1 - late)]
            before = wish
            wish = -0.5 if distance < turn else 0.8 if distance > 3.0 else wish
            if wish != before:
                slope, turn = random.uniform(0.4, 1.6), self.near + self.unsure * random.normal()
            stick += self.gain * (wish - stick)
            rows.append(f"{tick * TICK_S:.2f},{seen[-1]:.4f},{stick + self.noise * random.normal():.4f}")
            seen.append(seen[-1] - TICK_S * slope * stick)
        return rows

    def write(self, path: Path, seconds: float = 90.0) -> Path:
        """Write the table, and return its path."""
        path.write_text("\n".join(self.drive(seconds)) + "\n")
        return path


ANNA = Driver(noise=0.03, gain=1.0, reaction_s=0.1, unsure=0.03, seed=1)
BEN = Driver(noise=0.12, gain=0.4, reaction_s=0.35, unsure=0.03, seed=2)
FAR = replace(BEN, near=2.0)
"""Ben, who goes back much earlier than Anna does."""


def read(path: Path) -> tuple[Record, Library]:
    """Read a drive, with a library of its readings and moves."""
    drive = read_recorded_drive(path)
    return drive, Library(make_drive_kit(drive, MOVES))


def make_lesson(path: Path, driver: str) -> DriveLesson:
    """Make a lesson of the drive of one driver."""
    drive, library = read(path)
    return to_lesson(segment(drive, make_candidates(library, drive)), driver=driver, library=library)
