"""Lessons as data frames: what they hold comes back, and one sentence for each way they can be wrong."""

from __future__ import annotations

import sys
from dataclasses import replace
from math import nan
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("narwhals", reason="needs the extra frames")

from hypothesis import given
from hypothesis import strategies as st

from understudy import Categorical, Continuous, Lesson, Toroidal, learn
from understudy.errors import DefinitionError, SettingError
from understudy.extras import ExtraMissing
from understudy.learning.csv_table import read_lesson_table
from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature, Feature
from understudy.model.lesson import Example, ExampleKind
from understudy.model.value_kinds import BOOLEAN, Kind

pandas: Any = pytest.importorskip("pandas")
polars: Any = pytest.importorskip("polars")
pyarrow: Any = pytest.importorskip("pyarrow")
BACKENDS = ("pandas", "polars", "pyarrow")
KINDS: list[Kind] = [
    Continuous(),
    Toroidal(),
    Toroidal(4.0),
    BOOLEAN,
    Categorical(("0", "1")),
    Categorical(("a:b",)),
]
example_kinds = st.sampled_from(ExampleKind)
STATES = st.sampled_from(["start", "forward", "rotate left", " größe", "nan"])
COLUMNS = {
    "state": ["start", "forward"],
    "next": ["forward", "forward"],
    "kind": ["directive", "default"],
    "distance:continuous": [0.3, None],
    "ready:boolean": ["yes", None],
}


def values(kind: Kind) -> st.SearchStrategy[float]:
    if isinstance(kind, Categorical):
        return st.one_of(st.just(nan), st.integers(0, len(kind.labels) - 1).map(float))
    numbers = st.floats(allow_nan=False, allow_infinity=False)
    if isinstance(kind, Toroidal):
        numbers = numbers.map(lambda value: kind.check(value, where="")).filter(lambda value: value == value)
    return st.one_of(st.just(nan), numbers)


@st.composite
def lessons(draw: st.DrawFn) -> Lesson:
    kinds = draw(st.lists(st.sampled_from(KINDS), max_size=4))
    features = tuple(
        BoundFeature(Feature(f"f{number}(a)", kind, reading=f"f{number}(a)"))
        for number, kind in enumerate(kinds)
    )
    examples = tuple(
        Example(number, draw(STATES), tuple(draw(values(kind)) for kind in kinds), draw(STATES), draw(example_kinds))
        for number in range(draw(st.integers(1, 5)))
    )  # fmt: skip
    names = sorted({name for each in examples for name in (each.state, each.next)} - {"start"})
    return Lesson(Automaton("lesson", (START, *(State(name, name) for name in names)), features), examples)


def table(lesson: Lesson) -> str:
    return repr([(each.state, each.next, each.kind, each.values) for each in lesson.examples])


@pytest.mark.parametrize("backend", BACKENDS)
@given(lesson=lessons())
def test_a_lesson_comes_back_from_its_frame(backend: str, lesson: Lesson) -> None:
    frame = lesson.to_frame(backend)
    again = Lesson.from_frame(frame)
    assert table(again) == table(lesson)
    assert again.automaton == lesson.automaton
    known = Lesson.from_frame(frame, automaton=lesson.automaton)
    assert table(known) == table(lesson)
    assert known.to_frame(backend).equals(frame)


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_frame_is_the_table_that_is_read_from_csv(backend: str, tmp_path: Path) -> None:
    frame = Lesson.from_frame(polars.DataFrame(COLUMNS), name="goto").to_frame(backend)
    polars.DataFrame(frame).write_csv(tmp_path / "goto.csv")
    lesson = Lesson.from_frame(frame, name="goto")
    read = read_lesson_table(tmp_path / "goto.csv")
    assert read.automaton == lesson.automaton
    assert table(read) == table(lesson)
    assert learn(read) == learn(lesson)


def test_a_design_gives_what_the_table_does_not_hold() -> None:
    lesson = Lesson.from_frame(polars.DataFrame(COLUMNS))
    states = (START, State("forward", "drive"), State("done", flag="done"))
    design = replace(lesson.automaton, name="goto", states=states)
    again = Lesson.from_frame(lesson.to_frame(), automaton=design)
    assert (again.name, again.automaton.states) == ("goto", states)


@pytest.mark.parametrize("cells", [[True, False, None], ["yes", "no", None], [True, False, nan]])
def test_truth_values_are_yes_and_no(cells: list[Any]) -> None:
    frame = pandas.DataFrame({"state": "a", "next": "b", "kind": "directive", "x:boolean": cells})
    assert repr([each.values for each in Lesson.from_frame(frame).examples]) == "[(1.0,), (0.0,), (nan,)]"


