"""Whatever is wrong with a document is one error that names the file, the place, and what would be right."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.make.automata import ANGLE, READY, make_goto, make_kit

from understudy.errors import FileError
from understudy.model.features import Feature, FlagFeature
from understudy.model.library import Kit
from understudy.model.value_kinds import Continuous
from understudy.storage.document import decode_document, encode_document
from understudy.storage.library_folder import open_library

KIT = make_kit(make_goto().automaton)
DATA = encode_document(make_goto())


def raw() -> Any:
    return json.loads(DATA)


def state(document: Any, index: int, **changes: Any) -> None:
    document["automaton"]["states"][index].update(changes)


def example(document: Any, **changes: Any) -> None:
    document["lesson"]["examples"][0].update(changes)


def change_watched(document: Any, **changes: Any) -> None:
    document["lesson"]["watched"][0].update(changes)


def node(document: Any, index: int, **changes: Any) -> None:
    document["built"]["trees"]["start"][index].update(changes)


def goal(document: Any, **changes: Any) -> None:
    kept = {"kind": "always", "what": "done is raised", "within_s": 5.0, "world": "forage"}
    document["lesson"]["goal"] = kept | changes


Edit = Callable[[Any], None]
EDITS: dict[str, tuple[Edit, str, str]] = {  # what is done -> where and what the error must say
    "two states of a name": (lambda d: state(d, 1, name="start"), "$.automaton.states[1]", "twice"),
    "start state that acts": (
        lambda d: state(d, 0, behavior="forward"),
        "$.automaton.states",
        "does not idle",
    ),
    "flag state that acts": (lambda d: state(d, 2, behavior="x"), "$.automaton.states[2]", "raises flag"),
    "no states": (lambda d: d["automaton"].update(states=[]), "$.automaton.states", "start state"),
    "two parameters of a name": (
        lambda d: d["automaton"].update(parameters=["A", "A"]),
        "parameters[1]",
        "twice",
    ),
    "unknown feature": (
        lambda d: d["automaton"]["features"][0].update(name="dist"),
        "features[0].name",
        "angle_to",
    ),
    "no kind": (
        lambda d: d["automaton"]["features"][0].update(kind="round"),
        "features[0].kind",
        "continuous",
    ),
    "other kind": (
        lambda d: d["automaton"]["features"][0].update(kind="toroidal(2)"),
        "features[0].kind",
        "kit",
    ),
    "other unit": (lambda d: d["automaton"]["features"][0].update(unit="cm"), "features[0].unit", "'m'"),
    "other sort": (lambda d: d["automaton"]["features"][2].update(sort="flag"), "features[2].sort", "'body'"),
    "unbound feature": (lambda d: d["automaton"]["features"][0].pop("binding"), "features[0].binding", "A"),
    "two features": (
        lambda d: d["automaton"]["features"].append(d["automaton"]["features"][0]),
        "[4]",
        "twice",
    ),
    "goal of no kind": (lambda d: goal(d, kind="mostly"), "$.lesson.goal.kind", "mostly"),
    "goal within no time": (lambda d: goal(d, within_s=0.0), "$.lesson.goal", "above 0"),
    "goal of no run": (lambda d: goal(d, limit_s=0.0), "$.lesson.goal.limit_s", "> 0"),
    "unknown state": (
        lambda d: example(d, state="x"),
        "$.lesson.examples[0].state",
        "start, forward and done",
    ),
    "unknown next": (lambda d: example(d, next="x"), "$.lesson.examples[0].next", "start, forward and done"),
    "no kind of example": (lambda d: example(d, kind="guess"), "$.lesson.examples[0].kind", "guess"),
    "missing value": (lambda d: example(d, values=[1.0]), "$.lesson.examples[0].values", "4 features"),
    "unknown label": (lambda d: example(d, values=[1, 1, "maybe", "no"]), "values[2]", "no and yes"),
    "number for a label": (lambda d: example(d, values=[1, 1, 1, "no"]), "values[2]", "no and yes"),
    "label for a number": (lambda d: example(d, values=["near", 1, "no", "no"]), "values[0]", "a number"),
    "list for a value": (lambda d: example(d, values=[[], 1, "no", "no"]), "values[0]", "array"),
    "number twice": (lambda d: example(d, number=2), "$.lesson.examples[1].number", "two examples"),
    "negative number": (lambda d: example(d, number=-1), "$.lesson.examples[0].number", ">= 0"),
    "moment too late": (lambda d: example(d, moment=5), "$.lesson.examples[0].moment", "record has 5"),
    "window too long": (lambda d: example(d, window=3), "$.lesson.examples[0].window", "no more"),
    "unknown field": (lambda d: example(d, weight=2), "$.lesson.examples[0]", "weight"),
    "watched too short": (lambda d: change_watched(d, state=["forward"]), "$.lesson.watched[0].state", "2"),
    "watched column gone": (
        lambda d: change_watched(d, values=[[1, 2]]),
        "$.lesson.watched[0].values",
        "4 features",
    ),
    "watched nowhere": (
        lambda d: change_watched(d, next=["x", "start"]),
        "$.lesson.watched[0].next[0]",
        "forward",
    ),
    "watched label": (
        lambda d: d["lesson"]["watched"][0]["values"][2].__setitem__(0, "?"),
        "values[2][0]",
        "yes",
    ),
    "reaction too long": (
        lambda d: d["lesson"]["options"].update(reaction_s=9),
        "$.lesson.options",
        "0 and 1",
    ),
    "unknown learner": (lambda d: d["lesson"]["options"]["learner"].update(learns="x"), "learner", "x"),
    "record cut": (
        lambda d: d["lesson"]["record"].update(seconds="eJ"),
        "$.lesson.record.seconds",
        "damaged",
    ),
    "record no base64": (lambda d: d["lesson"]["record"].update(seconds="ü"), "record.seconds", "damaged"),
    "record length": (
        lambda d: d["lesson"]["record"].update(moments=6),
        "$.lesson.record.seconds",
        "6 numbers",
    ),
    "a tree for no state": (
        lambda d: d["built"]["trees"].update(x=[]),
        "$.built.trees.x",
        "start and forward",
    ),
    "a tree for a flag": (
        lambda d: d["built"]["trees"].update(done=[]),
        "$.built.trees.done",
        "that can be left",
    ),
    "an empty tree": (lambda d: d["built"]["trees"].update(start=[]), "$.built.trees.start", "no nodes"),
    "missing node": (lambda d: node(d, 0, yes=6), "$.built.trees.start[0].yes", "nodes 0 to 5"),
    "a cycle": (lambda d: node(d, 2, yes=1), "$.built.trees.start[2].yes", "further down"),
    "a loop": (lambda d: node(d, 2, yes=2), "$.built.trees.start[2].yes", "further down"),
    "tests no feature": (
        lambda d: node(d, 0, feature="x"),
        "$.built.trees.start[0].feature",
        "distance_to(A)",
    ),
    "an arc on a line": (
        lambda d: node(d, 2, feature="distance_to(A)"),
        "$.built.trees.start[2]",
        "toroidal",
    ),
    "a cut on labels": (lambda d: node(d, 0, feature="ready"), "$.built.trees.start[0]", "label"),
    "a label too many": (
        lambda d: node(d, 4, branches={"no": 5, "yes": 5, "x": 5}),
        "[4].branches",
        "no and yes",
    ),
    "goes nowhere": (lambda d: node(d, 1, to="x"), "$.built.trees.start[1].to", "start, forward and done"),
    "unknown node": (lambda d: node(d, 1, node="jump"), "$.built.trees", "jump"),
    "newer format": (lambda d: d.update(format=99), "$.format", "update Understudy"),
    "older than any": (lambda d: d.update(format=0), "$.format", "formats are"),
    "format as text": (lambda d: d.update(format="1"), "$.format", "int"),
    "no format": (lambda d: d.pop("format"), "$", "format"),
    "no automaton": (lambda d: d.pop("automaton"), "$", "automaton"),
    "no name": (lambda d: d["automaton"].update(name=""), "$.automaton.name", "length"),
    "nothing in it": (lambda d: d.update(lesson=None, built=None), "$", "neither"),
}


@pytest.mark.parametrize("edit", EDITS)
def test_wrong_edit(edit: str) -> None:
    spoil, place, said = EDITS[edit]
    document = raw()
    spoil(document)
    with pytest.raises(FileError) as caught:
        decode_document(
            json.dumps(document, indent=1, ensure_ascii=False).encode(), KIT, path="lib/goto.json"
        )
    text = str(caught.value)
    assert text.startswith("lib/goto.json at $")
    assert place in text
    assert said in text
    assert "line " in text
    assert "\n" not in text


TEXTS = {
    "empty": (b"", "cut short"),
    "cut short": (DATA[: len(DATA) // 2], "cut short"),
    "one comma too many": (DATA.replace(b'"A"],', b'"A"],,', 1), "line 5"),
    "not JSON": (b"states: start", "line 1"),
    "not a document": (b"[]", "array"),
    "not text": (DATA[:200] + b"\xff" + DATA[200:], "UTF-8"),
    "NaN": (DATA.replace(b"0.25", b"NaN", 1), "JSON"),
    "too large a number": (DATA.replace(b"0.25", b"1e999", 1), "examples[0].values[1]"),
    "too long a number": (DATA.replace(b"0.25", b"9" * 5000, 1), ""),
    "a key twice": (DATA.replace(b'"moment": 2,', b'"moment": 2, "moment": 1,', 1), "'moment' twice"),
    "a pickle": (b"\x80\x04K\x01.", "UTF-8"),
    "very deep": (b"[" * 100_000, "nested"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_unreadable_text(name: str, tmp_path: Path) -> None:
    data, said = TEXTS[name]
    path = tmp_path / "goto.json"
    path.write_bytes(data)
    with pytest.raises(FileError) as caught:
        open_library(tmp_path, KIT)
    assert str(path) in str(caught.value)
    assert said in str(caught.value)
    assert path.read_bytes() == data


@pytest.mark.parametrize("length", range(0, len(DATA) - 1, 97))
def test_cut_anywhere(length: int) -> None:
    with pytest.raises(FileError, match=r"cut short|not JSON"):
        decode_document(DATA[:length], KIT, path="goto.json")


@given(st.integers(0, len(DATA) - 1), st.binary(min_size=0, max_size=3))
@settings(max_examples=300)
def test_any_damage_is_an_error_or_still_a_document(at: int, put: bytes) -> None:
    """Never anything else than an error of ours, whatever bytes are damaged."""
    with suppress(FileError):
        decode_document(DATA[:at] + put + DATA[at + 1 :], KIT, path="goto.json", learn=lambda lesson: {})


def test_other_kit() -> None:
    others = Kit.from_parts(
        Feature("distance_to", Continuous(), reading="range", unit="m"), ANGLE, READY, FlagFeature("bump")
    )
    with pytest.raises(FileError, match=r"features\[0\]\.binding"):
        decode_document(DATA, others, path="goto.json")
