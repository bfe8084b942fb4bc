"""Programs: parameters become targets, and what cannot be run is refused by name."""

from __future__ import annotations

import pytest
from tests.bodies import kit
from tests.runtime.automata import automaton, calling, linked

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
from understudy.runtime.program import link


def approach() -> Automaton:
    return automaton(
        "approach",
        ["toward(A)"],
        {"start": lambda d: "toward" if d < 50 else None},
        features=["range_of(A)"],
        parameters=["A"],
    )


def test_parameters_are_bound_through_two_levels() -> None:
    chase = automaton("chase", [calling("run", "approach", A="B")], parameters=["B"])
    game = automaton("game", [calling("first", "chase", B="ball"), calling("second", "chase", B="goal")])
    program = linked(approach(), chase, game)
    assert {str(bound) for bound in program.features} == {"range_of(ball)", "range_of(goal)"}
    assert {str(basic) for basic in program.basics} == {"idle", "toward(ball)", "toward(goal)"}


def test_a_parameter_of_one_name_on_two_levels_is_two_parameters() -> None:
    """A of the child stands for B of the parent, and the parent's own A for something else."""
    parent = automaton(
        "parent", [calling("run", "approach", A="B")], features=["range_of(A)"], parameters=["A", "B"]
    )
    program = linked(approach(), parent, A="goal", B="ball")
    assert sorted(str(basic) for basic in program.basics) == ["idle", "toward(ball)"]
    assert [str(bound) for bound in program.features] == ["range_of(ball)", "range_of(goal)"]


def test_the_same_instance_is_linked_once() -> None:
    twice = automaton("twice", [calling("a", "approach", A="ball"), calling("b", "approach", A="ball")])
    program = linked(approach(), twice)
    assert not isinstance(program.root, int)
    assert program.root.children[1] is program.root.children[2]


REFUSED = [  # automata, binding of the root, error, what it names
    ([approach()], {}, UnboundParameter, ["'A'", "approach", "ball", "goal"]),
    ([approach()], {"A": "ball", "B": "goal"}, UnknownName, ["'B'", "approach"]),
    ([approach()], {"A": "moon"}, UnknownName, ["'moon'", "ball"]),
    ([approach(), automaton("p", [calling("run", "approach")])], {}, UnboundParameter, ["'A'", "approach"]),
    ([approach(), automaton("p", [calling("run", "approach", A="C")])], {}, UnknownName, ["'C'"]),
    ([automaton("p", [calling("run", "nothing")])], {}, UnknownName, ["'nothing'", "forward"]),
    ([automaton("p", [calling("run", "forward", A="ball")])], {}, UnknownName, ["'A'", "forward"]),
    (
        [automaton("p", [], parameters=["ball"])],
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
        linked(*automata, **binding)
    for name in names:
        assert name in str(refusal.value)


def test_recursion_names_the_cycle() -> None:
    chain = automaton("a", [calling("x", "b")]), automaton("b", [calling("x", "c")])
    with pytest.raises(RecursionRefused, match="c -> a -> b -> c") as refusal:
        Library.from_automata(kit, *chain, automaton("c", [calling("x", "a")]))
    assert set(refusal.value.cycle) == {"a", "b", "c"}


def test_recursion_of_one() -> None:
    with pytest.raises(RecursionRefused, match="a -> a"):
        linked(automaton("a", [calling("x", "a")]))


def test_a_basic_behavior_takes_no_binding_it_has_no_parameter_for() -> None:
    with pytest.raises(UnknownName, match="forward"):
        link(Library(kit), "forward", {"A": "ball"})
    assert link(Library(kit), "toward", {"A": "ball"}).basics[1].binding == Binding(A="ball")
