"""The loader of commands, and of what a command needs only once it is known that what it was given can be used."""

from __future__ import annotations

from collections.abc import Callable
from pkgutil import resolve_name
from typing import Any


def import_on_call(place: str) -> Callable[..., Any]:
    """Make a function that imports another one when it is called, and calls it with the same arguments.

    Parameters
    ----------
    place
        The other function, written `package.module:name`. Its module can import at its top what it needs.

    Returns
    -------
    Callable
        The function.
    """

    def call(*arguments: Any, **settings: Any) -> Any:
        return resolve_name(place)(*arguments, **settings)

    return call
