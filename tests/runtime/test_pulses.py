"""What a pulse means, as tables to check by hand (ARCHITECTURE section 3)."""

from __future__ import annotations

from math import isnan, nan
from typing import Any

import pytest
from tests.bodies import kit
from tests.make.programs import Rule, link_program, make_automaton, make_calling_state, name_running

from understudy.model.automaton import Automaton
from understudy.model.library import Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.runtime.decision_trace import DecisionTrace
from understudy.runtime.engine import _pulse_kernels
from understudy.runtime.interpreter import Interpreter, RunningAutomaton, measure_elapsed
from understudy.runtime.link import link

NEAR = 1.0


def go_to() -> Automaton:
    """Forward until near, then done."""
    to = lambda load: "done" if load < NEAR else "forward"  # noqa: E731
    return make_automaton(
        "go", ["forward"], {"start": to, "forward": to}, flags=["done", "failed"], features=["load"]
    )


def trip() -> Automaton:
    """Go; where that is done, turn left."""
    return make_automaton(
        "trip",
        [make_calling_state("going", "go"), "left"],
        {"start": lambda done: "going", "going": lambda done: "left" if done else "going"},
        features=["done"],
    )


def play(
    interpreter: Interpreter, rows: list[tuple[float, ...]], tick_s: float = 0.1
) -> list[tuple[str, str]]:
    """State path and basic behavior after each tick."""
    played = []
    for tick, row in enumerate(rows):
        index = interpreter.pulse(row, tick * tick_s)
        played.append(("/".join(interpreter.path), name_running(interpreter.program, index)))
    return played


PULSES = [  # distance, state before, state after, flag up
    (5.0, "start", "forward", None),  # the start state is left at once
    (0.3, "start", "done", "done"),
    (5.0, "forward", "forward", None),
    (0.3, "forward", "done", "done"),
    (5.0, "done", "done", "done"),  # a flag state is terminal
    (0.3, "done", "done", "done"),
    (nan, "forward", "forward", None),
]


@pytest.mark.parametrize(("distance", "before", "after", "flag"), PULSES)
def test_pulse(distance: float, before: str, after: str, flag: str | None) -> None:
    interpreter = Interpreter(link_program(go_to()))
    machine = interpreter.root
    assert isinstance(machine, RunningAutomaton)
    if before != "start":
        machine.switch(machine.automaton.index(before), 0.0)
    basic = interpreter.pulse([distance], 0.1)
    assert (machine.state_name, machine.flag) == (after, flag)
    assert name_running(interpreter.program, basic) == ("forward" if after == "forward" else "idle")


def test_a_parent_sees_a_flag_one_tick_after_it_is_raised() -> None:
    interpreter = Interpreter(link_program(go_to(), trip()))
    assert play(interpreter, [(5.0,), (0.3,), (0.3,), (5.0,)]) == [
        ("going/forward", "forward"),  # the parent left start, the child left its start, in one tick
        ("going/done", "idle"),  # raised here
        ("left", "left"),  # seen here
        ("left", "left"),
    ]


def test_flags_pass_one_level_per_tick() -> None:
    middle = make_automaton(
        "middle",
        [make_calling_state("trip", "go")],
        {"start": lambda done: "trip", "trip": lambda done: "done" if done else None},
        flags=["done"],
        features=["done"],
    )
    top = make_automaton(
        "top",
        [make_calling_state("down", "middle"), "left"],
        {"start": lambda done: "down", "down": lambda done: "left" if done else None},
        features=["done"],
    )
    interpreter = Interpreter(link_program(go_to(), middle, top))
    paths = [path for path, _ in play(interpreter, [(5.0,), (0.3,), (0.3,), (0.3,)])]
    assert paths == ["down/trip/forward", "down/trip/done", "down/done", "left"]


