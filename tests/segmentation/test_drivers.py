"""Lessons of several drivers: merged with who showed what, contradictions by name, and one of them trusted."""

from __future__ import annotations

import json
from contextlib import closing
from dataclasses import replace
from itertools import pairwise
from math import comb
from pathlib import Path

import pytest
from tests.segmentation.driven import ANNA, BEN, FAR, make_lesson, read

from understudy import (
    START,
    Automaton,
    BoundFeature,
    Continuous,
    DriveLesson,
    Example,
    ExampleKind,
    Feature,
    Lesson,
    State,
    TrainedAutomaton,
    diff_automata,
    find_driver_contradictions,
    learn,
    learn_automaton,
    make_candidates,
    merge_driver_lessons,
    segment,
    settle_driver_contradictions,
)
from understudy.addons.recordings.drive_examples import make_replay
from understudy.addons.recordings.driver_contradictions import list_drivers
from understudy.addons.recordings.lesson_from_drive import to_lesson
from understudy.errors import DefinitionError, FileError, UnknownName
from understudy.judging.explain_run import explain_query
from understudy.judging.explanation_text import describe_source, list_example_data
from understudy.judging.tracing import TransitionQuery
from understudy.learning.explain import explain
from understudy.model.example_source import ExampleSource
from understudy.records.join_records import refuse_other_robot
from understudy.records.replay import ReplayBody
from understudy.storage.document import decode_document, encode_document
from understudy.training.feature_values import compute_example_values
from understudy.training.reaction_time import estimate_reaction_time
from understudy.training.session import Session


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a recording of each driver, `far.csv` of Ben who goes back earlier."""
    made = tmp_path_factory.mktemp("drives")
    for name, driver in (("anna", ANNA), ("ben", BEN), ("far", FAR)):
        driver.write(made / f"{name}.csv")
    return made


@pytest.fixture(scope="module")
def anna(folder: Path) -> DriveLesson:
    """The lesson of Anna, who goes back at 1 m."""
    return make_lesson(folder / "anna.csv", "anna")


@pytest.fixture(scope="module")
def shared_lesson(folder: Path, anna: DriveLesson) -> DriveLesson:
    """The lesson of Anna and Ben, who both go back at 1 m."""
    return merge_driver_lessons([anna, make_lesson(folder / "ben.csv", "ben")])


@pytest.fixture(scope="module")
def torn(folder: Path, anna: DriveLesson) -> DriveLesson:
    """The lesson of Anna, and of Ben who goes back at 2 m."""
    return merge_driver_lessons([anna, make_lesson(folder / "far.csv", "ben")])


def find_turn(lesson: Lesson) -> float:
    """The range (m) at which the automaton goes back, by halving: it stays at 3 m and has gone back at 0 m."""
    function, near, far = learn(lesson)["forward"], 0.0, 3.0
    back = lesson.automaton.index("back")
    assert function.decide([near]) == back != function.decide([far])
    for _ in range(40):
        middle = (near + far) / 2
        near, far = (middle, far) if function.decide([middle]) == back else (near, middle)
    return near


def test_drivers_who_agree_teach_as_well_as_one(anna: DriveLesson, shared_lesson: DriveLesson) -> None:
    assert find_turn(shared_lesson.lesson) == pytest.approx(1.0, abs=0.1)
    assert abs(find_turn(shared_lesson.lesson) - 1.0) <= abs(find_turn(anna.lesson) - 1.0) + 0.05
    assert find_driver_contradictions(shared_lesson.lesson) == ()


def test_each_example_says_who_showed_it(folder: Path, anna: DriveLesson, shared_lesson: DriveLesson) -> None:
    lesson = shared_lesson.lesson
    numbers = [each.number for each in lesson.examples]
    assert len(set(numbers)) == len(numbers) > len(anna.lesson.examples)
    assert shared_lesson.drivers == ("anna", "ben")
    for example in lesson.examples:
        source = example.source
        assert source is not None
        assert source.file == f"{source.driver}.csv"
        # The recorded row is that of the time: the range is what the file has there.
        rows = (folder / source.file).read_text().splitlines()[1:]
        ranges = {row.split(",")[0]: float(row.split(",")[1]) for row in rows}
        assert lesson.record.values[example.moment or 0, 0] == ranges[f"{source.time_s:.2f}"]


def test_presses_of_each_driver_are_as_late_as_theirs(shared_lesson: DriveLesson) -> None:
    lesson = shared_lesson.lesson
    late = {
        each.source.driver: each.reaction_s
        for each in lesson.examples
        if each.source is not None and each.is_from_press
    }
    assert late == {"anna": pytest.approx(0.1, abs=0.051), "ben": pytest.approx(0.35, abs=0.051)}
    assert all(each.reaction_s is None for each in lesson.examples if not each.is_from_press)
    # Values that are computed again, as when a feature is added, are those that each driver decided by.
    steady: frozenset[str] = frozenset()
    for example in lesson.examples:
        assert compute_example_values(example, lesson, lesson.record, steady=steady) == example.values
    other = replace(lesson, options=replace(lesson.options, reaction_s=0.9))
    directive = next(each for each in lesson.examples if each.kind is ExampleKind.DIRECTIVE and each.window)
    assert compute_example_values(directive, other, lesson.record, steady=steady) == directive.values


def test_drivers_of_one_reaction_time_leave_it_to_the_lesson(folder: Path, anna: DriveLesson) -> None:
    lesson = merge_driver_lessons([anna, make_lesson(folder / "anna.csv", "eva")]).lesson
    assert lesson.options.reaction_s == anna.lesson.options.reaction_s
    assert all(each.reaction_s is None for each in lesson.examples)


def test_contradictions_are_named(torn: DriveLesson) -> None:
    lesson = torn.lesson
    (found,) = find_driver_contradictions(lesson)
    assert (found.state, found.drivers, found.nexts) == ("forward", ("anna", "ben"), ("forward", "back"))
    by_number = {each.number: each for each in lesson.examples}
    for numbers, name, following in zip(found.numbers, found.drivers, found.nexts, strict=True):
        shown = [by_number[number] for number in numbers]
        assert {(each.source and each.source.driver, each.next) for each in shown} == {(name, following)}
    assert all(1.0 < by_number[number].values[0] < 2.1 for number in found.numbers[0])
    anna, ben = found.examples
    assert anna.source is not None
    assert ben.source is not None
    assert str(found) == (
        f"anna stays in forward at range(ball) = {anna.values[0]:.2f} (anna.csv at {anna.source.time_s:.1f} s); "
        f"ben switches from forward to back at range(ball) = {ben.values[0]:.2f} (far.csv at "
        f"{ben.source.time_s:.1f} s)"
    )


def list_settled(before: Lesson, after: Lesson) -> list[Example]:
    """The examples that were put into quarantine; others were in doubt before."""
    doubtful = {each.number for each in before.examples if each.quarantined}
    return [each for each in after.examples if each.quarantined and each.number not in doubtful]


@pytest.mark.parametrize(("trusted", "turn"), [("anna", 1.0), ("ben", 2.0)])
def test_a_trusted_driver_settles_them(torn: DriveLesson, trusted: str, turn: float) -> None:
    settled = settle_driver_contradictions(torn.lesson, trusted)
    assert find_turn(settled) == pytest.approx(turn, abs=0.1)
    assert find_driver_contradictions(settled) == ()
    out = list_settled(torn.lesson, settled)
    assert out
    assert all(each.source is not None and each.source.driver != trusted for each in out)
    assert all(each.quarantined.startswith(f"contradicts {trusted} ") for each in out)


def show_by_hand(stays: int, switches: int, *, apart_s: float) -> Lesson:
    """A lesson in which Anna stays between 1 and 2 m, and Ben goes back there; both know 3 m and 1 m.

    Anna's stays are `apart_s` before her switch.
    """
    distance = BoundFeature(Feature("range", Continuous(), reading="range"))
    states = (START, State("forward", "forward"), State("back", "back"))
    rows = [
        ("anna", 3.0, "forward", ExampleKind.DEFAULT, 0.0),
        ("ben", 3.0, "forward", ExampleKind.DEFAULT, 0.0),
    ]
    rows += [
        ("anna", 1.1 + 0.8 * at / stays, "forward", ExampleKind.WATCHED, 9.0 - apart_s) for at in range(stays)
    ]
    rows += [("anna", 1.0, "back", ExampleKind.DIRECTIVE, 9.0)]
    rows += [("ben", 2.0, "back", ExampleKind.DIRECTIVE, 9.0) for _ in range(switches)]
    return Lesson(
        Automaton("driven", states=states, features=(distance,)),
        tuple(
            Example(
                number,
                "forward",
                (at,),
                following,
                kind,
                source=ExampleSource(f"{driver}.csv", time_s, driver),
            )
            for number, (driver, at, following, kind, time_s) in enumerate(rows, 1)
        ),
    )


CHANCES = [  # Anna's stays, Ben's switches; how likely by chance, whether it is a contradiction
    (8, 3, 1 / 165, True),
    (8, 2, 1 / 45, True),
    (8, 1, 1 / 9, False),
    (20, 1, 1 / 21, True),
    (19, 1, 1 / 20, False),
    (3, 2, 1 / 10, False),
    (3, 3, 1 / 20, False),
    (4, 3, 1 / 35, True),
]


@pytest.mark.parametrize(("stays", "switches", "chance", "is_contradiction"), CHANCES)
def test_what_chance_explains_is_no_contradiction(
    stays: int, switches: int, chance: float, is_contradiction: bool
) -> None:
    """If it did not matter who drove, the switches would be Ben's in one of so many ways to choose them."""
    assert chance == pytest.approx(1 / comb(stays + switches, switches))
    assert is_contradiction == (chance < 0.05)
    found = find_driver_contradictions(show_by_hand(stays, switches, apart_s=2.0))
    assert [each.drivers for each in found] == [("anna", "ben")] * is_contradiction


