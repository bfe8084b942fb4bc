"""Lessons as CSV tables: what they hold, and one sentence for each way they can be wrong."""

from __future__ import annotations

from dataclasses import replace
from math import isnan
from pathlib import Path
from random import Random
from typing import Literal

import pytest

from understudy.errors import FileError
from understudy.learning.csv_table import QueryRow, read_lesson_table, read_query_rows
from understudy.learning.fit import learn, predict_next_states
from understudy.model.learner_options import LearnerOptions, TreeOptions
from understudy.model.lesson import ExampleKind
from understudy.model.value_kinds import Categorical, Continuous, Kind, Toroidal

HEADER = "state,next,kind,distance:continuous,bearing:toroidal(6.283185307179586),ready:categorical(no|yes)"
LESSON = f"""{HEADER}
start,forward,directive,9,0.5,no
forward,forward,default,9,0.5,no
forward,load,directive,0.3,,yes
load,load,default,0.3,,yes
load,forward,directive,,-1,no
"""


def write(folder: Path, text: str | bytes, name: str = "goto.csv") -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_a_table_is_a_lesson(tmp_path: Path) -> None:
    lesson = read_lesson_table(write(tmp_path, LESSON))
    assert lesson.name == "goto"
    assert lesson.automaton.state_names == ("start", "forward", "load")
    assert [bound.kind for bound in lesson.automaton.features] == [
        Continuous(),
        Toroidal(6.283185307179586),
        Categorical(("no", "yes")),
    ]
    assert [str(bound) for bound in lesson.automaton.features] == ["distance", "bearing", "ready"]
    last = lesson.examples[-1]
    assert last.kind == ExampleKind.DIRECTIVE
    assert isnan(last.values[0])
    assert last.values[1:] == (-1 % 6.283185307179586, 0.0)


ARRIVALS = """state,next,kind,distance:continuous,angle:continuous
forward,forward,default,5.0,-10
forward,left,directive,4.0,40
forward,forward,default,1.1,0
forward,right,directive,0.9,-40
forward,done,directive,0.3,-20
forward,done,directive,0.2,-25
"""


@pytest.mark.parametrize(
    ("flags", "raised"),
    [(None, {"done"}), ((), set()), (("left",), {"left"}), (("done", "right"), {"done", "right"})],
)
def test_next_states_are_flags_if_they_are_named_or_usual(
    tmp_path: Path, flags: tuple[str, ...] | None, raised: set[str]
) -> None:
    lesson = read_lesson_table(write(tmp_path, ARRIVALS), flags=flags)
    assert {each.name for each in lesson.automaton.states if each.flag == each.name} == raised


def test_what_is_left_is_no_flag_unless_it_is_named(tmp_path: Path) -> None:
    path = write(tmp_path, ARRIVALS + "done,forward,directive,1.5,0\n")
    assert all(each.flag is None for each in read_lesson_table(path).automaton.states)
    with pytest.raises(FileError, match=r"line 8: 'done' is a flag, which is never left"):
        read_lesson_table(path, flags=["done"])
    with pytest.raises(FileError, match=r"no example leads to the flag 'there'; name one of left and right"):
        read_lesson_table(path, flags=["there"])


def test_the_first_state_is_no_flag(tmp_path: Path) -> None:
    path = write(tmp_path, ARRIVALS + "forward,start,directive,9.0,0\n")
    with pytest.raises(FileError, match="'start' is the first state"):
        read_lesson_table(path, flags=["start"])


def test_flags_are_told_apart_before_what_steers(tmp_path: Path) -> None:
    lesson = read_lesson_table(write(tmp_path, ARRIVALS))
    near_at_40 = QueryRow("forward", (0.25, 40.0))
    orders: tuple[tuple[Literal["gain first", "flags first"], str], ...] = (
        ("gain first", "left"),
        ("flags first", "done"),
    )
    for order, decided in orders:
        functions = learn(replace(lesson, options=LearnerOptions(learner=TreeOptions(order=order))))
        names = lesson.automaton.state_names
        assert predict_next_states(functions, names, [near_at_40]) == [decided]


BUMPED = """state,next,kind,distance:continuous,angle:continuous,bumped:categorical(no|yes)
forward,forward,default,5.0,-10,no
forward,left,directive,4.0,40,no
forward,forward,default,1.1,0,no
forward,right,directive,0.9,-40,no
forward,done,directive,0.3,-20,no
forward,done,directive,0.2,-25,no
forward,failed,directive,2.2,-5,yes
"""


def test_one_flag_is_told_apart_where_no_test_tells_all(tmp_path: Path) -> None:
    lesson = read_lesson_table(write(tmp_path, BUMPED))
    rows = [QueryRow("forward", values) for values in ((0.25, 40.0, 0.0), (3.0, -22.0, 0.0), (3.0, 0.0, 1.0))]
    decided = predict_next_states(learn(lesson), lesson.automaton.state_names, rows)
    assert decided == ["done", "forward", "failed"]


HEADERS = [  # header, name, kind: names may hold colons and brackets, as those of the RoboCup lessons do
    ("x:continuous", "x", Continuous()),
    (
        "way[X->Goal Target: (4.5, 0) in meters]:continuous",
        "way[X->Goal Target: (4.5, 0) in meters]",
        Continuous(),
    ),
    (" a : b : toroidal(4) ", "a : b", Toroidal(4.0)),
    ("x:categorical(a:b|boolean)", "x", Categorical(("a:b", "boolean"))),
    ("x:categorical(a:boolean)", "x", Categorical(("a:boolean",))),
]


