"""Following one agent of a run, by hand: what each level was asked at each tick, and how it got to where it is."""

from __future__ import annotations

import pytest
from tests.bodies import Scripted, kit
from tests.make.programs import make_automaton

from understudy.judging.tracing import ActiveAutomaton, TracedRun, TransitionQuery
from understudy.model.library import Library
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import link

# The ball is 100 m away at first, and a meter nearer each tick. `go` laps while it is beyond 97 m, and only begins
# then; `taught` goes, drives forward at 98 m, and goes again at 96 m.
GO = make_automaton(
    "go",
    ["lap"],
    {"start": lambda d: "lap" if d > 97 else None},
    features=["range_of(ball)"],
)
LIBRARY = Library.from_automata(
    kit,
    GO,
    make_automaton(
        "taught",
        ["go", "forward"],
        {
            "start": lambda d: "go",
            "go": lambda d: "forward" if d == 98 else None,
            "forward": lambda d: "go" if d == 96 else None,
        },
        features=["range_of(ball)"],
        library=Library.from_automata(kit, GO),
    ),
)


def after(ticks: int, *, agents: int = 1, follow: int = 0) -> tuple[TracedRun, tuple[ActiveAutomaton, ...]]:
    body = Scripted(agents)
    program = link(LIBRARY, "taught")
    run = TracedRun(body, [Interpreter(program) for _ in range(agents)])
    run.follow(follow)
    for _ in range(ticks):
        run.tick()
    return run, run.list_active(follow)


def test_both_levels_switch_in_the_first_tick() -> None:
    run, (taught, go) = after(1)
    assert [level.machine.state_name for level in (taught, go)] == ["go", "lap"]
    assert taught.query == taught.entry == TransitionQuery(0.0, 0, 1, (100.0,))
    assert go.query == go.entry == TransitionQuery(0.0, 0, 1, (100.0,))
    assert run.last_switches == {}, "there was no switch before it"


def test_a_tick_later_nothing_switches() -> None:
    run, (taught, go) = after(2)
    assert taught.query == TransitionQuery(0.1, 1, 1, (99.0,))
    assert taught.entry == TransitionQuery(0.0, 0, 1, (100.0,))
    assert go.query is None, "its state has no transition function"
    machine, query = run.last_switches[0]
    assert (machine.automaton.name, query.time_s) == ("taught", 0.0), "what the switch of go followed from"


def test_what_was_started_again_has_no_way_there_yet() -> None:
    """At 96 m `go` begins anew, and stays in its start state: that it had once left for lap is forgotten."""
    run, (taught, go) = after(6)
    assert (taught.machine.state_name, go.machine.state_name) == ("go", "start")
    assert taught.entry == TransitionQuery(0.4, 2, 1, (96.0,))
    assert (go.entry, go.query) == (None, TransitionQuery(0.5, 0, 0, (95.0,)))
    assert go.entered_s == 0.4
    assert run.last_switches[0][1].time_s == 0.4


def test_one_of_several() -> None:
    """The second robot is a meter farther: what it is asked is its own."""
    _, (taught, _) = after(2, agents=2, follow=1)
    assert taught.query == TransitionQuery(0.1, 1, 1, (100.0,))


def test_the_last_switch_of_each_of_several() -> None:
    """The first robot drives forward at 98 m in the third tick; the second is at 99 m then, and follows a tick later.

    After four ticks, only the first one's is before this tick; after five, both are, each with its own time.
    """
    found = []
    body = Scripted(2)
    run = TracedRun(body, [Interpreter(link(LIBRARY, "taught")) for _ in range(2)])
    run.follow(0)
    run.follow(1)
    for _ in range(5):
        run.tick()
        found.append({agent: switch[1].time_s for agent, switch in run.last_switches.items()})
    assert found == [
        {},
        {0: 0.0, 1: 0.0},
        {0: 0.0, 1: 0.0},
        {0: 0.2, 1: 0.0},
        {0: 0.2, 1: pytest.approx(0.3)},
    ]