@pytest.mark.parametrize(("apart_s", "found"), [(0.39, 0), (0.41, 1)])
def test_who_may_have_been_deciding_does_not_contradict(apart_s: float, found: int) -> None:
    assert len(find_driver_contradictions(show_by_hand(8, 3, apart_s=apart_s))) == found


def test_one_contradiction_alone_is_settled(torn: DriveLesson) -> None:
    (found,) = find_driver_contradictions(torn.lesson)
    settled = settle_driver_contradictions(torn.lesson, "anna", [found])
    assert tuple(each.number for each in list_settled(torn.lesson, settled)) == found.numbers[1]


def test_who_drives_none_of_them_cannot_be_trusted(shared_lesson: DriveLesson) -> None:
    with pytest.raises(UnknownName, match=r"driver 'anne'.*did you mean 'anna'"):
        settle_driver_contradictions(shared_lesson.lesson, "anne")


def test_sources_survive_a_library(torn: DriveLesson) -> None:
    taught = TrainedAutomaton(learn_automaton(torn.lesson), torn.lesson)
    opened = decode_document(encode_document(taught), torn.library.kit, path="driven.json")
    assert opened.rebuilt is None
    again = opened.taught.lesson
    assert again is not None
    assert {each.number: (each.source, each.reaction_s) for each in again.examples} == {
        each.number: (each.source, each.reaction_s) for each in torn.lesson.examples
    }
    assert list_drivers(again) == ["anna", "ben"]
    assert find_driver_contradictions(again) == find_driver_contradictions(torn.lesson)
    why = explain(again, "forward", [0.5], opened.taught.automaton.transitions["forward"])
    assert {each.source.driver for each in why.examples if each.source} == {"anna", "ben"}


