"""What transition functions say of rows: one next state each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from understudy.learning.csv_table import Row
from understudy.model.automaton import Transition
from understudy.model.tree import STAY


def predict(
    transitions: Mapping[str, Transition], state_names: Sequence[str], rows: Iterable[Row]
) -> list[str]:
    """The next state of each row; a state without a transition function keeps itself."""
    found = []
    for row in rows:
        function = transitions.get(row.state)
        outcome = STAY if function is None else function.decide(row.values)
        found.append(row.state if outcome == STAY else state_names[outcome])
    return found
