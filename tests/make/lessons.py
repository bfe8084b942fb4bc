"""Lessons written as tables, and lessons drawn at random."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from functools import cache
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st
from tests.learning.reference import Row

from understudy.learning.tree_growth import grow_tree
from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature, Feature
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.tree import STAY, Tree
from understudy.model.value_kinds import Categorical, Continuous, Kind, Toroidal

ABSENT = nan
KINDS = {"directive": 1, "confirmation": 1, "default": 0, "watched": 2}


def learn_tree(
    rows: list[Row],
    kinds: list[Kind],
    *,
    current: int = STAY,
    midpoints: bool = False,
    flags: Sequence[int] = (),
    silence: bool = False,
) -> Tree:
    return grow_tree(
        np.array([row.values for row in rows], np.float64).reshape(len(rows), len(kinds)),
        np.array([row.outcome for row in rows], np.int64),
        np.array([row.group for row in rows], np.int64),
        kinds,
        states=4,
        current=current,
        midpoints=midpoints,
        flags=flags,
        silence=silence,
    )


def make_lesson(
    shown: list[tuple[Any, ...]], kinds: list[Kind] | None = None, *, stateless: bool = False, unit: str = ""
) -> Lesson:
    """Examples (state, values, next, kind); states are start and what is named, in order of appearance."""
    kinds = kinds or [Continuous()]
    names = dict.fromkeys(name for state, _, following, _ in shown for name in (state, following))
    states = (START, *(State(name, name) for name in names if name != "start"))
    features = tuple(
        BoundFeature(Feature(f"f{index}", kind, reading="f", unit=unit)) for index, kind in enumerate(kinds)
    )
    return Lesson(
        Automaton("lesson", states, features, stateless=stateless),
        tuple(
            Example(number, state, tuple(map(float, values)), following, ExampleKind(kind))
            for number, (state, values, following, kind) in enumerate(shown)
        ),
    )


@st.composite
def draw_tables(draw: st.DrawFn, watched: bool = False, stays: int = 0) -> tuple[list[Row], list[Kind]]:
    """Examples on a coarse grid, so that ties, duplicates and absences abound; at least one press-made.

    Up to `stays` watched examples of outcome 0 are added.
    """
    kinds = draw(KINDS_OF_FEATURES)
    rows = draw(_list_rows(tuple(kinds), watched=watched))
    if all(row.group == 2 for row in rows):
        rows[0] = rows[0]._replace(group=1)
    return rows + draw(_list_stays(tuple(kinds), stays)), kinds


KINDS_OF_FEATURES: st.SearchStrategy[list[Kind]] = st.lists(
    st.sampled_from([Continuous(), Toroidal(8.0), Toroidal(), Categorical(("a", "b", "c"))]),
    min_size=1,
    max_size=3,
)


@cache  # half of the time of an example went into making the same strategies again
def _list_rows(kinds: tuple[Kind, ...], *, watched: bool) -> st.SearchStrategy[list[Row]]:
    groups = st.sampled_from([0, 1, 2] if watched else [0, 1])
    row = st.builds(Row, st.tuples(*map(_values, kinds)), st.integers(0, 2), groups)
    return st.lists(row, min_size=1, max_size=12)


@cache
def _list_stays(kinds: tuple[Kind, ...], most: int) -> st.SearchStrategy[list[Row]]:
    stay = st.builds(Row, st.tuples(*map(_values, kinds)), st.just(0), st.just(2))
    return st.lists(stay, max_size=most)


@cache
def _values(kind: Kind) -> st.SearchStrategy[float]:
    if isinstance(kind, Categorical):
        return st.sampled_from([0.0, 1.0, 2.0, ABSENT])
    top = kind.period if isinstance(kind, Toroidal) else 10.0
    edges = [0.0, -0.0, float(np.nextafter(top, 0)), 1.0, float(np.nextafter(1.0, 2)), ABSENT]
    return st.one_of(
        st.integers(0, int(top)).map(float).filter(lambda value: value < top),
        st.sampled_from(edges),
        st.floats(0.0, top, exclude_max=True, allow_subnormal=False),
    )


ROBOCUP_FOLDER = "UNDERSTUDY_ROBOCUP_LESSONS"
"""The variable that names the folder of the RoboCup team's lessons, which stay outside the repository."""


def robocup_folder() -> Path | None:
    """The folder that the variable names; None where it names none: what lies beside a checkout is nobody's guess."""
    named = os.environ.get(ROBOCUP_FOLDER)
    return Path(named) if named else None


def read_robocup(path: Path) -> list[tuple[str, list[Kind], list[Row], int]]:
    """The states of one of its automata: name, kinds, examples, and the state's own index."""
    document = json.loads(path.read_text(encoding="utf-8"))
    found = []
    for state in document["states"]:
        names = [each["state"] for each in document["states"]]
        names += sorted({example["y"] for example in state["examples"]} - set(names))
        kinds: list[Kind] = [
            Continuous() if attribute["kind"] == "continuous" else Categorical(tuple(attribute["values"]))
            for attribute in state["attributes"]
        ]
        rows = [
            Row(tuple(example["x"]), names.index(example["y"]), 0 if example["default"] else 1)
            for example in state["examples"]
        ]
        found.append((state["state"], kinds, rows, names.index(state["state"])))
    return found
