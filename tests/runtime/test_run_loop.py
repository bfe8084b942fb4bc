"""Runs: from readings to columns of commands, for agents that may run different programs."""

from __future__ import annotations

from math import nan

import numpy as np
import pytest
from tests.bodies import RANGE, Scripted, kit, opposite, range_of
from tests.make.programs import link_program, make_automaton

from understudy.errors import DefinitionError, SettingError, UnknownName
from understudy.model.behaviors import Behavior, Command, behavior
from understudy.model.binding import Binding, Target
from understudy.model.features import BoundFeature, Feature, ReadingsView
from understudy.model.library import Kit, Library
from understudy.model.value_kinds import Column, Continuous, Toroidal
from understudy.runtime.feature_columns import FeatureColumns
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import IDLE_PROGRAM, link
from understudy.runtime.run_loop import Run

COMMANDS = [  # behavior, its binding, drive, turn
    ("forward", {}, 1.0, 0.5),  # turn is left out: it rests at 0.5
    ("left", {}, 0.0, 1.0),
    ("click", {}, 0.0, 0.5),  # commands nothing
    ("toward", {"A": "goal"}, 0.0, 1.0),  # a function: the bearing of the goal
]


@pytest.mark.parametrize(("name", "binding", "drive", "turn"), COMMANDS)
def test_commands(name: str, binding: dict[str, str], drive: float, turn: float) -> None:
    body = Scripted()
    Run.from_program(body, link(Library(kit), name, binding)).tick()
    assert body.commanded == [{"drive": [drive], "turn": [turn]}]


def test_idling_is_every_channel_at_rest() -> None:
    body = Scripted(2)
    Run.from_program(body, IDLE_PROGRAM).tick()
    assert body.commanded == [{"drive": [0.0, 0.0], "turn": [0.5, 0.5]}]


def test_agents_decide_for_themselves() -> None:
    """Agent i senses 100 + i - tick: each leaves at its own time."""
    go = make_automaton(
        "go",
        ["forward", "left"],
        {"start": lambda d: "forward", "forward": lambda d: "left" if d < 99 else None},
        features=["range_of(ball)"],
    )
    body = Scripted(3)
    run = Run.from_program(body, link_program(go))
    for _ in range(5):
        run.tick()
    assert [commands["drive"] for commands in body.commanded] == [
        [1, 1, 1],
        [1, 1, 1],
        [0, 1, 1],
        [0, 0, 1],
        [0, 0, 0],
    ]


def test_different_programs_per_agent() -> None:
    body, library = Scripted(3), Library(kit)
    programs = [link(library, "toward", {"A": "goal"}), IDLE_PROGRAM, link(library, "forward")]
    Run(body, [Interpreter(program) for program in programs]).tick()
    assert body.commanded == [{"drive": [0.0, 0.0, 1.0], "turn": [1.0, 0.5, 0.5]}]


def test_one_interpreter_per_agent() -> None:
    with pytest.raises(SettingError, match="1 for 2 agents"):
        Run(Scripted(2), [Interpreter(IDLE_PROGRAM)])


def test_a_function_feature_is_wrapped_onto_its_circle() -> None:
    body = Scripted()
    sensing = FeatureColumns([BoundFeature(opposite, Binding(A="ball"))], body)
    assert set(sensing.keys) >= {("bearing", "ball")}
    assert ("bearing", "goal") not in sensing.keys
    percept = body.sense(sensing.keys)
    assert sensing.columns(percept)[0] == pytest.approx((6.0 + 3.0) % Toroidal().period)


def test_only_readings_that_are_used_are_asked_for() -> None:
    go = make_automaton("go", ["forward"], features=["range_of(ball)", "done"])
    assert Run.from_program(Scripted(), link_program(go)).keys == (("range", "ball"),)


def test_absence_of_one_agent_is_no_error_for_another() -> None:
    """A function behavior computes for all rows at once, but only those that run it must be finite."""
    script = {**RANGE, ("bearing", "ball"): lambda tick: nan}
    library = Library(kit)
    body = Scripted(2, script)
    toward = [link(library, "toward", {"A": "ball"}), link(library, "toward", {"A": "goal"})]

    go = make_automaton(
        "go",
        ["forward", "toward(ball)"],
        {"start": lambda d: "forward" if d > 100 else "toward"},
        features=["range_of(goal)"],
    )
    Run.from_program(body, link_program(go)).tick()
    with pytest.raises(DefinitionError, match="toward"):
        Run(Scripted(2, script), [Interpreter(program) for program in toward]).tick()


def near_only(_: ReadingsView, A: ReadingsView) -> dict[str, Column]:
    """Drive where A is within 100 m, and say nothing that makes sense elsewhere."""
    return {"drive": np.where(A.range <= 100, 1.0, nan)}


def test_a_function_behavior_must_be_finite_for_the_agents_that_run_it() -> None:
    own = Kit.from_parts(
        range_of, behavior(near_only), Behavior("forward", Command(drive=0.25)), Target("ball")
    )
    library = Library(own)
    go = make_automaton(
        "go",
        ["forward", "near_only(ball)"],
        {"start": lambda d: "near_only" if d <= 100 else "forward"},
        features=["range_of(ball)"],
        library=library,
    )
    body = Scripted(2)  # agent 0 is at 100 m, agent 1 at 101 m
    Run.from_program(body, link(library.from_automata(own, go), "go")).tick()
    assert body.commanded[0]["drive"] == [1.0, 0.25]
    with pytest.raises(DefinitionError, match="near_only"):
        Run.from_program(Scripted(2), link(library, "near_only", {"A": "ball"})).tick()


def jump(_: ReadingsView) -> dict[str, Column]:
    return {"jump": np.ones(1)}


def test_what_the_body_does_not_know_is_named() -> None:
    body = Scripted()
    sky = Target("sky")
    cases = [
        (Kit.from_parts(Behavior("fly", Command(rise=1.0))), "fly", {}, "channel 'rise'"),
        (Kit.from_parts(behavior(jump)), "jump", {}, "channel 'jump'"),
        (Kit.from_parts(kit.behaviors["toward"], sky), "toward", {"A": "sky"}, "target 'sky'"),
    ]
    for parts, name, binding, named in cases:
        with pytest.raises(UnknownName, match=named):
            Run.from_program(body, link(Library(parts), name, binding)).tick()


FEATURES = [
    (Feature("smell", Continuous(), "smell"), Binding(), UnknownName, "reading 'smell'"),
    (Feature("seen", Continuous(), "seen"), Binding(), DefinitionError, "continuous"),
    (range_of, Binding(A="sky"), UnknownName, "target 'sky'"),
]


@pytest.mark.parametrize(("feature", "binding", "error", "named"), FEATURES)
def test_features_the_body_cannot_sense(
    feature: Feature, binding: Binding, error: type[Exception], named: str
) -> None:
    with pytest.raises(error, match=named):
        FeatureColumns([BoundFeature(feature, binding)], Scripted())
