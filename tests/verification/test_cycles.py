"""Chatter and cycles: named where they are, and run by the interpreter; not named in their repaired twins."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from tests.verification.automata import (
    AHEAD,
    BACK,
    DISTANCE,
    KIT,
    always,
    arc,
    below,
    find,
    labels,
    make_automaton,
)

from understudy.addons.checks.verification.finding import Finding, FindingKind
from understudy.model.automaton import Automaton, State
from understudy.model.library import Library
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import link

DONE, TIME = 4, 5  # positions among the features
ARRIVED = State("done", flag="done")


def chatter(*automata: Automaton) -> list[Finding]:
    return find(*automata, kind=FindingKind.CHATTER)


OVERLAP = [  # ahead goes back below this distance, back goes ahead from this one on; whether some distance does both
    (0.6, 0.5, True),
    (0.5, 0.5, False),
    (0.5, 0.6, False),
    (100.0, 0.0, True),
]


@pytest.mark.parametrize(("near", "far", "both"), OVERLAP)
def test_a_switch_that_is_undone_in_the_same_cell(near: float, far: float, both: bool) -> None:
    found = chatter(
        make_automaton("go", (AHEAD, BACK), start=always(1), ahead=below(near, 2, 1), back=below(far, 2, 1))
    )
    assert bool(found) == both
    if both:
        ((low, high),) = found[0].cells[0].box[0].parts
        assert (low, high) == (far, near)
        assert not found[0].is_certain  # whether the world gives these distances is not decided


ARCS = [  # ahead turns on the first arc, back returns on the second; the arc that both have
    ((350.0, 10.0), (5.0, 20.0), [(5.0, 10.0)]),
    ((350.0, 10.0), (340.0, 355.0), [(350.0, 355.0)]),
    ((350.0, 10.0), (355.0, 5.0), [(0.0, 5.0), (355.0, 360.0)]),
    ((350.0, 10.0), (10.0, 350.0), []),
]


@pytest.mark.parametrize(("first", "second", "both"), ARCS)
def test_arcs_across_the_seam(
    first: tuple[float, float], second: tuple[float, float], both: list[tuple[float, float]]
) -> None:
    found = chatter(
        make_automaton("go", (AHEAD, BACK), start=always(1), ahead=arc(*first, 2, 1), back=arc(*second, 1, 2))
    )
    assert [part for each in found for part in each.cells[0].box[0].parts] == both


def test_switches_that_undo_each_other_where_a_reading_is_absent() -> None:
    def tree(then: int, otherwise: int) -> object:
        return below(0.5, then, otherwise, absent=1)

    there = make_automaton("go", (AHEAD, BACK), start=always(1), ahead=tree(2, 1), back=tree(1, 2))  # type: ignore[arg-type]
    (found,) = chatter(there)
    assert found.cells[0].box[0].absent


def test_a_cell_in_which_every_reading_chatters_is_certain() -> None:
    (found,) = chatter(make_automaton("go", (AHEAD, BACK), start=always(1), ahead=always(2), back=always(1)))
    assert found.is_certain


def test_the_start_state_is_part_of_cycles() -> None:
    (found,) = chatter(make_automaton("go", (AHEAD,), start=below(1.0, 1, 0), ahead=below(2.0, 0, 1)))
    assert found.states == ("start", "ahead")


ROUND = (AHEAD, BACK, State("wait", "wait"))


def test_a_cycle_of_three_states() -> None:
    cyclic = make_automaton(
        "go", ROUND, start=always(1), ahead=below(1.0, 2, 1), back=below(2.0, 3, 2), wait=below(3.0, 1, 3)
    )
    broken = make_automaton(
        "go", ROUND, start=always(1), ahead=below(1.0, 2, 1), back=below(2.0, 3, 2), wait=below(1.0, 3, 1)
    )
    (found,) = find(cyclic, kind=FindingKind.CYCLE)
    assert found.states == ("ahead", "back", "wait")
    assert found.cells[0].box[0].parts[0][1] == 1.0
    assert not find(broken, kind=FindingKind.CYCLE)


def test_time_in_a_state_is_one_tick_when_it_was_just_entered() -> None:
    """Leaving after a second is a rhythm; leaving at once is chatter."""
    slow = make_automaton(
        "go", (AHEAD, BACK), start=always(1), ahead=below(1.0, 1, 2, feature=TIME), back=always(1)
    )
    quick = make_automaton(
        "go", (AHEAD, BACK), start=always(1), ahead=below(0.05, 1, 2, feature=TIME), back=always(1)
    )
    assert not chatter(slow)
    assert chatter(quick)


GO = make_automaton("go", (AHEAD, ARRIVED), start=always(1), ahead=below(1.0, 2, 1))
FETCH = (State("go", "go"), State("load", "wait"))


def test_a_cycle_through_a_nested_automaton() -> None:
    """Where it is near, go is done at its second tick and begins anew each time."""
    again = make_automaton("fetch", FETCH, start=always(1), go=labels(DONE, 1, 2), load=below(2.0, 1, 2))
    ends = make_automaton("fetch", FETCH, start=always(1), go=labels(DONE, 1, 2), load=below(1.0, 2, 1))
    (found,) = find(GO, again, kind=FindingKind.CYCLE)
    assert found.states == ("go", "load")
    assert found.cells[0].box[0].parts[0][1] == 1.0
    assert "every 3 ticks" in found.sentence
    assert not find(GO, ends, kind=FindingKind.CYCLE)


def test_a_nested_automaton_that_first_has_to_move_makes_no_cycle() -> None:
    """Far away go does not finish while the readings stay as they are."""
    again = make_automaton("fetch", FETCH, start=always(1), go=labels(DONE, 1, 2), load=below(2.0, 2, 1))
    assert not find(GO, again, kind=FindingKind.CYCLE)


def run(*automata: Automaton, row: Sequence[float], ticks: int) -> list[str]:
    """The states of the last of some automata, one a tick, with readings held."""
    program = link(Library.from_automata(KIT, *automata), automata[-1].name)
    values = {str(bound): row[0] if bound == DISTANCE else 0.0 for bound in program.features}
    agent = Interpreter(program)
    states = []
    for tick in range(ticks):
        agent.pulse([values[str(bound)] for bound in program.features], 0.1 * tick)
        states.append(agent.path[0])
    return states


def test_the_interpreter_runs_what_was_found() -> None:
    again = make_automaton("fetch", FETCH, start=always(1), go=labels(DONE, 1, 2), load=below(2.0, 1, 2))
    (found,) = find(GO, again, kind=FindingKind.CYCLE)
    assert run(GO, again, row=found.cells[0].at, ticks=9) == ["go", "go", "load"] * 3
