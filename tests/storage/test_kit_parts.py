"""What a lesson of a recording needs, kept in its document, and joined where a folder has several."""

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from understudy.errors import DefinitionError, FileError
from understudy.learning.fit import learn, learn_automaton
from understudy.model.automaton import Automaton, State
from understudy.model.behaviors import Behavior, Command, behavior
from understudy.model.binding import Binding, Target
from understudy.model.features import BoundFeature, Feature
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Kit, Library, TrainedAutomaton, make_lesson_kit
from understudy.model.value_kinds import BOOLEAN, Categorical, Column, Continuous, Toroidal
from understudy.storage.json_text import Source
from understudy.storage.kit_parts import decode_kit, encode_kit, join_kits
from understudy.storage.library_folder import find_recorded_kits, open_library, save_automaton

NAMES = st.text("abcxyz_", min_size=1, max_size=5)
KINDS = st.sampled_from([Continuous(), Toroidal(), Toroidal(360.0), BOOLEAN, Categorical(("red", "green"))])
FEATURES = st.builds(
    Feature,
    NAMES,
    KINDS,
    NAMES,
    of=st.sampled_from([None, "A"]),
    unit=st.sampled_from(["", "m", "rad"]),
    doc=NAMES,
)
SPEEDS = st.dictionaries(NAMES, st.floats(-10, 10), max_size=3)
BEHAVIORS = st.builds(lambda name, speeds: Behavior(name, Command(**speeds)), NAMES, SPEEDS)


def unique(parts: list) -> list:  # type: ignore[type-arg]
    return list({each.name: each for each in parts}.values())


@given(st.lists(FEATURES), st.lists(BEHAVIORS), st.lists(st.builds(Target, NAMES)))
def test_a_kit_comes_back_as_it_was(
    features: list[Feature], behaviors: list[Behavior], targets: list[Target]
) -> None:
    kit = Kit.from_parts(*unique(features), *unique(behaviors), *unique(targets))
    assert decode_kit(encode_kit(kit), Source("a.json", ""), ("lesson", "kit")) == kit


def test_a_function_is_refused() -> None:
    @behavior
    def turn(readings: object) -> dict[str, Column]:
        return {}

    with pytest.raises(DefinitionError, match="'turn' is a function"):
        encode_kit(Kit.from_parts(turn))


def teach(name: str, speed: float = 0.8) -> TrainedAutomaton:
    """An automaton that goes forward until it is near, learned from a recording."""
    near = BoundFeature(Feature("range", Continuous(), "range", of="A", unit="m"), Binding({"A": "ball"}))
    automaton = Automaton(name, (State("start"), State("forward", "forward"), State("back", "back")), (near,))
    examples = (
        Example(1, "start", (3.0,), "forward", ExampleKind.DIRECTIVE),
        Example(2, "forward", (1.0,), "back", ExampleKind.DIRECTIVE),
        Example(3, "forward", (3.0,), "forward", ExampleKind.DEFAULT),
    )
    kit = Kit.from_parts(
        Behavior("forward", Command(drive=speed)), Behavior("back", Command(drive=-0.5)), Target("ball")
    )
    lesson = Lesson(automaton, examples, kit=make_lesson_kit(automaton, Library(kit)))
    return TrainedAutomaton(learn_automaton(lesson), lesson)


def test_a_folder_opens_with_what_its_lessons_need(tmp_path: Path) -> None:
    save_automaton(tmp_path, teach("driven"))
    library = open_library(tmp_path, Kit.from_parts(), learn).library
    assert library.kit.behaviors["forward"].command == {"drive": 0.8}
    assert list(library.kit.targets) == ["ball"]
    assert library.kit.features["range"] == Feature("range", Continuous(), "range", of="A", unit="m")


def test_parts_that_a_program_defines_come_first(tmp_path: Path) -> None:
    save_automaton(tmp_path, teach("driven"))
    own = Kit.from_parts(Behavior("forward", Command(drive=0.1)))
    assert open_library(tmp_path, own, learn).library.kit.behaviors["forward"].command == {"drive": 0.1}


def test_two_files_that_mean_different_things_are_refused(tmp_path: Path) -> None:
    save_automaton(tmp_path, teach("driven"))
    save_automaton(tmp_path, teach("slow", 0.2))
    with pytest.raises(FileError, match=r"slow.json .*'forward' is something else than in .*driven.json"):
        join_kits(find_recorded_kits(tmp_path))


def test_an_automaton_of_the_folder_is_no_basic_behavior(tmp_path: Path) -> None:
    save_automaton(tmp_path, teach("driven"))
    save_automaton(tmp_path, teach("back"))
    ((kit, _), *_) = find_recorded_kits(tmp_path)
    assert list(kit.behaviors) == ["forward"]


def test_a_lesson_without_a_kit_has_none(tmp_path: Path) -> None:
    taught = teach("driven")
    assert taught.lesson is not None
    path = save_automaton(tmp_path, TrainedAutomaton(taught.automaton, replace(taught.lesson, kit=None)))
    assert '"kit"' not in path.read_text()
    assert find_recorded_kits(tmp_path) == []