def test_a_restarted_automaton_has_its_flag_down_in_the_same_tick() -> None:
    """go -> left -> go: going again begins with the flag down, so that it runs rather than leaves at once."""
    again = make_automaton(
        "again",
        [make_calling_state("going", "go"), "left"],
        {
            "start": lambda done: "going",
            "going": lambda done: "left" if done else "going",
            "left": lambda done: "going",
        },
        features=["done"],
    )
    interpreter = Interpreter(link_program(go_to(), again))
    paths = [path for path, _ in play(interpreter, [(0.3,), (0.3,), (5.0,), (5.0,)])]
    assert paths == ["going/done", "left", "going/forward", "going/forward"]


def test_states_that_share_a_behavior_restart_it() -> None:
    """Two states run the same automaton with the same binding: the second starts it afresh."""
    both = make_automaton(
        "both",
        [make_calling_state("first", "go"), make_calling_state("second", "go")],
        {"start": lambda done: "first", "first": lambda done: "second" if done else None},
        features=["done"],
    )
    interpreter = Interpreter(link_program(go_to(), both))
    paths = [path for path, _ in play(interpreter, [(0.3,), (5.0,), (0.3,)])]
    assert paths == ["first/done", "second/forward", "second/done"]


FLAGS = [  # what the child sees, what the parent then does
    (0.0, "left"),  # done
    (2.0, "right"),  # failed
    (1.0, "going/start"),  # neither
]


@pytest.mark.parametrize(("load", "after"), FLAGS)
def test_several_flags(load: float, after: str) -> None:
    child = make_automaton(
        "child",
        [],
        {"start": lambda load: {0.0: "done", 2.0: "failed"}.get(load)},
        flags=["done", "failed"],
        features=["load"],
    )
    parent = make_automaton(
        "parent",
        [make_calling_state("going", "child"), "left", "right"],
        {
            "start": lambda done, failed: "going",
            "going": lambda done, failed: "left" if done else "right" if failed else None,
        },
        features=["done", "failed"],
    )
    interpreter = Interpreter(link_program(child, parent))
    assert play(interpreter, [(load,), (load,)])[-1][0] == after


def test_a_basic_behavior_raises_no_flags() -> None:
    lone = make_automaton(
        "lone",
        ["forward", "left"],
        {"start": lambda done: "forward", "forward": lambda done: "left" if done else None},
        features=["done"],
    )
    assert play(Interpreter(link_program(lone)), [(), ()])[-1][0] == "forward"


def test_a_state_without_a_transition_function_keeps_itself() -> None:
    assert (
        play(Interpreter(link_program(make_automaton("idle", ["forward"]))), [(), ()])
        == [("start", "idle")] * 2
    )


def test_a_basic_behavior_as_root() -> None:
    interpreter = Interpreter(link(Library(kit), "forward"))
    assert play(interpreter, [(), ()]) == [("", "forward")] * 2
    assert interpreter.snapshot(0.0) == ()
    interpreter.restore((), now=1.0)


def test_stateless() -> None:
    to = lambda load: "done" if load < 1 else "forward" if load < 2 else "left"  # noqa: E731
    everywhere = make_automaton(
        "everywhere",
        ["forward", "left"],
        dict.fromkeys(["start", "forward", "left"], to),
        flags=["done"],
        features=["load"],
        stateless=True,
    )
    paths = [path for path, _ in play(Interpreter(link_program(everywhere)), [(3,), (1,), (3,), (0,), (3,)])]
    assert paths == ["left", "forward", "left", "done", "done"]


# Counters, timers, time in state


def own(
    states: list[str], features: list[str], order: list[str]
) -> tuple[Interpreter, list[tuple[Any, ...]]]:
    """An automaton that goes through its states in order, one per tick, and what its features read then."""
    read: list[tuple[Any, ...]] = []
    steps = ["start", *order]
    rules = {}
    for before in dict.fromkeys(steps):

        def rule(*values: float) -> str | None:
            at = len(read)
            read.append(values)
            return steps[at + 1] if at + 1 < len(steps) else None

        rules[before] = rule
    return Interpreter(link_program(make_automaton("own", states, rules, features=features))), read