@pytest.mark.parametrize("cells", [[0, 1], [0.0, 1.0], ["0", "1"]])
def test_numbers_are_labels_that_look_like_them(cells: list[Any]) -> None:
    frame = pandas.DataFrame({"state": "a", "next": "b", "kind": "directive", "x:categorical(1|0)": cells})
    assert [each.values for each in Lesson.from_frame(frame).examples] == [(1.0,), (0.0,)]


def test_the_first_package_that_is_installed_makes_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    lesson = Lesson.from_frame(polars.DataFrame(COLUMNS))
    assert isinstance(lesson.to_frame(), polars.DataFrame)
    from understudy.model import data_frames

    monkeypatch.setattr(data_frames, "find_spec", lambda name: None if name == "polars" else name)
    assert isinstance(lesson.to_frame(), pandas.DataFrame)
    with pytest.raises(SettingError, match="backend 'polars' is not installed; pip install polars"):
        lesson.to_frame("polars")
    monkeypatch.setattr(data_frames, "find_spec", lambda name: None)
    with pytest.raises(SettingError, match=r"none of them is installed; pip install polars"):
        lesson.to_frame()


def test_without_narwhals_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    from understudy.extras import import_narwhals

    import_narwhals.cache_clear()
    monkeypatch.setitem(sys.modules, "narwhals", None)
    with pytest.raises(ExtraMissing, match=r"pip install 'understudy-robots\[frames\]'"):
        Lesson.from_frame(polars.DataFrame(COLUMNS))


def test_an_unknown_backend_is_refused() -> None:
    lesson = Lesson.from_frame(polars.DataFrame(COLUMNS))
    with pytest.raises(SettingError, match="backend 'dask' is unknown; give polars, pandas or pyarrow"):
        lesson.to_frame("dask")


BAD: list[tuple[dict[str, Any], str]] = [
    ({"kind": None}, "data frame: there is no column 'kind'; the columns are state, next, distance:continuous and"),
    ({"distance": [1, 2]}, "data frame, column 'distance': a feature's column names its kind; write distance:cont"),
    ({"x:float": [1, 2]}, "data frame, column 'x:float': 'float' is not a kind"),
    ({"kind": ["directive", "shown"]}, "data frame, row 1, column 'kind': 'shown' is not a kind of example; write"),
    ({"next": ["a", None]}, "data frame, row 1, column 'next': it is empty; name a state"),
    ({"distance:continuous": ["far", "1"]}, "row 0, column 'distance:continuous': 'far' is not a number; give a"),
    ({"distance:continuous": [1.0, float("inf")]}, "row 1, column 'distance:continuous': 'inf' is not a number"),
    ({"ready:boolean": ["maybe", "no"]}, "'maybe' is not one of its labels; the labels are no, yes"),
]  # fmt: skip


@pytest.mark.parametrize("package", [pandas.DataFrame, polars.DataFrame, pyarrow.table])
@pytest.mark.parametrize(("change", "says"), BAD)
def test_bad_frames_are_one_sentence(package: Any, change: dict[str, Any], says: str) -> None:
    columns = {title: cells for title, cells in {**COLUMNS, **change}.items() if cells is not None}
    with pytest.raises(DefinitionError) as caught:
        Lesson.from_frame(package(columns))
    assert says in str(caught.value)


OTHERS = [
    ([1, 2], "data frame: it is a list; give a data frame of Polars, pandas or pyarrow"),
    (polars.LazyFrame(COLUMNS), "data frame: it is a LazyFrame; call its method collect() first"),
    (polars.DataFrame(COLUMNS).head(0), "data frame: it has no examples; add a row for each of them"),
    (
        polars.DataFrame(),
        "data frame: there is no column 'state'; the columns are none; give a frame with these",
    ),
    (
        pandas.DataFrame([["a", "b", "b"]], columns=["state", "next", "next"]),
        "data frame, its columns: there are two of the name 'next'; rename or remove one of the two",
    ),
]


@pytest.mark.parametrize(("frame", "says"), OTHERS)
def test_what_is_no_table_of_examples_is_refused(frame: object, says: str) -> None:
    with pytest.raises(DefinitionError) as caught:
        Lesson.from_frame(frame)
    assert str(caught.value).startswith(says)


def test_a_frame_of_another_automaton_is_refused() -> None:
    lesson = Lesson.from_frame(polars.DataFrame(COLUMNS))
    other = polars.DataFrame({**COLUMNS, "next": ["forward", "away"]})
    with pytest.raises(
        DefinitionError, match=r"row 1, column 'next': the lesson has no state 'away'; write one of"
    ):
        Lesson.from_frame(other, automaton=lesson.automaton)
    fewer = polars.DataFrame(COLUMNS).drop("ready:boolean")
    with pytest.raises(DefinitionError, match=r"no column 'ready:categorical\(no\|yes\)'"):
        Lesson.from_frame(fewer, automaton=lesson.automaton)
