"""Quotients and differences of readings in documents, which need no kit that has them."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from understudy.errors import FileError
from understudy.learning.fit import learn_automaton
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Target
from understudy.model.features import Feature
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.model.value_kinds import Continuous, Toroidal
from understudy.storage.document import decode_document, encode_document
from understudy.training.lesson_design import parse_feature

KIT = Kit.from_parts(
    Feature("distance_to", Continuous(), "range", of="target", unit="m"),
    Feature("speed", Continuous(), "speed", unit="m/s"),
    Feature("x", Continuous(), "x", unit="m"),
    Feature("heading", Toroidal(), "heading", unit="rad"),
    Feature("course", Toroidal(), "course", unit="rad"),
    Behavior("go", Command(drive=1.0)),
    Target("ball"),
)
PAIRS = ("distance_to(ball) / speed", "(distance_to(ball) - x) / speed", "heading - course")


def teach() -> TrainedAutomaton:
    """Teach an automaton to go where the ball is more than a second away."""
    features = tuple(parse_feature(Library(KIT), each) for each in PAIRS)
    automaton = Automaton("a", (START, State("go", "go")), features)
    examples = (
        Example(1, "start", (2.0, 0.0, 1.0), "go", ExampleKind.DIRECTIVE),
        Example(2, "start", (0.5, 0.0, 1.0), "start", ExampleKind.CONFIRMATION),
        Example(3, "go", (0.5, 0.0, 1.0), "start", ExampleKind.DIRECTIVE),
    )
    lesson = Lesson(automaton, examples)
    return TrainedAutomaton(learn_automaton(lesson), lesson)


DATA = encode_document(teach())


@pytest.mark.parametrize("kit", [KIT, Kit.from_parts(Behavior("go", Command(drive=1.0))), None])
def test_round_trip(kit: Kit | None) -> None:
    taught = decode_document(DATA, kit, path="a.json").taught
    assert [str(each) for each in taught.automaton.features] == list(PAIRS)
    for now, before in zip(taught.automaton.features, teach().automaton.features, strict=True):
        assert isinstance(now.feature, Feature)
        assert isinstance(before.feature, Feature)
        assert now == before
        assert now.feature.pair == before.feature.pair
        assert now.feature.doc == before.feature.doc
    assert taught.automaton == teach().automaton
    assert encode_document(taught) == DATA


def test_a_document_says_what_a_pair_is_made_of() -> None:
    feature = json.loads(DATA)["automaton"]["features"][0]
    assert feature == {
        "name": "distance_to(A) / speed",
        "binding": {"A": "ball"},
        "kind": "continuous",
        "unit": "s",
        "pair": {
            "term": "quotient",
            "left": {"term": "reading", "reading": "range", "of": "A", "name": "distance_to"},
            "right": {"term": "reading", "reading": "speed"},
        },
    }


def change(document: Any, index: int = 0, **changes: Any) -> None:
    document["automaton"]["features"][index].update(changes)


EDITS: dict[str, tuple[Callable[[Any], None], str, str]] = {  # what is done, where, what the error must say
    "another name": (lambda d: change(d, name="time"), "features[0].name", "distance_to(A) / speed"),
    "an angle divided": (lambda d: change(d, kind="toroidal(2)"), "features[0].kind", "quotient"),
    "labels subtracted": (lambda d: change(d, 2, kind="boolean"), "features[2].kind", "difference"),
    "of the automaton itself": (lambda d: change(d, sort="flag"), "features[0].kind", "flag"),
    "another sort": (lambda d: d["automaton"]["features"][0]["pair"].update({"term": "sum"}), "pair", "sum"),
    "one side": (lambda d: d["automaton"]["features"][0]["pair"].pop("right"), "pair", "right"),
    "no reading": (
        lambda d: d["automaton"]["features"][0]["pair"]["right"].update(reading=""), "right.reading", "1"
    ),
    "something more": (
        lambda d: d["automaton"]["features"][0]["pair"].update(third={}), "pair", "third"
    ),
    "no binding": (lambda d: d["automaton"]["features"][0].pop("binding"), "features[0].binding", "A"),
}  # fmt: skip


@pytest.mark.parametrize("levels", [4, 300, 5000])
def test_pairs_within_each_other_have_an_end(levels: int) -> None:
    reading = '{"term":"reading","reading":"x"}'
    pair = '{"term":"quotient","left":' * levels + reading + f',"right":{reading}}}' * levels
    document = json.loads(DATA)
    change(document, pair="HERE")
    with pytest.raises(FileError, match=r"more than 3 pairs|nested too deeply"):
        decode_document(json.dumps(document).replace('"HERE"', pair).encode(), KIT, path="a.json")


@pytest.mark.parametrize("edit", EDITS)
def test_bad_documents(edit: str) -> None:
    document = json.loads(DATA)
    change_it, where, said = EDITS[edit]
    change_it(document)
    with pytest.raises(FileError) as caught:
        decode_document(json.dumps(document).encode(), KIT, path="a.json")
    assert where in str(caught.value)
    assert said in str(caught.value)


def test_a_pair_is_another_feature_than_one_of_other_readings() -> None:
    """Names say what pairs are computed of, so that features of one name are the same."""
    shown = teach().automaton
    other = parse_feature(Library(KIT), "x / speed")
    assert other != shown.features[0]
    assert replace(shown, features=(other, *shown.features[1:])) != shown