def test_counters() -> None:
    order = ["lap", "forward", "lap", "three_laps", "lap", "no_laps"]
    interpreter, read = own(["lap", "forward", "three_laps", "no_laps"], ["laps"], order)
    play(interpreter, [()] * 7)
    assert [values[0] for values in read] == [0, 1, 1, 2, 3, 4, 0]


def test_a_behavior_changes_a_counter_once_when_started() -> None:
    interpreter, read = own(["lap"], ["laps"], ["lap"])
    play(interpreter, [()] * 4)
    assert [values[0] for values in read] == [0, 1, 1, 1]


def test_timers() -> None:
    interpreter, read = own(["click", "forward", "unclick"], ["watch"], ["click", "forward", "unclick"])
    play(interpreter, [()] * 4)
    assert isnan(read[0][0])  # never set: absent
    assert [values[0] for values in read[1:3]] == [0.1, 0.2]  # set when click started, at tick 0
    assert isnan(read[3][0])


def test_counters_and_timers_are_cleared_when_the_automaton_starts() -> None:
    interpreter, read = own(["lap", "click"], ["laps", "watch"], ["lap", "click"])
    play(interpreter, [()] * 3)
    interpreter.start(0.3)
    interpreter.pulse([], 0.3)
    assert read[-1][0] == 0
    assert isnan(read[-1][1])


def test_counters_belong_to_the_automaton_that_holds_the_state() -> None:
    child = make_automaton("child", ["lap"], {"start": lambda: "lap"})
    parent = make_automaton(
        "parent", [make_calling_state("down", "child")], {"start": lambda laps: "down"}, features=["laps"]
    )
    interpreter = Interpreter(link_program(child, parent))
    play(interpreter, [(), ()])
    assert [level.counters for level in interpreter.snapshot(0.2)] == [{}, {"laps": 1.0}]


def test_time_in_state() -> None:
    interpreter, read = own(["forward", "left"], ["time_in_state"], ["forward", "forward", "forward", "left"])
    play(interpreter, [()] * 6)
    assert [values[0] for values in read] == [0.0, 0.1, 0.2, 0.3, 0.1, 0.2]


def test_equally_many_ticks_read_the_same_whenever_they_began() -> None:
    """0.7 - 0.4 and 0.3 - 0.0 differ as floats; a cut at 0.3 s must not."""
    late = make_automaton(
        "late",
        ["forward", "left"],
        {"start": lambda s: "forward", "forward": lambda s: "left" if s >= 0.3 else None},
        features=["time_in_state"],
    )
    for begin in range(50):
        interpreter = Interpreter(link_program(late), now=begin * 0.1)
        ticks = 0
        while interpreter.path != ("left",):
            interpreter.pulse([], (begin + ticks) * 0.1)
            ticks += 1
        assert ticks == 4, begin


# Keeping and going back


def test_snapshot_and_restore() -> None:
    child = make_automaton("child", ["lap", "click"], {"start": lambda: "lap", "lap": lambda: "click"})
    top = make_automaton("top", [make_calling_state("down", "child")], {"start": lambda: "down"})
    program = link_program(child, top)
    interpreter = Interpreter(program)
    play(interpreter, [()] * 4)
    kept = interpreter.snapshot(0.4)
    assert [(level.state, level.time_in_state) for level in kept] == [("down", 0.4), ("click", 0.3)]
    assert kept[1].counters == {"laps": 1.0}
    assert kept[1].timers == {"watch": 0.3}
    other = Interpreter(program, now=100.0)
    other.restore(kept, now=100.0)  # at another time of the clock: seconds ago stay seconds ago
    assert other.snapshot(100.0) == kept
    assert other.path == ("down", "click")


