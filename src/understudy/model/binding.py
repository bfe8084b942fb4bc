"""Bindings: what the parameters of a behavior, feature or automaton stand for (paper section 3.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any


class Binding(Mapping[str, str]):
    """Parameter -> the name of a target, or of a parameter of the automaton around it. Frozen and hashable.

    A name that is a parameter of the automaton around is that parameter, otherwise it is a target; an automaton
    may not give a parameter the name of a target. A binding is ground when only targets remain.
    """

    __slots__ = ("_items",)

    def __init__(self, items: Mapping[str, str] | None = None, /, **named: str) -> None:
        self._items = dict(sorted({**(items or {}), **named}.items()))

    def __getitem__(self, parameter: str) -> str:
        return self._items[parameter]

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __hash__(self) -> int:
        return hash(tuple(self._items.items()))

    def __eq__(self, other: Any) -> bool:
        return isinstance(other, Binding) and self._items == other._items

    def __repr__(self) -> str:
        return f"Binding({', '.join(f'{key}={value!r}' for key, value in self._items.items())})"

    def substitute(self, around: Mapping[str, str]) -> Binding:
        """This binding with the parameters of the automaton around it replaced by what they stand for."""
        return Binding({parameter: around.get(name, name) for parameter, name in self._items.items()})


NOTHING_BOUND = Binding()


def format_bound_name(name: str, binding: Mapping[str, str], parameters: Sequence[str] = ()) -> str:
    """How a bound name is written: distance_to(A), or just done where there is nothing to bind.

    Arguments are in the order of the `parameters`, in which they are read again; in that of the binding, which is by
    alphabet, where these are not known.
    """
    known = set(parameters) == set(binding)
    ordered = [binding[parameter] for parameter in (parameters if known else binding)]
    return f"{name}({', '.join(ordered)})" if ordered else name


@dataclass(frozen=True, slots=True)
class Target:
    """A thing the body can find by this name: station, nearest_food."""

    name: str
    doc: str = ""
