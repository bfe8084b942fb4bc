"""Documents hold lessons exactly, and look as people can read them."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from tests.make.automata import draw_automaton, make_goto, make_kit

from understudy.errors import DefinitionError, FileError
from understudy.model.automaton import START, Automaton, State, Transition
from understudy.model.features import BoundFeature, Feature
from understudy.model.learner_options import LearnerOptions, SklearnOptions, TreeOptions
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Kit, TrainedAutomaton
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Toroidal
from understudy.storage import document, library_schema
from understudy.storage.document import decode_document, encode_document


def exact(value: Any) -> str:
    """All of a value, bit for bit: repr tells -0.0 from 0.0 and writes NaN as itself."""
    return repr(value)


@pytest.mark.long
@given(draw_automaton())
@settings(max_examples=150)
def test_round_trip(original: TrainedAutomaton) -> None:
    data = encode_document(original)
    opened = decode_document(data, make_kit(original.automaton), path="x.json")
    lesson, back = original.lesson, opened.taught.lesson
    assert lesson is not None
    assert back is not None
    assert opened.rebuilt is None or (lesson.examples and not original.automaton.transitions)
    assert exact(opened.taught.automaton) == exact(original.automaton)
    assert exact(back.examples) == exact(lesson.examples)
    assert [(each.source, each.reaction_s) for each in back.examples] == [
        (each.source, each.reaction_s) for each in lesson.examples
    ]
    assert (back.options, back.record.keys) == (lesson.options, lesson.record.keys)
    assert back.record.values.tobytes() == np.ascontiguousarray(lesson.record.values).tobytes()
    assert back.record.seconds.tobytes() == lesson.record.seconds.tobytes()
    assert encode_document(opened.taught) == data


@given(draw_automaton())
@settings(max_examples=50)
def test_a_document_can_be_looked_at_without_a_kit(original: TrainedAutomaton) -> None:
    opened = decode_document(encode_document(original), None, path="x.json").taught.automaton
    assert [str(bound) for bound in opened.features] == [str(bound) for bound in original.automaton.features]
    assert [bound.kind for bound in opened.features] == [bound.kind for bound in original.automaton.features]


def test_one_thing_per_line() -> None:
    lines = encode_document(make_goto()).decode().splitlines()
    assert sum('"kind": "directive"' in line for line in lines) == 1
    assert sum(line.strip().startswith('{"node": "below"') for line in lines) == 2
    assert [line for line in lines if '"reading": "range"' in line] != []
    assert lines[1] == '  "format": 1,'


def test_the_same_lesson_gives_the_same_document_whatever_the_order_of_examples() -> None:
    original = make_goto()
    assert original.lesson is not None
    turned = replace(original.lesson, examples=original.lesson.examples[::-1])
    assert encode_document(TrainedAutomaton(original.automaton, turned)) == encode_document(original)


def rebuild(lesson: Lesson) -> dict[str, Transition]:
    return {"start": Tree((make_leaf(1),))}


EDITS = [
    ('"values": [5.5, 0.25', '"values": [5.6, 0.25'),  # an example
    ('"cut": 0.4', '"cut": 0.5'),  # a tree
    ('"reaction_s": 0.2', '"reaction_s": 0.3'),  # an option
    ('"hash": "sha256:', '"hash": "sha256:0'),
]


@pytest.mark.parametrize(("old", "new"), EDITS)
def test_edited_lessons_are_learned_again(old: str, new: str) -> None:
    original = make_goto()
    data = encode_document(original).decode()
    assert old in data
    edited = data.replace(old, new, 1).encode()
    opened = decode_document(edited, make_kit(original.automaton), path="x.json", learn=rebuild)
    assert opened.rebuilt is not None
    assert opened.taught.automaton.transitions == {"start": Tree((make_leaf(1),))}
    with pytest.raises(FileError, match="understudy rebuild"):
        decode_document(edited, make_kit(original.automaton), path="x.json")


def test_an_unlearned_lesson_is_learned_on_opening() -> None:
    original = make_goto()
    assert original.lesson is not None
    data = encode_document(TrainedAutomaton(original.lesson.automaton, original.lesson))
    assert (
        decode_document(data, make_kit(original.automaton), path="x", learn=rebuild).rebuilt
        == "it has none yet"
    )


@pytest.mark.parametrize(
    "options",
    [
        LearnerOptions(reaction_s=0),
        LearnerOptions(reaction_s=np.float64(0.2)),
        LearnerOptions(learner=TreeOptions(pruning=1)),
    ],
    ids=["whole seconds", "NumPy", "whole pruning"],
)
def test_whole_numbers_are_as_good_as_others(options: LearnerOptions) -> None:
    """Written as they were given, they made a document that misses its own hash, or none."""
    original = make_goto()
    assert original.lesson is not None
    lesson = replace(original.lesson, options=options)
    data = encode_document(replace(original, lesson=lesson))
    opened = decode_document(data, make_kit(original.automaton), path="x.json")
    assert opened.taught.lesson is not None
    assert opened.taught.lesson.options == options


def test_whole_numbers_in_kinds_and_trees() -> None:
    angle = Feature("angle", Toroidal(360), "bearing")
    nodes = Node(TestKind.ARC, 0, low=350, high=10, yes=1, no=STAY), make_leaf(1)
    automaton = Automaton("goto", (START, State("forward", "forward")), (BoundFeature(angle),))
    shown = Example(1, "start", (5.0,), "forward", ExampleKind.DIRECTIVE)
    taught = TrainedAutomaton(
        replace(automaton, transitions={"start": Tree(nodes)}), Lesson(automaton, (shown,))
    )
    opened = decode_document(encode_document(taught), Kit.from_parts(angle), path="x.json")
    assert opened.taught.automaton == taught.automaton


NOTHING_LEFT: dict[str, Callable[[Lesson], Lesson]] = {
    "watched": lambda lesson: replace(
        lesson, examples=tuple(each for each in lesson.examples if not each.is_from_press)
    ),
    "quarantined": lambda lesson: replace(
        lesson, examples=tuple(replace(each, quarantined="a slip") for each in lesson.examples)
    ),
    "defaults that do not teach": lambda lesson: replace(
        lesson,
        examples=(Example(1, "forward", (nan,) * 4, "forward", ExampleKind.DEFAULT),),
        options=LearnerOptions(learner=TreeOptions(defaults=False, order="flags first")),
    ),
}


@pytest.mark.parametrize("left", NOTHING_LEFT.values(), ids=NOTHING_LEFT)
def test_a_lesson_that_teaches_nothing_needs_no_learner(left: Callable[[Lesson], Lesson]) -> None:
    """Neither as it is written now, nor as 0.1.0 did, without trees."""
    original = make_goto()
    assert original.lesson is not None
    lesson = left(original.lesson)
    assert not lesson.teaches
    data = encode_document(TrainedAutomaton(lesson.automaton, lesson))
    assert b'"built": null' not in data
    without = json.dumps({**json.loads(data), "built": None}).encode()
    for each in (data, without):
        opened = decode_document(each, make_kit(original.automaton), path="x")
        assert (opened.rebuilt, opened.taught.automaton.transitions) == (None, {})


def test_classifiers_are_fitted_on_opening() -> None:
    original = make_goto()
    assert original.lesson is not None
    options = LearnerOptions(
        learner=SklearnOptions("KNeighborsClassifier", {"n_neighbors": 1, "weights": "distance"})
    )
    lesson = replace(original.lesson, options=options)

    class Fitted:
        def decide(self, values: Any, /) -> int:
            return 0

        def path(self, values: Any, /) -> tuple[tuple[Any, ...], int]:
            return (), 0

    data = encode_document(
        TrainedAutomaton(replace(original.automaton, transitions={"start": Fitted()}), lesson)
    )
    opened = decode_document(data, make_kit(original.automaton), path="x", learn=rebuild)
    assert opened.rebuilt is not None
    assert opened.taught.lesson is not None
    assert opened.taught.lesson.options == options


def test_automata_written_by_hand_keep_their_trees() -> None:
    automaton = Automaton("hand", (START, State("on")), transitions={"start": Tree((make_leaf(1),))})
    assert decode_document(
        encode_document(TrainedAutomaton(automaton)), None, path="x"
    ).taught == TrainedAutomaton(automaton)


def test_stateless_automata_store_their_one_tree_once() -> None:
    tree = Tree((make_leaf(1),))
    automaton = Automaton("p", (START, State("on")), stateless=True, transitions={"start": tree, "on": tree})
    data = encode_document(TrainedAutomaton(automaton))
    assert data.count(b'"node"') == 1
    back = decode_document(data, None, path="x").taught.automaton
    assert back == automaton
    assert back.transitions["start"] is back.transitions["on"]


def test_migration(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each older format is brought to the next by a function."""
    monkeypatch.setattr(library_schema, "MIGRATIONS", {})
    data = (
        encode_document(make_goto())
        .replace(b'"format": 1', b'"format": 0')
        .replace(b'"name": "goto"', b'"called": "goto"')
    )

    def to_1(raw: dict[str, Any]) -> dict[str, Any]:
        raw["automaton"]["name"] = raw["automaton"].pop("called")
        return raw

    monkeypatch.setattr("understudy.storage.document.MIGRATIONS", {0: to_1})
    assert decode_document(data, make_kit(make_goto().automaton), path="x").taught == make_goto()