def test_restore_goes_as_far_as_states_still_exist() -> None:
    child = make_automaton("child", ["lap"], {"start": lambda: "lap"})
    top = make_automaton("top", [make_calling_state("down", "child")], {"start": lambda: "down"})
    interpreter = Interpreter(link_program(child, top))
    play(interpreter, [(), ()])
    kept = interpreter.snapshot(0.2)
    bare = Interpreter(link_program(make_automaton("child", ["forward"]), top))
    bare.restore(kept, now=0.2)
    assert bare.path == ("down", "start")  # lap is gone: the child starts afresh
    gone = Interpreter(link_program(child, make_automaton("top", ["forward"])))
    gone.restore(kept, now=0.2)
    assert gone.path == ("start",)


def test_a_restored_flag_is_that_of_the_state_as_it_is_now() -> None:
    interpreter = Interpreter(link_program(go_to()))
    play(interpreter, [(0.3,)])
    kept = interpreter.snapshot(0.1)
    unflagged = Interpreter(link_program(make_automaton("go", ["done=forward"])))
    unflagged.restore(kept, now=0.1)
    assert isinstance(unflagged.root, RunningAutomaton)
    assert unflagged.path == ("done",)
    assert unflagged.root.flag is None


# Traces


def test_a_trace_says_what_switched_and_why() -> None:
    tree = Tree((Node(TestKind.BELOW, 0, high=2.0, yes=1, no=2), make_leaf(1), make_leaf(2)))
    go = make_automaton("go", ["forward", "left"], features=["load"])
    taught = Automaton("go", go.states, go.features, transitions=dict.fromkeys(("start", "forward"), tree))
    interpreter = Interpreter(link_program(taught))
    trace = DecisionTrace(interpreter)
    play(interpreter, [(1.0,), (1.0,), (3.0,)])
    told = [
        (round(s.time_s, 9), s.before, s.after, s.values, [step.side for step in s.steps])
        for s in trace.switches
    ]
    assert told == [(0.0, "start", "forward", (1.0,), ["yes"]), (0.2, "forward", "left", (3.0,), ["no"])]
    trace.close()
    play(interpreter, [(1.0,)])
    assert len(trace.switches) == 2


def test_a_trace_says_where_nothing_was_ever_shown() -> None:
    """A split reached with absence that was never shown there answers stay, and the trace says so, once."""
    tree = Tree((Node(TestKind.BELOW, 0, high=2.0, yes=1, no=2), make_leaf(1), make_leaf(2)))
    go = make_automaton("go", ["forward", "left"], features=["load"])
    taught = Automaton("go", go.states, go.features, transitions=dict.fromkeys(("start", "forward"), tree))
    interpreter = Interpreter(link_program(taught))
    trace = DecisionTrace(interpreter)
    play(interpreter, [(1.0,), (nan,), (nan,), (1.0,), (3.0,)])
    assert [s.after for s in trace.switches] == ["forward", "left"]
    assert [(s.time_s, s.automaton, s.before, s.after) for s in trace.unshown] == [
        (0.1, "go", "forward", "forward")
    ]
    assert trace.unshown[0].steps[-1].side == "absent"
    assert interpreter.path == ("left",)


def test_a_leaf_that_answers_stay_was_shown() -> None:
    go = make_automaton("go", ["forward"], {"start": lambda: None})
    assert isinstance(go.transitions["start"], Rule)
    interpreter = Interpreter(link_program(go))
    trace = DecisionTrace(interpreter)
    play(interpreter, [(), ()])
    assert not trace.switches
    assert not trace.unshown


@pytest.mark.parametrize("began", [0.0, 4_000_000.0, 4_194_304.0, 1.7e9, 4.2e9])
@pytest.mark.parametrize("tick_s", [0.1, 0.05])
def test_equally_many_ticks_read_the_same_on_any_clock(began: float, tick_s: float) -> None:
    """A robot's clock may count from 1970, where neighboring floats are 2.4e-7 s apart."""
    times = [began + tick * tick_s for tick in range(200)]
    for count in (1, 3, 17):
        read = {measure_elapsed(now, since) for since, now in zip(times, times[count:], strict=False)}
        assert read == {round(count * tick_s, 9)}
        for since, now in zip(times, times[count:], strict=False):
            assert _pulse_kernels.compute_elapsed(now, since) == measure_elapsed(now, since)
