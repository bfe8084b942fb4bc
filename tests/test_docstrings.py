"""Docstrings of what people call from programs of their own say everything that a caller needs."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import Any

import understudy
import understudy.spi
import understudy.testing
from understudy.runtime import body

PROTOCOLS = [each for each in vars(body).values() if getattr(each, "_is_protocol", False)]
"""What people implement."""


def list_callables() -> Iterator[tuple[str, Any]]:
    """List public functions, and the public methods of public classes, also those inherited from classes of ours."""
    exported = [
        getattr(module, name)
        for module in (understudy, understudy.spi, understudy.testing)
        for name in module.__all__
    ]
    for each in [*exported, *PROTOCOLS]:
        if inspect.isfunction(each):
            yield each.__name__, each
        elif inspect.isclass(each):
            ours = [base for base in each.__mro__ if base.__module__.startswith("understudy.")]
            for name, member in ((name, member) for base in ours for name, member in vars(base).items()):
                function = member.__func__ if isinstance(member, classmethod | staticmethod) else member
                if inspect.isfunction(function) and not name.startswith("_"):
                    yield f"{each.__name__}.{name}", function


def test_parameters_and_result_are_described() -> None:
    callables = dict(list_callables())
    assert len(callables) > 150
    found = []
    for name, function in callables.items():
        text, signature = inspect.getdoc(function) or "", inspect.signature(function)
        taken = [each for each in signature.parameters if each not in ("self", "cls")]
        if taken and "Parameters\n----------\n" not in text:
            found.append(f"{name} has no section Parameters")
        returns = signature.return_annotation not in ("None", None, inspect.Signature.empty)
        sections = (f"{section}\n{'-' * len(section)}\n" for section in ("Returns", "Yields"))
        if returns and not any(section in text for section in sections):
            found.append(f"{name} has no section Returns or Yields")
    assert not found, "\n".join(found)
