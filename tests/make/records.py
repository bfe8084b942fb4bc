"""Records for tests of tables and data sets."""

from __future__ import annotations

from math import nan
from typing import Any

import numpy as np
from hypothesis import strategies as st

from understudy.model.lesson import ExampleKind
from understudy.model.value_kinds import BOOLEAN, Continuous, Kind, Toroidal
from understudy.records.record import Episode, Record, RecordedPress, describe_labels
from understudy.runtime.body import Channel

KINDS: dict[str, Kind] = {
    "distance(station)": Continuous(),
    "bearing(station)": Toroidal(),
    "carrying": BOOLEAN,
}


def make_record(**changes: Any) -> Record:
    """Three ticks of a robot that fetches food and then delivers it; the station is out of sight at first.

    Readings, kinds, units, commands and their units are given by label.
    """
    given: dict[str, Any] = {
        "agent": "robot 0",
        "tick_s": 0.05,
        "times": np.array([0.1, 0.15, 0.21]),
        "states": (("fetch", "approach"), ("fetch", "grasp"), ("deliver",)),
        "readings": {
            "distance(station)": np.array([nan, 2.5, 1 / 3]),
            "bearing(station)": np.array([nan, 0.1, 6.2]),
            "carrying": np.array([0.0, 0.0, 1.0]),
        },
        "kinds": KINDS,
        "units": {},
        "commands": {"drive": np.array([0.1, 0.2, 0.3]), "turn": np.array([-1.0, 0.0, 1.0])},
        "channel_units": {},
        "presses": (
            RecordedPress(1, None),
            RecordedPress(2, "deliver", correction=True, kind=ExampleKind.DIRECTIVE),
        ),
        "source": "run.jsonl",
        "seed": 2**63 - 1,
        "behavior": "forage",
    } | changes
    readings, commands = given.pop("readings"), given.pop("commands")
    kinds, units, channel_units = (given.pop(name) for name in ("kinds", "units", "channel_units"))
    keys, described, targets = describe_labels(
        [*readings],
        [kinds.get(label, Continuous()) for label in readings],
        [units.get(label, "") for label in readings],
    )
    count = len(given["times"])
    return Record(
        **{"episodes": (Episode(given["source"], 0, count),), **given},
        values=dict(zip(keys, readings.values(), strict=True)),
        commands=np.column_stack(list(commands.values())) if commands else np.zeros((count, 0)),
        channels=tuple(Channel(name, unit=channel_units.get(name, "")) for name in commands),
        readings=described,
        targets=targets,
    )


def without_commands(**changes: Any) -> Record:
    """The same as a journal would have it: without commands, one level of states, and without a seed."""
    only = (("fetch",), ("fetch",), ("deliver",))
    return make_record(**{"commands": {}, "states": only, "seed": None, **changes})


@st.composite
def draw_records(draw: st.DrawFn, ticks: int = 1) -> list[Record]:
    """Records of one set of readings and channels, with any values, and at least `ticks` ticks."""
    names = st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1, max_size=5)
    labels = draw(st.lists(names, min_size=1, max_size=3, unique=True))
    channels = draw(st.lists(names, max_size=2, unique=True))
    states = draw(st.lists(names, min_size=1, max_size=3, unique=True))
    tick_s = draw(st.sampled_from([0.05, 0.1, 1 / 3, 0.03, 2.0]))
    records = []
    for _ in range(draw(st.integers(1, 3))):
        length = draw(st.integers(ticks, 4))
        column = st.lists(st.floats(), min_size=length, max_size=length).map(np.array)
        path = st.lists(st.sampled_from(states), max_size=2).map(tuple)
        paths = draw(st.lists(path, min_size=length, max_size=length))
        press = st.builds(RecordedPress, st.integers(0, length - 1), st.none() | names, st.booleans())
        records.append(
            make_record(
                agent=draw(names),
                tick_s=tick_s,
                times=draw(column),
                states=((states[0],), *paths[1:]),
                readings={label: draw(column) for label in labels},
                kinds={},
                commands={channel: draw(column) for channel in channels},
                presses=tuple(draw(st.lists(press, max_size=3, unique_by=lambda each: each.tick))),
                seed=draw(st.none() | st.integers(0, 2**63 - 1)),
                source="",
                behavior="",
            )
        )
    return records
