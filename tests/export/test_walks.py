"""Walks through readings for conformance rows: what leads to a node, also in very deep trees."""

from __future__ import annotations

from math import nan

from hypothesis import given
from hypothesis import strategies as st
from tests.export.test_export_size import BODY, make_library, split_off

from understudy.addons.export import conformance
from understudy.addons.export.export_automaton import prepare_export
from understudy.addons.export.walks import _list_fitting, find_child
from understudy.model.tree import Node, TestKind

CHILDREN = st.integers(1, 3)
CUTS = st.integers(0, 9).map(float)
NODES = st.one_of(
    st.builds(
        lambda high, yes, no, absent: Node(TestKind.BELOW, 0, high=high, yes=yes, no=no, absent=absent),
        *(CUTS, CHILDREN, CHILDREN, CHILDREN),
    ),
    st.builds(
        lambda low, high, yes, no, absent: Node(TestKind.ARC, 0, low, high, yes, no, absent),
        *(CUTS, CUTS, CHILDREN, CHILDREN, CHILDREN),
    ),
    st.builds(lambda yes, no: Node(TestKind.ABSENT, 0, yes=yes, no=no), CHILDREN, CHILDREN),
)


@given(
    numbers=st.sets(st.integers(0, 9).map(float), max_size=8),
    steps=st.lists(st.tuples(NODES, CHILDREN), max_size=5),
)
def test_fitting_values_are_those_that_lead_there(numbers: set[float], steps: list[tuple[Node, int]]) -> None:
    values = (*sorted(numbers), nan)
    expected = [x for x in values if all(find_child(node, x) == child for node, child in steps)]
    assert repr(_list_fitting(values, steps)) == repr(expected)


def count_rows(depth: int) -> int:
    library = make_library(split_off(depth), sharing=3)
    job = prepare_export(
        library, "a", to="c99", binding={}, body=BODY, fingerprint="deep", single_precision=False
    )
    return len(job.conformance.ticks)


def test_a_very_deep_tree_has_fewer_rows() -> None:
    assert count_rows(40) == 20 * conformance.TICKS + 10 * 3 * 40
    assert 0 <= count_rows(5000) - conformance.MOST_QUESTIONS // 5000 < conformance.TICKS