def test_reasons_and_differences_point_into_recordings(torn: DriveLesson) -> None:
    taught = TrainedAutomaton(learn_automaton(torn.lesson), torn.lesson)
    forward, back = (taught.automaton.index(name) for name in ("forward", "back"))
    query = TransitionQuery(0.0, forward, back, (0.5,))
    reason = explain_query("driven", query, taught)
    first = next(each for each in torn.lesson.examples if (each.state, each.next) == ("forward", "back"))
    assert first.source is not None
    said = f"{first.number} (directive, anna.csv at {first.source.time_s:.1f} s, driven by anna)"
    assert describe_source(reason).startswith(f"shown by {said}, ")
    assert list_example_data(reason)[0].source == first.source
    fewer = replace(torn.lesson, examples=tuple(each for each in torn.lesson.examples if each != first))
    lines = diff_automata(taught, TrainedAutomaton(learn_automaton(fewer), fewer))["examples"]
    assert lines == [
        f"- {first.number}  in forward go to back (directive): range(ball) {first.values[0]:.4g}"
        f" - from anna.csv at {first.source.time_s:.1f} s, driven by anna"
    ]


def test_a_resumed_session_keeps_sources_and_reaction_times(
    tmp_path: Path, folder: Path, shared_lesson: DriveLesson
) -> None:
    drive, _ = read(folder / "anna.csv")

    def replay() -> ReplayBody:
        return make_replay(drive, drive.episodes[0])

    journal = tmp_path / "a.journal"
    with closing(Session(replay(), shared_lesson.library, shared_lesson.lesson, journal=journal)) as session:
        session.quarantine({shared_lesson.lesson.examples[5].number: "a slip"})
        before = session.lesson.examples
    with closing(Session.resume(journal, replay(), shared_lesson.library)) as session:
        after = session.lesson.examples
        assert after == before
        session.change_design(features=[*shared_lesson.lesson.automaton.features, "time_in_state"])
        added = {each.number: each for each in session.lesson.examples}
    for example in shared_lesson.lesson.examples:
        assert added[example.number].values[:1] == example.values
        assert added[example.number].source == example.source


