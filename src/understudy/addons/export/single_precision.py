"""Single precision: the same trees with cuts that are 32-bit floats, so that no recorded example changes sides.

For readings that are 32-bit floats themselves, x < cut and x < (the cut rounded up) are the same question, so that
rounding up changes nothing. A recorded example is a double, however, and rounding it may take it across the cut.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, nan
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from understudy.addons.export.expressions import Expression, Number, ReadingValue, translate_function
from understudy.errors import DefinitionError
from understudy.learning.explain import find_rows_by_node
from understudy.learning.training_set import group_examples_by_state
from understudy.model.automaton import Automaton
from understudy.model.behaviors import Behavior
from understudy.model.features import CounterFeature, Feature, ReadingsView
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import Node, TestKind, Tree
from understudy.model.value_kinds import Categorical
from understudy.runtime.link import Program

MOST_COUNT = 2**31
"""One more than the largest number that a counter of 32 bits holds."""


@dataclass(frozen=True, slots=True)
class RoundedCut:
    """A cut that single precision would decide otherwise, and the cut that is exported instead.

    `margin` is the distance from the former cut to the nearest recorded example, NaN without one. `is_separating` is
    False if no 32-bit cut has all recorded examples on their sides.
    """

    automaton: str
    state: str
    feature: str
    cut: float
    exported: float
    margin: float
    is_separating: bool = True


Values: TypeAlias = NDArray[np.float64]
Part = TypeVar("Part", Feature, Behavior)
Single: TypeAlias = NDArray[Any]

OPERATIONS: Mapping[str, Callable[..., Single]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "neg": np.negative,
    "abs": np.abs,
    "isnan": np.isnan,
    "sqrt": np.sqrt,
    "minimum": np.minimum,
    "maximum": np.maximum,
    "where": np.where,
}


def round_to_single(value: float) -> float:
    """Round a number to the nearest 32-bit float, infinite if it is too large for one."""
    with np.errstate(over="ignore"):
        return float(np.float32(value))


def step_single(value: float, toward: float) -> float:
    """Return the 32-bit float next to a 32-bit float."""
    with np.errstate(over="ignore", under="ignore"):
        return float(np.nextafter(np.float32(value), np.float32(toward)))


def round_up_to_single(value: float) -> float:
    """Return the smallest 32-bit float that is not less than a number."""
    rounded = round_to_single(value)
    return rounded if rounded >= value else step_single(rounded, inf)


def round_cut(cut: float, values: Values) -> tuple[float, bool]:
    """Return the 32-bit cut for a cut between recorded values, and whether it separates the rounded values as before.

    Parameters
    ----------
    cut
        The cut: values below it are on one side.
    values
        The recorded values of the feature, NaN where absent.

    Returns
    -------
    tuple[float, bool]
        The cut rounded up, or moved as little as needed to keep all values on their sides.
    """
    rounded = round_up_to_single(cut)
    with np.errstate(over="ignore"):
        single = values.astype(np.float32).astype(np.float64)
    least = step_single(float(np.max(single[values < cut], initial=-inf)), inf)
    most = float(np.min(single[values >= cut], initial=inf))
    if least > most:
        return rounded, False
    return min(max(rounded, least), most), True


def round_library(library: Library, names: Sequence[str]) -> tuple[Library, tuple[RoundedCut, ...]]:
    """Round the cuts of some automata of a library.

    Returned are the library with the rounded automata, and the cuts that moved further than rounding up, or could not
    be moved far enough. DefinitionError is raised if a behavior changes a counter by a number that is not whole or too
    large, or commands one that is too large for a 32-bit float.
    """
    cuts: list[RoundedCut] = []
    for name in names:
        taught = library.taught[name]
        for state in taught.automaton.states:
            behavior = library.kit.behaviors.get(state.behavior or "")
            for change in behavior.changes if behavior else ():
                if change.of == "counter" and not (
                    change.value == int(change.value) and abs(change.value) < MOST_COUNT
                ):
                    raise DefinitionError(
                        what=f"behavior {state.behavior!r}",
                        problem=f"it changes counter {change.name!r} by or to {change.value:g}, which single "
                        "precision cannot add up exactly",
                        remedy="use whole numbers below 2147483648, or export with double precision",
                    )
            for channel, value in behavior.command.items() if behavior else ():
                if not isfinite(round_to_single(value)):
                    raise DefinitionError(
                        what=f"behavior {state.behavior!r}",
                        problem=f"it commands {value:g} to {channel!r}, which single precision does not have",
                        remedy="use a smaller number, or export with double precision",
                    )
        automaton = _round_automaton(taught, name, cuts)
        library = library.with_automaton(TrainedAutomaton(automaton, taught.lesson))
    return library, tuple(cuts)


def _round_automaton(taught: TrainedAutomaton, called: str, cuts: list[RoundedCut]) -> Automaton:
    automaton = taught.automaton
    groups = {} if taught.lesson is None else group_examples_by_state(taught.lesson)
    transitions = dict(automaton.transitions)
    done: dict[int, Tree] = {}
    for state, tree in automaton.transitions.items():
        if not isinstance(tree, Tree):
            continue
        if id(tree) not in done:
            vectors = [example.values for example in groups.get(state, ())]
            values = np.array(vectors, np.float64).reshape(len(vectors), len(automaton.features))
            done[id(tree)] = _round_tree(tree, values, automaton, (called, state), cuts)
        transitions[state] = done[id(tree)]
    return replace(automaton, transitions=transitions)


def _round_tree(
    tree: Tree, values: Values, automaton: Automaton, where: tuple[str, str], rounded: list[RoundedCut]
) -> Tree:
    rows = find_rows_by_node(tree, values)
    nodes: list[Node] = []
    for node, here in zip(tree.nodes, rows, strict=True):
        if node.test not in (TestKind.BELOW, TestKind.ARC) or not _is_rounded(automaton, node.feature):
            nodes.append(node)
            continue
        column = values[here, node.feature]
        cuts = []
        for cut in (node.low, node.high):
            exported, separates = round_cut(cut, column) if isfinite(cut) else (cut, True)
            cuts.append(exported)
            if isfinite(cut) and not (separates and exported == round_up_to_single(cut)):
                distances = np.abs(column - cut)
                margin = float(np.nanmin(distances)) if np.isfinite(distances).any() else nan
                feature = str(automaton.features[node.feature])
                rounded.append(RoundedCut(*where, feature, cut, exported, margin, separates))
        low, high = cuts
        if node.test == TestKind.ARC and node.low > node.high and low <= high:
            nodes.append(
                node._replace(test=TestKind.BELOW, low=nan, high=inf)
            )  # no float lies outside the arc
            continue
        if node.low <= node.high and low > high:
            high = low  # no float lies on the arc, which must not come to cross the seam
        nodes.append(node._replace(low=low, high=high))
    return Tree(tuple(nodes))


def _is_rounded(automaton: Automaton, feature: int) -> bool:
    """Return whether the values of a feature are 32-bit floats; times are milliseconds, counters whole numbers."""
    bound = automaton.features[feature]
    if isinstance(bound.feature, CounterFeature) or isinstance(bound.kind, Categorical):
        return False
    return isinstance(bound.feature, Feature)


def compute_in_single(program: Program) -> Program:
    """Return a program whose translated functions compute in 32-bit floats, as exported code of single precision does.

    NumPy computes with a number of its own, such as `np.float64(0.1)` or `np.sqrt(2.0)`, in double precision even
    beside readings that are 32-bit floats, so that the Python function itself is no reference for single precision.
    """
    features = tuple(
        replace(bound, feature=_compute_part(bound.feature)) if isinstance(bound.feature, Feature) else bound
        for bound in program.features
    )
    basics = tuple(replace(ground, behavior=_compute_part(ground.behavior)) for ground in program.basics)
    return Program(program.root, features, basics)


def _compute_part(part: Part) -> Part:
    if part.function is None:
        return part
    return replace(part, function=_compute_function(part.function, part.parameters))


def _compute_function(function: Callable[..., Any], parameters: Sequence[str]) -> Callable[..., Any]:
    """Return a function that computes in 32-bit floats; the function itself if it cannot be translated."""
    translated = translate_function(function, parameters)
    if translated.problem:
        return function

    def computed(*views: ReadingsView) -> Any:
        by_owner = dict(zip((None, *parameters), views, strict=True))
        results = {name: _evaluate(each, by_owner) for name, each in translated.results.items()}
        return results[""] if set(results) == {""} else results

    return computed


def _evaluate(expression: Expression, views: Mapping[str | None, ReadingsView]) -> Single:
    if isinstance(expression, Number):
        return np.array([expression.value], np.float32)
    if isinstance(expression, ReadingValue):
        value: Single = getattr(views[expression.parameter], expression.reading)
        return value.astype(np.float32)
    return OPERATIONS[expression.name](*(_evaluate(each, views) for each in expression.operands))
