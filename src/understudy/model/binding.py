"""Bindings of the parameters of behaviors, features and automata to targets (paper section 3.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any


class Binding(Mapping[str, str]):
    """A frozen, hashable mapping from parameters to names of targets, or of parameters of the enclosing automaton.

    A name that equals a parameter of the enclosing automaton refers to that parameter; any other name is a target.
    An automaton may not give a parameter the name of a target.

    Parameters
    ----------
    items
        Name by parameter. None: no items beside `named`.
    **named
        More names by parameter; they replace those of `items`.

    Examples
    --------
    >>> Binding(target="station")
    Binding(target='station')
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
        """Replace parameters of the enclosing automaton by the names that they are bound to.

        Parameters
        ----------
        around
            The binding of the enclosing automaton: name of a target or parameter, by parameter.

        Returns
        -------
        Binding
            A new binding. Names that are not in `around` stay as they are.

        Examples
        --------
        >>> Binding(target="goal").substitute({"goal": "station"})
        Binding(target='station')
        """
        return Binding({parameter: around.get(name, name) for parameter, name in self._items.items()})


NOTHING_BOUND = Binding()
"""The binding without any parameters."""


def format_bound_name(name: str, binding: Mapping[str, str], parameters: Sequence[str] = ()) -> str:
    """Format a name with its arguments, such as "distance_to(A)"; without a binding return just the name.

    Arguments are in the order of `parameters`, or in alphabetical order of the parameters if those are not the bound
    ones.
    """
    matches = set(parameters) == set(binding)
    ordered = [binding[parameter] for parameter in (parameters if matches else binding)]
    return f"{name}({', '.join(ordered)})" if ordered else name


@dataclass(frozen=True, slots=True)
class Target:
    """A thing that the body can find by name, such as `station` or `nearest_food`.

    Parameters
    ----------
    name
        Name of the target.
    doc
        A sentence for people about what the target is.
    """

    name: str
    doc: str = ""