def test_what_could_not_be_opened_again_is_not_stored() -> None:
    original = make_goto()
    assert original.lesson is not None
    with pytest.raises(DefinitionError, match="other states"):
        encode_document(TrainedAutomaton(replace(original.automaton, parameters=("B",)), original.lesson))
    bad = replace(original.lesson.examples[0], state="nowhere")
    with pytest.raises(DefinitionError, match="nowhere"):
        encode_document(TrainedAutomaton(original.automaton, replace(original.lesson, examples=(bad,))))


def test_no_pickle() -> None:
    """Values can be pickled for process pools, but nothing is ever unpickled here.

    What is compiled is, since Numba pickles it: from the user's own cache, and from a child process.
    """
    for module in (module for module in Path("src").rglob("*.py") if module.parent.name != "jit"):
        assert re.findall(r"import pickle|pickle\.load|Unpickler", module.read_text()) == []


@pytest.mark.parametrize(("value", "changed"), [(1.0, False), (nan, True)])
def test_trees_of_the_first_learner_are_built_again_only_where_they_differ(
    value: float, changed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They do where a watched example has seen absence."""
    original = make_goto()
    assert original.lesson is not None
    values = (value,) * len(original.automaton.features)
    seen = Example(99, "start", values, "start", ExampleKind.WATCHED)
    pressed = (example for example in original.lesson.examples if example.is_from_press)
    lesson = replace(original.lesson, examples=(*pressed, seen))
    monkeypatch.setattr(document, "LEARNER_VERSION", 1)
    data = encode_document(replace(original, lesson=lesson))
    monkeypatch.undo()
    opened = decode_document(data, make_kit(original.automaton), path="x", learn=rebuild)
    assert (opened.rebuilt is not None) == changed
