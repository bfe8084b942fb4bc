"""Changing a lesson: undo and redo, delete, edit, choose anew; nothing shown is lost on the way."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import pytest
from tests.bodies import Scripted, kit
from tests.make.programs import make_automaton
from tests.make.sessions import ROBOT, WITH_GO, list_rows, make_row, make_session, play

from understudy.errors import (
    DefinitionError,
    KindError,
    SessionError,
    SettingError,
    UnboundParameter,
    UnderstudyError,
    UnknownName,
)
from understudy.model.automaton import START, Automaton
from understudy.model.binding import Binding
from understudy.model.features import ReadingsView, feature
from understudy.model.learner_options import LearnerOptions, SklearnOptions
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.model.value_kinds import BOOLEAN, Column
from understudy.runtime.link import link
from understudy.storage.document import decode_document, encode_document
from understudy.training.edits import DesignChange
from understudy.training.lesson_design import new_lesson, parse_state
from understudy.training.session import Session
from understudy.training.trainee import Mode

STEPS: dict[str, tuple[Callable[[Session], Any], str]] = {
    "press": (lambda taught: play(taught, "left", 1), "forward → left"),
    "confirmation": (lambda taught: play(taught, "confirm", 1), "forward → forward"),
    "delete": (lambda taught: taught.delete(1, 2), "delete 2 examples"),
    "edit": (lambda taught: taught.edit(1, next="left", values={"load": 7.0}), "edit example 1"),
    "features": (lambda taught: taught.change_design(features=["seen", "done"]), "choose features"),
    "states": (lambda taught: taught.change_design(states=["forward"]), "choose states"),
    "flags": (lambda taught: taught.change_design(flags=["failed"]), "choose flags"),
    "options": (
        lambda taught: taught.change_design(options=LearnerOptions(reaction_s=0.2)),
        "choose options",
    ),
    "stateless": (lambda taught: taught.change_design(stateless=True), "choose stateless"),
    "parameters": (
        lambda taught: taught.change_design(
            parameters=["A"], features=["range_of(A)"], targets={"A": "goal"}
        ),
        "choose parameters and features",
    ),
}


@feature(BOOLEAN)
def nearer(_: ReadingsView, start: ReadingsView, goal: ReadingsView) -> Column:
    """Whether the start is nearer than the goal: declared otherwise than by alphabet."""
    return (start.range < goal.range).astype(float)


def test_labels_are_read_as_they_are_written() -> None:
    """With two parameters they would swap what these stand for."""
    library = Library(Kit.from_parts(*kit.parts, nearer))
    labels = ["nearer(ball, goal)", "nearer(goal, ball)", "range_of(goal)"]
    taught = make_session(features=labels, library=library)
    before = taught.automaton
    assert [str(bound) for bound in before.features] == labels
    assert list(taught.view().features.items())[:2] == [
        ("nearer(ball, goal)", 1.0),
        ("nearer(goal, ball)", 0.0),
    ]
    taught.change_design(features=[str(bound) for bound in before.features])
    assert taught.automaton == before
    document = encode_document(play(taught, "forward", 2).make_trained_automaton())
    opened = decode_document(document, library.kit, path="taught").taught
    assert list(map(str, opened.automaton.features)) == labels


def test_calls_are_read_as_they_are_written() -> None:
    """In a state, too."""
    between = Automaton("between", (START,), parameters=("here", "aim"))
    library = Library(kit).with_automaton(TrainedAutomaton(between))
    (state,) = make_session(["between(ball, goal)"], library=library).automaton.states[1:]
    assert state.binding == Binding(here="ball", aim="goal")
    call = library.format_call("between", state.binding)
    assert call == "between(ball, goal)"
    assert parse_state(library, call) == state
    assert str(link(library, "between", state.binding).root) == call
    assert library.format_call("unknown", state.binding) == "unknown(goal, ball)"


def begin_session() -> Session:
    """Two presses, in a state and then in a flag-less other; now in forward."""
    return play(
        make_session(["forward", "left"], ["range_of(ball)", "load"], flags=["done"]),
        3,
        "left",
        4,
        "forward",
        3,
    )


@pytest.mark.parametrize(("step", "what"), STEPS.values(), ids=STEPS)
def test_undo_and_redo(step: Callable[[Session], Any], what: str) -> None:
    taught = begin_session()
    before, path = taught.lesson, taught.view().path
    step(taught)
    after, path_after = taught.lesson, taught.view().path
    assert (before.automaton, before.examples, before.options) != (
        after.automaton,
        after.examples,
        after.options,
    )
    assert taught.view().undoable == what
    for _ in range(2):
        assert taught.undo() == what
        assert taught.lesson == before
        assert taught.view().path == path
        assert taught.view().redoable == what
        assert taught.redo() == what
        assert taught.lesson == after
        assert taught.view().path == path_after


def test_undo_restores_the_run_state_as_it_was_when_pressed() -> None:
    """Counters, timers, time in state and what runs below; the world and its clock go on."""
    taught = make_session(["go", "left"], ["time_in_state"], library=WITH_GO)
    play(taught, "go", 5)
    before = taught.run_state
    play(taught, "left", 10)
    taught.undo()
    assert taught.run_state == before
    assert [level.time_in_state for level in taught.run_state] == [0.5, 0.3]
    assert taught.body.time_s == pytest.approx(1.5)
    taught.redo()
    assert taught.run_state[0].time_in_state == 0.0


def test_undo_in_another_world_has_no_negative_times() -> None:
    taught = play(make_session(features=["time_in_state"]), 20, "forward", 5, "left", 1)
    taught.reset(1)
    taught.undo()
    assert taught.run_state[0].time_in_state == 0.5
    play(taught, 1)
    assert taught.view().features["time_in_state"] == 0.6


def test_undo_takes_back_a_press_that_waits() -> None:
    """And nothing but that press; the next undo takes back the step before it."""
    taught = play(make_session(), "forward", 1)
    before = list_rows(taught)
    play(taught, "left")
    assert taught.view().undoable == "forward → left"
    assert taught.undo() == "forward → left"
    play(taught, 1)
    assert (list_rows(taught), taught.view().path) == (before, ("forward",))
    taught.undo()
    assert list_rows(taught) == []


def test_undo_of_a_first_press_that_waits() -> None:
    taught = play(make_session(), 1, "left", "undo", 1)
    assert (list_rows(taught), taught.view().path) == ([], ("start",))
    assert taught.view().undoable is None


def test_undo_of_a_correction_that_waits_goes_on_testing() -> None:
    taught = play(make_session(), "forward", 2, "test", 1, "left", "undo")
    assert taught.mode is Mode.TESTING
    play(taught, 2, "right", 1)
    assert [example.correction for example in taught.examples] == [False, False, True, True]


def test_a_new_step_ends_redoing() -> None:
    taught = play(make_session(), "forward", 1, "undo", "left", 1)
    with pytest.raises(SessionError, match="nothing to redo"):
        taught.redo()
    taught.undo()
    with pytest.raises(SessionError, match="nothing to undo"):
        taught.undo()


def test_undo_restarts_where_the_state_is_gone() -> None:
    taught = make_session(["forward"])
    taught.change_design(states=["forward", "left"])
    play(taught, "left", 1)
    taught.undo()
    play(taught, 3, "left", 2)  # in left again
    taught.delete(1)
    taught.undo()
    taught.undo()
    taught.undo()
    assert taught.automaton.state_names == ("start", "forward")
    assert taught.view().path == ("start",)


def test_undo_while_testing_learns_again() -> None:
    taught = play(make_session(["forward", "left"]), "forward", 5, "left", 1)
    taught.reset(0)
    taught.test()
    taught.undo()
    assert taught.mode is Mode.TESTING
    assert play(taught, 10).view().path == ("forward",)
    taught.redo()
    assert taught.view().path == ("left",)


RENAMED = [  # states, and new names by those they had; the examples then
    (["ahead=forward", "left"], {"forward": "ahead"}, [("start", "ahead"), ("ahead", "ahead")]),
    (
        ["left=forward", "forward=left"],
        {"forward": "left", "left": "forward"},
        [("start", "left"), ("left",) * 2],
    ),
    (["left=forward"], {"forward": "left"}, [("start", "left"), ("left",) * 2]),
    (["ahead=forward", "forward"], {"forward": "ahead"}, [("start", "ahead"), ("ahead",) * 2]),
]


@pytest.mark.parametrize(("states", "names", "examples"), RENAMED)
def test_examples_go_with_a_state_that_gets_another_name(
    states: list[str], names: dict[str, str], examples: list[tuple[str, ...]]
) -> None:
    """Those of a state that is left out do not go to another that gets its name."""
    taught = play(make_session(["forward", "left"]), "forward", 5)
    taught.change_design(states=states, names=names)
    assert [(each.state, each.next) for each in taught.examples[:2]] == examples
    assert taught.undo() == "choose states and names"
    assert taught.view().path == ("forward",)


def test_undo_in_testing_to_where_too_little_is_left_for_the_classifier() -> None:
    """It needs three examples of a state; with fewer there is nothing to test, and it waits for presses."""
    nearest = LearnerOptions(learner=SklearnOptions("KNeighborsClassifier", {"n_neighbors": 3}))
    taught = play(
        make_session(["forward", "left"], options=nearest), "forward", 2, "left", 2, "forward", 2, "left", 2
    )
    taught.test()
    assert (taught.undo(), taught.mode, len(taught.examples)) == ("forward → left", Mode.TRAINING, 6)


# Edits


def test_delete() -> None:
    taught = begin_session()
    taught.delete(2, 3)
    assert [example.number for example in taught.examples] == [1, 4]
    play(taught, "left", 1)
    assert [example.number for example in taught.examples] == [1, 4, 5, 6]


def test_quarantine_and_back() -> None:
    """What is in quarantine is still there, says why, teaches nothing, and comes back."""
    taught = begin_session()
    before = taught.make_trained_automaton()
    number = next(example.number for example in taught.examples if example.kind == ExampleKind.DIRECTIVE)
    taught.quarantine({number: "pressed by mistake"})
    assert [example.quarantined for example in taught.examples if example.number == number] == [
        "pressed by mistake"
    ]
    assert len(taught.examples) == len(before.lesson.examples)  # type: ignore[union-attr]
    state = taught.examples[number - 1].state
    assert (
        taught.make_trained_automaton().automaton.transitions.get(state)
        != before.automaton.transitions[state]
    )
    taught.quarantine({number: ""})
    assert taught.make_trained_automaton() == before
    taught.quarantine({number: ""})  # it teaches already: there is nothing to undo
    taught.quarantine({})
    assert (taught.undo(), taught.undo()) == ("release 1 example", "quarantine 1 example")
    assert taught.make_trained_automaton() == before


def test_a_slip_is_mended_with_what_it_recorded_on_its_way() -> None:
    """Example 1 led from start to left, with default 2 there; what was meant was forward, so 2 shows nothing."""
    taught = begin_session()
    before = taught.examples
    taught.correct_slip(1, "forward")
    assert list_rows(taught)[0] == (*list_rows(taught)[0][:-2], "forward", "directive")
    assert [each.quarantined for each in taught.examples[:2]] == ["", "Example 1 was a slip."]
    assert taught.undo() == "mend example 1"
    assert taught.examples == before


EDITS = [  # what is given for example 2, (left, 97 m, left, default); what it is then
    ({"next": "forward"}, ("left", 97, 0, "forward", "directive")),
    ({"state": "forward", "next": "forward"}, ("forward", 97, 0, "forward", "confirmation")),
    ({"state": "forward"}, ("forward", 97, 0, "left", "directive")),
    ({"values": {"load": 3.0}}, ("left", 97, 3, "left", "default")),
    ({"next": "done"}, ("left", 97, 0, "done", "directive")),
]


@pytest.mark.parametrize(("edit", "expected"), EDITS)
def test_edit(edit: dict[str, Any], expected: tuple[Any, ...]) -> None:
    taught = begin_session()
    taught.edit(2, **edit)
    assert list_rows(taught)[1] == expected
    assert taught.examples[1].edited == ("values" in edit)


def test_edited_values_stay_when_features_and_options_change() -> None:
    taught = begin_session()
    taught.edit(1, values={"range_of(ball)": 50.0})
    taught.change_design(options=LearnerOptions(reaction_s=0.2))
    assert list_rows(taught)[0] == ("start", 50, 0, "left", "directive")
    taught.change_design(features=["seen", "range_of(ball)"])
    assert list_rows(taught)[0] == ("start", 1, 50, "left", "directive")
    assert list_rows(taught)[1] == ("left", 1, 99, "left", "default")


# Choosing anew


def test_features_added_and_dropped() -> None:
    taught = begin_session()
    taught.change_design(features=["load", "bearing_of(goal)", "time_in_state", "seen", "range_of(goal)"])
    assert list_rows(taught) == [
        ("start", 0, 1, 0.3, 1, 1003, "left", "directive"),
        ("left", 0, 1, 0.0, 1, 1003, "left", "default"),
        ("left", 1, 1, 0.4, 1, 1007, "forward", "directive"),
        ("forward", 1, 1, 0.0, 1, 1007, "forward", "default"),
    ]
    taught.change_design(features=["range_of(ball)", "load"])
    assert list_rows(taught) == list_rows(begin_session())


def test_a_child_flag_can_be_asked_for_later() -> None:
    taught = make_session(["go", "left"], ["range_of(ball)"], library=WITH_GO)
    play(taught, "go", 5, "left", 1)
    taught.change_design(features=["done"])
    assert [example.values for example in taught.examples] == [(0.0,), (0.0,), (1.0,), (0.0,)]


def test_a_flag_of_any_name_is_a_feature_of_what_is_taught_later() -> None:
    spots = make_automaton(
        "spot", ["forward"], {"start": lambda d: "near"}, flags=["near"], features=["range_of(ball)"]
    )
    taught = make_session(["spot", "left"], ["near"], library=Library.from_automata(kit, spots))
    play(taught, "spot", 2, "left", 1)
    assert [example.values for example in taught.examples] == [(0.0,), (0.0,), (1.0,), (0.0,)]
    with pytest.raises(UnknownName, match="no feature 'near'"):
        make_session(["forward"], ["near"])


def test_features_of_a_reopened_lesson_can_change() -> None:
    saved = begin_session().make_trained_automaton()
    again = Session(Scripted(), ROBOT.with_automaton(saved), saved.lesson or begin_session().lesson)
    assert list_rows(again) == list_rows(begin_session())
    again.change_design(features=["range_of(goal)"])
    assert [example.values for example in again.examples] == [(1003.0,), (1003.0,), (1007.0,), (1007.0,)]
    play(again, 2, "left", 1)
    assert list_rows(again)[-1] == ("left", 1002, "left", "default")
    assert again.examples[-1].number == 6


def test_states_that_go_take_their_examples_along() -> None:
    taught = begin_session()
    taught.change_design(states=["forward"])
    assert list_rows(taught) == [("forward", 93, 1, "forward", "default")]
    assert taught.view().path == ("forward",)


def test_a_press_for_a_state_that_goes_is_dropped() -> None:
    taught = play(begin_session(), "left")
    taught.change_design(states=["forward"])
    assert len(list_rows(play(taught, 1))) == 1


def test_a_flag_raised_from_a_state_that_goes_is_not_corrected() -> None:
    taught = play(make_session(["forward", "left"], flags=["done"]), "forward", 5, "done", 1)
    taught.reset(0)
    taught.test()
    play(taught, 8)
    assert taught.view().state == "done"
    taught.change_design(states=["left"])
    play(taught, "left", 1)
    assert list_rows(taught) == []
    taught.test()


def table_lesson() -> Lesson:
    lesson = new_lesson(ROBOT, "taught", states=["forward"], features=["range_of(ball)", "load"], live=False)
    example = Example(1, "start", (5.0, 1.0), "forward", ExampleKind.DIRECTIVE)
    return Lesson(lesson.automaton, (example,))


def test_a_table_can_be_gone_on_with() -> None:
    """Examples without readings around them keep their values; only features they never had are refused."""
    taught = Session(Scripted(), ROBOT, table_lesson())
    taught.change_design(states=["forward", "left"], options=LearnerOptions(reaction_s=0.2))
    taught.change_design(features=["load"])
    assert list_rows(taught) == [("start", 1, "forward", "directive")]
    with pytest.raises(SessionError, match=r"example 1 .* written by hand"):
        taught.change_design(features=["load", "seen"])
    assert list_rows(taught) == [("start", 1, "forward", "directive")]
    play(taught, "left", 1)
    assert len(list_rows(taught)) == 3


# Parameters


def test_parameters_stand_for_targets_kept_per_example() -> None:
    taught = make_session(["toward(A)"], ["range_of(A)"], parameters=["A"], targets={"A": "ball"})
    play(taught, 1, "toward", 1)
    taught.bind_targets(A="goal")
    assert taught.view().targets == {"A": "goal"}
    assert taught.view().features == {"range_of(A)": 1002.0}
    play(taught, 1, "start", 1)
    assert [(make_row(e)[1], e.binding["A"]) for e in taught.examples] == [
        (99, "ball"),
        (99, "ball"),
        (1003, "goal"),
        (1003, "goal"),
    ]
    taught.change_design(features=["bearing_of(A)", "range_of(A)"])
    assert [example.values[1] for example in taught.examples] == [99, 99, 1003, 1003]
    assert [round(example.values[0], 3) for example in taught.examples[2:]] == [1.0, 1.0]


def test_the_robot_acts_on_what_the_parameter_stands_for() -> None:
    body = Scripted()
    taught = make_session(["toward(A)"], parameters=["A"], targets={"A": "goal"}, body=body)
    play(taught, "toward", 1)
    taught.bind_targets(A="ball")
    play(taught, 1)
    assert [round(commands["turn"][0], 3) for commands in body.commanded] == [1.0, 6.1]


def test_standing_for_another_target_keeps_the_state() -> None:
    taught = make_session(["toward(A)"], parameters=["A"], targets={"A": "goal"})
    play(taught, "toward", 3)
    taught.bind_targets(A="ball")
    assert taught.view().path == ("toward",)


def test_a_parameter_can_be_added() -> None:
    taught = begin_session()
    with pytest.raises(UnboundParameter, match="'A'"):
        taught.change_design(parameters=["A"])
    assert taught.automaton.parameters == ()
    assert taught.view().undoable == "left → forward"
    taught.change_design(parameters=["A"], features=["range_of(A)"], targets={"A": "goal"})
    assert [example.values for example in taught.examples] == [(1003.0,), (1003.0,), (1007.0,), (1007.0,)]
    taught.undo()
    assert list_rows(taught) == list_rows(begin_session())


# The others


def test_what_the_others_do_meanwhile() -> None:
    body = Scripted(3)
    taught = make_session(body=body, library=WITH_GO)
    play(taught, "forward", 1)
    taught.set_other_agents("left")
    play(taught, 1)
    taught.set_other_agents("go")
    play(taught, 2)
    taught.set_other_agents(None)
    play(taught, 1)
    assert [commands["drive"] for commands in body.commanded] == [
        [1.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 0.5, 0.5],
        [1.0, 0.0, 0.5],  # agent 1 has come within 98 m of the ball: done, while agent 2 has not
        [1.0, 0.0, 0.0],
    ]
    assert body.commanded[1]["turn"] == [0.5, 1.0, 1.0]


def test_the_others_go_on_whatever_happens_to_the_lesson() -> None:
    """Three ticks of forward, then left for good; undo, testing and driving restart nobody."""
    three = make_automaton(
        "three",
        ["forward", "left"],
        {"start": lambda s: "forward", "forward": lambda s: "left" if s >= 0.3 else None},
        features=["time_in_state"],
    )
    body = Scripted(2)
    taught = make_session(body=body, library=Library.from_automata(kit, three))
    taught.set_other_agents("three")
    play(taught, "right", 2, "undo", 1)
    taught.drive("left")
    play(taught, 1)
    taught.test()
    play(taught, 1)
    assert [commands["drive"][1] for commands in body.commanded] == [1, 1, 1, 0, 0]
    taught.reset(0)
    play(taught, 1)
    assert body.commanded[-1]["drive"][1] == 1


def test_back_to_a_moment() -> None:
    """World, automaton, mode and the others are as they were; the lesson stays, and what follows is the same again."""
    three = make_automaton(
        "three",
        ["forward", "left"],
        {"start": lambda s: "forward", "forward": lambda s: "left" if s >= 0.3 else None},
        features=["time_in_state"],
    )
    body = Scripted(2)
    taught = make_session(body=body, library=Library.from_automata(kit, three))
    taught.set_other_agents("three")
    play(taught, "forward", 2)
    instant = taught.capture()
    play(taught, 3)
    first, then = body.commanded[-3:], (taught.view(), taught.run_state)
    play(taught, "right", 4)
    taught.test()
    play(taught, 2)
    examples = taught.examples
    taught.rewind(instant)
    assert taught.examples == examples
    assert taught.mode is Mode.TRAINING
    play(taught, 3)
    assert body.commanded[-3:] == first
    assert (taught.view().path, taught.run_state) == (then[0].path, then[1])


def test_a_body_that_cannot_be_rewound() -> None:
    class Real(Scripted):
        snapshot = restore = None  # type: ignore[assignment]

    taught = make_session(body=Real(1))
    with pytest.raises(SessionError, match=r"this body cannot be rewound: it is not simulated; drive"):
        taught.capture()


def test_the_others_may_need_a_binding() -> None:
    body = Scripted(2)
    taught = make_session(body=body)
    with pytest.raises(UnboundParameter, match="toward"):
        taught.set_other_agents("toward")
    taught.set_other_agents("toward", {"A": "goal"})
    play(taught, 1)
    assert body.commanded[0]["turn"] == [0.5, 1.0]


# The next automaton


def test_a_saved_automaton_is_a_state_of_the_next() -> None:
    first = play(make_session(["forward"], flags=["done"]), "forward", 3, "done", 1)
    library = ROBOT.with_automaton(first.make_trained_automaton())
    lesson = new_lesson(library, "next", states=["taught", "left"], features=["done"], live=False)
    taught = play(Session(Scripted(), library, lesson), "taught", 6, "left", 1)
    assert list_rows(taught)[2:] == [("taught", 1, "left", "directive"), ("left", 0, "left", "default")]
    taught.reset(0)
    taught.test()
    paths = [play(taught, 1).view().path for _ in range(6)]
    assert paths == [*[("taught", "forward")] * 3, ("taught", "done"), ("left",), ("left",)]


def test_a_correction_goes_to_the_automaton_of_the_session_alone() -> None:
    taught = make_session(["go", "left"], ["done"], library=WITH_GO)
    play(taught, "go", 3)
    taught.test()
    play(taught, 2, "left", 1)
    assert taught.library is WITH_GO
    assert list_rows(taught)[-2][0] == "go"


# What is refused, and changes nothing

REFUSED: dict[str, tuple[Callable[[Session], Any], type[UnderstudyError], str]] = {
    "unknown state": (lambda s: s.direct("fly"), UnknownName, "'fly'.*start, forward, left and done"),
    "unknown example": (lambda s: s.delete(1, 99), SessionError, "no example 99"),
    "editing an unknown one": (lambda s: s.edit(99, next="left"), SessionError, "no example 99"),
    "an unknown one in quarantine": (lambda s: s.quarantine({99: "why"}), SessionError, "no example 99"),
    "editing into nowhere": (lambda s: s.edit(1, next="fly"), UnknownName, "state 'fly'"),
    "editing from a flag": (lambda s: s.edit(1, state="done"), SessionError, "'done'"),
    "editing an unknown feature": (lambda s: s.edit(1, values={"x": 1.0}), UnknownName, "feature 'x'"),
    "a value outside": (lambda s: s.edit(1, values={"load": float("inf")}), KindError, "load.*finite"),
    "an unknown behavior": (lambda s: s.change_design(states=["fly"]), UnknownName, "behavior 'fly'"),
    "an unknown feature": (lambda s: s.change_design(features=["smell"]), UnknownName, "feature 'smell'"),
    "an unknown target": (lambda s: s.change_design(features=["range_of(moon)"]), UnknownName, "'moon'"),
    "a missing argument": (
        lambda s: s.change_design(features=["range_of"]),
        DefinitionError,
        r"range_of\(A\)",
    ),
    "a state twice": (lambda s: s.change_design(states=["left", "left"]), DefinitionError, "'left' twice"),
    "a parameter like a target": (
        lambda s: s.change_design(parameters=["ball"]),
        DefinitionError,
        "'ball'.*rename",
    ),
    "itself": (lambda s: s.change_design(states=["taught"]), UnderstudyError, "taught"),
    "a flag like a feature": (
        lambda s: s.change_design(flags=["seen"]),
        DefinitionError,
        "flag 'seen'.*rename",
    ),
    "no such parameter": (lambda s: s.bind_targets(A="ball"), UnknownName, "parameter 'A'"),
    "too long a reaction": (
        lambda s: s.change_design(options=LearnerOptions(reaction_s=2.0)),
        DefinitionError,
        "reaction_s",
    ),
    "running back": (lambda s: s.run_for(-1), SettingError, "seconds are -1; give a finite number"),
    "running for no number": (lambda s: s.run_for(float("nan")), SettingError, "seconds are nan"),
    "running forever": (lambda s: s.run_for(float("inf")), SettingError, "seconds are inf"),
    "running for a text": (lambda s: s.run_for("1"), SettingError, "seconds are '1'"),  # type: ignore[arg-type]
    "others unknown": (lambda s: s.set_other_agents("fly"), UnknownName, "'fly'"),
}


@pytest.mark.parametrize(("attempt", "error", "said"), REFUSED.values(), ids=REFUSED)
def test_refused(attempt: Callable[[Session], Any], error: type[UnderstudyError], said: str) -> None:
    taught = begin_session()
    before, run = taught.lesson, taught.run_state
    with pytest.raises(error, match=said):
        attempt(taught)
    assert taught.lesson == before
    assert taught.run_state == run
    assert taught.view().undoable == "left → forward"
    play(taught, 1)


BEGINNINGS: list[tuple[dict[str, Any], type[UnderstudyError], str]] = [
    ({"agent": 1}, UnderstudyError, "agent.*1"),
    ({"targets": {"A": "moon"}}, UnknownName, "target 'moon'"),
    ({"targets": {"A": "ball", "B": "goal"}}, UnknownName, "parameter 'B'"),
    ({"targets": {}}, UnboundParameter, "'A'"),
]


@pytest.mark.parametrize(("given", "error", "said"), BEGINNINGS)
def test_a_session_that_cannot_begin(given: dict[str, Any], error: type[UnderstudyError], said: str) -> None:
    lesson = new_lesson(ROBOT, "taught", states=["toward(A)"], features=[], parameters=["A"], live=False)
    with pytest.raises(error, match=said):
        Session(Scripted(), ROBOT, lesson, **{"targets": {"A": "ball"}, **given})


def test_stand_for_unknown_targets() -> None:
    taught = make_session(["toward(A)"], parameters=["A"], targets={"A": "ball"})
    with pytest.raises(UnknownName, match="target 'moon'"):
        taught.bind_targets(A="moon")
    assert taught.view().targets == {"A": "ball"}


@pytest.mark.parametrize("choice", ["states", "features", "flags", "parameters"])
def test_one_text_where_a_list_is_expected(choice: str) -> None:
    chosen: Any = {"states": ["forward"], "features": ["load"], choice: "left"}
    said = rf"lesson 'taught': its {choice} are 'left', a single text; give a list: \['left'\]"
    with pytest.raises(DefinitionError, match=said):
        new_lesson(ROBOT, "taught", **chosen)
    with pytest.raises(DefinitionError, match=said):
        begin_session().change_design(**cast("DesignChange", {choice: "left"}))