@pytest.mark.parametrize(("header", "name", "kind"), HEADERS)
def test_a_header_is_a_name_and_a_kind(tmp_path: Path, header: str, name: str, kind: Kind) -> None:
    lesson = read_lesson_table(write(tmp_path, f'state,next,kind,"{header}"\na,b,directive,\n'))
    (bound,) = lesson.automaton.features
    assert (str(bound), bound.kind) == (name, kind)


def test_predictions(tmp_path: Path) -> None:
    lesson = read_lesson_table(write(tmp_path, LESSON))
    rows = f"{HEADER}\nforward,,,0.1,0.5,yes\nforward,,,8,0.5,no\nload,x,,1,,no\nstart,,,,,\n"
    read = read_query_rows(write(tmp_path, rows, "rows.csv"), lesson)
    assert predict_next_states(learn(lesson), lesson.automaton.state_names, read) == [
        "load",
        "forward",
        "load",
        "forward",
    ]


def test_rows_may_hold_only_what_is_needed_in_any_order(tmp_path: Path) -> None:
    lesson = read_lesson_table(write(tmp_path, LESSON))
    rows = "ready:boolean,distance:continuous,state,bearing:toroidal\nyes,0.1,forward,0.5\n"
    (row,) = read_query_rows(write(tmp_path, rows, "rows.csv"), lesson)
    assert row.values == (0.1, 0.5, 1.0)


def test_order_of_rows_makes_no_difference(tmp_path: Path) -> None:
    header, *rows = LESSON.splitlines()
    Random(1).shuffle(rows)
    shuffled = read_lesson_table(write(tmp_path, "\n".join([header, *rows]), "goto.csv"))
    lesson = read_lesson_table(write(tmp_path, LESSON))
    assert shuffled.automaton == lesson.automaton
    assert learn(shuffled) == learn(lesson)


def test_what_spreadsheets_write_is_read(tmp_path: Path) -> None:
    text = LESSON.replace("\n", "\r\n").encode("utf-8-sig") + b",,,,,\r\n\r\n"
    assert len(read_lesson_table(write(tmp_path, text)).examples) == 5


BAD = [
    ("", "it is empty; begin with a line"),
    (b"\xff\xfe", "line 1: it is not UTF-8 text; save it as UTF-8"),
    (HEADER, "it has no examples"),
    (
        "state,next,x:continuous\na,b,1\n",
        "line 1: there is no column 'kind'; the columns are state, next and x:continuous",
    ),
    (
        "state,next,kind,x\na,b,directive,1\n",
        "line 1, column 'x': a feature's column names its kind; write x:cont",
    ),
    ("state,next,kind,x:float\na,b,directive,1\n", "line 1, column 'x:float': 'float' is not a kind"),
    ("state,next,kind,x:toroidal(0)\na,b,directive,1\n", "its period is 0.0"),
    ("state,next,kind,x:continuous,x:continuous\na,b,directive,1,1\n", "there are two of this name"),
    ("state,next,kind,x:continuous,x:boolean\na,b,directive,1,no\n", "feature 'x' has two columns"),
    ("state,next,kind,\na,b,directive,1\n", "line 1, column 4: it has no name"),
    ("state,next,kind\na,b,directive,1\n", "line 2: it has 4 cells; give one for each of the 3 columns"),
    (
        "state,next,kind\na,b,shown\n",
        "line 2, column 'kind': 'shown' is not a kind of example; write directive",
    ),
    ("state,next,kind\na,,default\n", "line 2, column 'next': it is empty; name a state"),
    (
        "state,next,kind,x:continuous\na,b,default,far\n",
        "line 2, column 'x:continuous': 'far' is not a number",
    ),
    ("state;next;kind;x:continuous\na;b;default;1\n", "there is no column 'state'"),
    ("state;next;kind;x:continuous\na;b;default;1\n", "put commas between the columns"),
    ("state,next,kind,x:y:z\na,b,default,1\n", "'z' is not a kind"),
    ("state,next,kind,x:continuous\na,b,default,1_5\n", "'1_5' is not a number"),
    (
        "state,next,kind,x:continuous\na,b,default,inf\n",
        "line 2, column 'x:continuous': 'inf' is not a number",
    ),
    (
        "state,next,kind,x:boolean\na,b,default,maybe\n",
        "'maybe' is not one of its labels; the labels are no, yes",
    ),
    ('state,next,kind\na,"b,default\n', "it is not a table"),
]


@pytest.mark.parametrize(("text", "says"), BAD)
def test_bad_tables_are_one_sentence(tmp_path: Path, text: str | bytes, says: str) -> None:
    path = write(tmp_path, text)
    with pytest.raises(FileError) as caught:
        read_lesson_table(path)
    assert str(caught.value).startswith(str(path))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="No such file"):
        read_lesson_table(tmp_path / "none.csv")


BAD_ROWS = [
    (
        f"{HEADER}\nfly,,,1,1,no\n",
        "line 2, column 'state': the lesson has no state 'fly'; write one of start, forw",
    ),
    ("distance:continuous\n1\n", "there is no column 'state'"),
    ("state,distance:continuous\nload,1\n", "there is no column 'bearing:toroidal(6.283185307179586)'"),
    (
        HEADER.replace("distance:continuous", "distance:boolean") + "\n",
        "feature 'distance' is continuous in the",
    ),
    (f"{HEADER},more:boolean\n", "the lesson has no feature 'more'; remove it"),
    (f"{HEADER}\nload,,,x,1,no\n", "line 2, column 'distance:continuous': 'x' is not a number"),
]


@pytest.mark.parametrize(("text", "says"), BAD_ROWS)
def test_bad_rows_are_one_sentence(tmp_path: Path, text: str, says: str) -> None:
    lesson = read_lesson_table(write(tmp_path, LESSON))
    with pytest.raises(FileError) as caught:
        read_query_rows(write(tmp_path, text, "rows.csv"), lesson)
    assert says in str(caught.value)
