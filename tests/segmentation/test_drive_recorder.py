"""Recorders of drives: whatever is added in whatever episodes comes out again, and later ticks change nothing."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from understudy.addons.recordings.drive_recorder import DriveRecorder
from understudy.model.value_kinds import Continuous
from understudy.runtime.body import Channel, Commands, Reading


class Cart:
    """A cart with two readings, of which one is about a ball, and one channel."""

    agents = 1
    readings = (Reading("x", Continuous(), "m"), Reading("range", Continuous(), "m", of_targets=True))
    targets = ("ball",)
    channels = (Channel("drive"),)
    tick_s = 0.1
    time_s = 0.0

    def sense(
        self, keys: object
    ) -> dict[tuple[str, str | None], np.ndarray[tuple[int], np.dtype[np.float64]]]:
        raise NotImplementedError

    def act(self, commands: Commands) -> None:
        raise NotImplementedError


def add(recorder: DriveRecorder, tick: int) -> None:
    recorder.add(tick / 10, [tick, -tick], [tick / 2], (tick, 2 * tick, 3))


@given(st.lists(st.integers(0, 300), max_size=6))
def test_episodes_of_any_length(lengths: list[int]) -> None:
    recorder, tick = DriveRecorder(Cart(), "0"), 0
    for number, length in enumerate(lengths):
        if number:
            recorder.begin_episode(str(number))
        for _ in range(length):
            add(recorder, tick)
            tick += 1
    drive = recorder.make_drive()
    assert recorder.keys == (("x", None), ("range", "ball"))
    assert drive.ticks == recorder.ticks == sum(lengths)
    np.testing.assert_array_equal(drive.values["x", None], np.arange(tick))
    np.testing.assert_array_equal(drive.values["range", "ball"], -np.arange(tick))
    np.testing.assert_array_equal(drive.commands, np.arange(tick)[:, None] / 2)
    np.testing.assert_array_equal(recorder.list_places()[:, 1], 2 * np.arange(tick))
    ends = np.cumsum([0, *lengths]).tolist()
    assert [(each.source, each.first, each.end) for each in drive.episodes] == [
        (str(number), ends[number], ends[number + 1]) for number, length in enumerate(lengths) if length
    ]


def test_a_drive_does_not_change_later() -> None:
    recorder = DriveRecorder(Cart())
    add(recorder, 1)
    before = recorder.make_drive()
    for tick in range(2, 1000):
        add(recorder, tick)
    assert before.ticks == 1
    assert before.times.tolist() == [0.1]
    assert before.commands.tolist() == [[0.5]]
    assert before.episodes[0].end == 1
