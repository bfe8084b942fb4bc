"""A buffer for runs of any length: when it is full, it keeps every second item, and from then on half as many."""

from __future__ import annotations

from typing import Generic, TypeVar

Item = TypeVar("Item")


class ThinningBuffer(Generic[Item]):
    """A buffer of at most `most` items at equal distances, and the last one."""

    def __init__(self, most: int) -> None:
        self._most, self._items, self._every, self._seen = most, list[Item](), 1, 0
        self._last: list[Item] = []

    def append(self, item: Item) -> None:
        """Add the next item."""
        if self._seen % self._every == 0:
            if len(self._items) >= self._most:
                self._items, self._every = self._items[::2], 2 * self._every
            if self._seen % self._every == 0:
                self._items.append(item)
        self._seen += 1
        self._last = [item]

    @property
    def items(self) -> list[Item]:
        """The items kept, with the first and the last one always among them."""
        late = self._last and self._items[-1] is not self._last[0]
        return [*self._items, *self._last] if late else list(self._items)