def test_reaction_times_that_are_known_are_not_estimated_again(
    anna: DriveLesson, shared_lesson: DriveLesson
) -> None:
    assert estimate_reaction_time(anna.lesson, steady=frozenset()) is not None
    assert estimate_reaction_time(shared_lesson.lesson, steady=frozenset()) is None


def test_sources_teach_nothing(anna: DriveLesson) -> None:
    other = replace(
        anna.lesson,
        examples=tuple(
            replace(each, source=ExampleSource("other.csv", 1.0, "eva")) for each in anna.lesson.examples
        ),
    )
    without = replace(other, examples=tuple(replace(each, source=None) for each in other.examples))
    assert learn(other) == learn(anna.lesson) == learn(without)
    hashes = {
        json.loads(encode_document(TrainedAutomaton(learn_automaton(each), each)))["built"]["hash"]
        for each in (anna.lesson, other, without)
    }
    assert len(hashes) == 1


def test_a_column_of_times_of_another_length_is_refused(anna: DriveLesson) -> None:
    data = json.loads(encode_document(TrainedAutomaton(learn_automaton(anna.lesson), anna.lesson)))
    data["lesson"]["watched"][0]["source"]["time_s"].pop()
    with pytest.raises(FileError, match=r"lesson\.watched\[0\]\.source\.time_s.*entries, but 'number' has"):
        decode_document(json.dumps(data).encode(), anna.library.kit, path="driven.json", learn=learn)


def test_states_that_only_one_driver_uses_are_kept(tmp_path: Path, anna: DriveLesson) -> None:
    """Ben's piece ends before he goes back the first time: only Anna shows when."""
    rows = BEN.drive()
    turn = next(at for at, row in enumerate(rows[1:], 1) if float(row.split(",")[2]) < -0.2)
    (tmp_path / "ben.csv").write_text("\n".join(rows[: turn - 2]) + "\n")
    drive, library = read(tmp_path / "ben.csv")
    part = to_lesson(segment(drive, make_candidates(library, drive)), driver="ben", library=library)
    assert part.lesson.automaton.state_names == ("start", "forward")
    for order in ([anna, part], [part, anna]):
        merged = merge_driver_lessons(order).lesson
        assert set(merged.automaton.state_names) == {"start", "forward", "back"}
        assert find_turn(merged) == pytest.approx(1.0, abs=0.1)


def test_what_does_not_fit_is_refused(tmp_path: Path, folder: Path, anna: DriveLesson) -> None:
    nobody = make_lesson(folder / "anna.csv", "")
    with pytest.raises(DefinitionError, match="there are none"):
        merge_driver_lessons([])
    with pytest.raises(DefinitionError, match="one has no name of its driver"):
        merge_driver_lessons([anna, nobody])
    with pytest.raises(DefinitionError, match="two are of driver 'anna'"):
        merge_driver_lessons([anna, anna])
    rows = [row.replace("range(ball)", "range(cup)") for row in BEN.drive()]
    (tmp_path / "ben.csv").write_text("\n".join(rows) + "\n")
    with pytest.raises(
        DefinitionError, match=r"lesson of ben.*range\(cup\).*those of anna are range\(ball\)"
    ):
        merge_driver_lessons([anna, make_lesson(tmp_path / "ben.csv", "ben")])
    drives = [read(place / f"{name}.csv")[0] for place, name in ((folder, "anna"), (tmp_path, "ben"))]
    with pytest.raises(DefinitionError, match=r"recording ben\.csv: its readings are range\(cup\)"):
        refuse_other_robot(*drives)


def test_merged_lessons_can_be_merged_with_a_third(folder: Path, shared_lesson: DriveLesson) -> None:
    merged = merge_driver_lessons([shared_lesson, make_lesson(folder / "anna.csv", "eva")])
    assert merged.drivers == ("anna", "ben", "eva")
    numbers = [each.number for each in merged.lesson.examples]
    assert all(one < other for one, other in pairwise(numbers))
