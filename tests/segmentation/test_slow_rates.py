"""Drives of few rows a second, in which a stay is a few ticks long."""

from pathlib import Path

import numpy as np
import pytest

from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.addons.recordings.propose_behaviors import make_constant_candidate
from understudy.addons.recordings.segment import segment

TO_AND_FRO = [
    make_constant_candidate("forward", {"drive": 0.8}),
    make_constant_candidate("back", {"drive": -0.5}),
]


@pytest.mark.parametrize(("rate_hz", "stay"), [(1, 3), (1, 4), (2, 6), (5, 12), (200, 400)])
def test_stays_of_any_number_of_ticks_are_explained(tmp_path: Path, rate_hz: int, stay: int) -> None:
    meant = [tick // stay % 2 for tick in range(10 * stay)]
    rows = [f"{tick / rate_hz},{(0.8, -0.5)[each]}" for tick, each in enumerate(meant)]
    (tmp_path / "drive.csv").write_text("\n".join(["time_s,command.drive", *rows]))
    found = segment(read_recorded_drive(tmp_path / "drive.csv"), TO_AND_FRO)
    np.testing.assert_array_equal(found.labels, meant)
