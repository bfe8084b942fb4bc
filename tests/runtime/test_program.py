"""Programs: parameters become targets, and what cannot be run is refused by name."""

from __future__ import annotations

import pytest
from tests.bodies import kit
from tests.make.programs import link_program, make_automaton, make_calling_state

from understudy.errors import (
    DefinitionError,
    RecursionRefused,
    UnboundParameter,
    UnderstudyError,
    UnknownName,
)
from understudy.model.automaton import Automaton
from understudy.model.binding import Binding
from understudy.model.library import Library
from understudy.runtime.link import link


def approach() -> Automaton:
    return make_automaton(
        "approach",
        ["toward(A)"],
        {"start": lambda d: "toward" if d < 50 else None},
        features=["range_of(A)"],
        parameters=["A"],
    )


def test_parameters_are_bound_through_two_levels() -> None:
    chase = make_automaton("chase", [make_calling_state("run", "approach", A="B")], parameters=["B"])
    game = make_automaton(
        "game",
        [make_calling_state("first", "chase", B="ball"), make_calling_state("second", "chase", B="goal")],
    )
    program = link_program(approach(), chase, game)
    assert {str(bound) for bound in program.features} == {"range_of(ball)", "range_of(goal)"}
    assert {str(basic) for basic in program.basics} == {"idle", "toward(ball)", "toward(goal)"}


def test_a_parameter_of_one_name_on_two_levels_is_two_parameters() -> None:
    """A of the child stands for B of the parent, and the parent's own A for something else."""
    parent = make_automaton(
        "parent",
        [make_calling_state("run", "approach", A="B")],
        features=["range_of(A)"],
        parameters=["A", "B"],
    )
    program = link_program(approach(), parent, A="goal", B="ball")
    assert sorted(str(basic) for basic in program.basics) == ["idle", "toward(ball)"]
    assert [str(bound) for bound in program.features] == ["range_of(ball)", "range_of(goal)"]


def test_the_same_instance_is_linked_once() -> None:
    twice = make_automaton(
        "twice",
        [make_calling_state("a", "approach", A="ball"), make_calling_state("b", "approach", A="ball")],
    )
    program = link_program(approach(), twice)
    assert not isinstance(program.root, int)
    assert program.root.children[1] is program.root.children[2]


REFUSED = [  # automata, binding of the root, error, what it names
    ([approach()], {}, UnboundParameter, ["'A'", "approach", "ball", "goal"]),
    ([approach()], {"A": "ball", "B": "goal"}, UnknownName, ["'B'", "approach"]),
    ([approach()], {"A": "moon"}, UnknownName, ["'moon'", "ball"]),
    (
        [approach(), make_automaton("p", [make_calling_state("run", "approach")])],
        {},
        UnboundParameter,
        ["'A'", "approach"],
    ),
    (
        [approach(), make_automaton("p", [make_calling_state("run", "approach", A="C")])],
        {},
        UnknownName,
        ["'C'"],
    ),
    (
        [make_automaton("p", [make_calling_state("run", "nothing")])],
        {},
        UnknownName,
        ["'nothing'", "forward"],
    ),
    (
        [make_automaton("p", [make_calling_state("run", "forward", A="ball")])],
        {},
        UnknownName,
        ["'A'", "forward"],
    ),
    (
        [make_automaton("p", [], parameters=["ball"])],
        {"ball": "goal"},
        DefinitionError,
        ["'ball'", "rename"],
    ),
]


@pytest.mark.parametrize(("automata", "binding", "error", "names"), REFUSED)
def test_refused(
    automata: list[Automaton], binding: dict[str, str], error: type[UnderstudyError], names: list[str]
) -> None:
    with pytest.raises(error) as refusal:
        link_program(*automata, **binding)
    for name in names:
        assert name in str(refusal.value)


def test_recursion_names_the_cycle() -> None:
    chain = (
        make_automaton("a", [make_calling_state("x", "b")]),
        make_automaton("b", [make_calling_state("x", "c")]),
    )
    with pytest.raises(RecursionRefused, match="c -> a -> b -> c") as refusal:
        Library.from_automata(kit, *chain, make_automaton("c", [make_calling_state("x", "a")]))
    assert set(refusal.value.cycle) == {"a", "b", "c"}


def test_recursion_of_one() -> None:
    with pytest.raises(RecursionRefused, match="a -> a"):
        link_program(make_automaton("a", [make_calling_state("x", "a")]))


def test_a_basic_behavior_takes_no_binding_it_has_no_parameter_for() -> None:
    with pytest.raises(UnknownName, match="forward"):
        link(Library(kit), "forward", {"A": "ball"})
    assert link(Library(kit), "toward", {"A": "ball"}).basics[1].binding == Binding(A="ball")
