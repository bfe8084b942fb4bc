"""Long runs: a studio with a viewer that watches for hours keeps no more than it needs."""

from __future__ import annotations

import gc
import json
from pathlib import Path
from sys import stderr

import pytest
from tests.make.studios import GOTO, Wall, make_studio

HOURS = 8
MOST_GROWTH = 2**20
"""Bytes per simulated hour over the second half."""


def resident() -> int:
    gc.collect()
    pages = Path("/proc/self/statm").read_text().split()[1]
    return int(pages) * 4096


@pytest.mark.soak
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs Linux's /proc")
def test_hours_of_fast_time(tmp_path: Path) -> None:
    wall = Wall()
    made = make_studio(tmp_path, wall=wall)
    viewer = made.connect(None)

    def say(message: dict[str, object]) -> None:
        made.handle_text(viewer, json.dumps({"id": 1, **message}))

    say(GOTO)
    say({"do": "speed", "speed": 16})
    say({"do": "press", "state": "rotate_left"})
    shown, sizes = 0, []
    for _ in range(HOURS):
        for beat in range(3600 * 60 // 16):
            wall.now += 1 / 60
            made.run_due_ticks()
            while viewer.next():
                shown += 1
            if beat % 1000 == 0:
                say({"do": "press", "state": ("forward", "rotate_left")[beat // 1000 % 2]})
                say({"do": "undo"})
        sizes.append(resident())
    made.host.close()
    assert made.host.world.time_s == pytest.approx(HOURS * 3600, rel=0.01)
    assert shown > 10_000
    stderr.write(f"the server held, bytes after each hour: {sizes}\n")
    assert (sizes[-1] - sizes[HOURS // 2 - 1]) / (HOURS / 2) < MOST_GROWTH, sizes
