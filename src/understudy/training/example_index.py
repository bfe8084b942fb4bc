"""Index of the examples of a lesson, updated at each press from the new examples only."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import TypeAlias

from understudy.model.lesson import Example

ExampleKey: TypeAlias = tuple[str | float | None, ...]


class ExampleIndex:
    """The keys of a lesson's examples, the watched ones by key, and the largest number."""

    def __init__(self) -> None:
        self.keys: set[ExampleKey] = set()
        self.largest = 0
        self._watched: dict[ExampleKey, list[Example]] = {}
        self._examples: tuple[Example, ...] = ()

    def update(self, examples: tuple[Example, ...]) -> None:
        """Index these examples; only the new ones are read if they follow the examples of the last call."""
        if examples is self._examples:
            return
        count = len(self._examples)
        if examples[:count] != self._examples:
            self.keys, self.largest, self._watched, count = set(), 0, {}, 0
        for example in examples[count:]:
            key = make_example_key(example)
            self.keys.add(key)
            if not example.is_from_press:
                self._watched.setdefault(key, []).append(example)
            self.largest = max(self.largest, example.number)
        self._examples = examples

    def replace_watched(self, pressed: Sequence[Example]) -> tuple[Example, ...]:
        """Return the examples with these, which presses made, in place of the watched ones with the same keys."""
        same = (self._watched.pop(key, ()) for key in map(make_example_key, pressed))
        gone = {id(each) for each in chain.from_iterable(same)}
        if gone:
            self._examples = tuple(each for each in self._examples if id(each) not in gone)
        self.update((*self._examples, *pressed))
        return self._examples


def make_example_key(example: Example) -> ExampleKey:
    """Make a key of an example's state and values, in which absent readings are equal."""
    return (example.state, *(None if value != value else value for value in example.values))
