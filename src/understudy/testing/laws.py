"""The error of all checks, and the assertion that raises it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from understudy.errors import UnderstudyError


class LawBroken(UnderstudyError, json_type="LawBroken"):
    """A part of another package that breaks a rule of its contract, such as a feature or an export target.

    Parameters
    ----------
    part
        The part that was checked, such as "feature 'gap'".
    law
        The rule that it breaks.
    found
        The behavior that was observed instead.
    """

    def __init__(self, *, part: str, law: str, found: str) -> None:
        self.part, self.law, self.found = part, law, found
        super().__init__(f"{part} breaks a law: {law}; {found}")


def require(kept: bool, part: str, law: str, found: str) -> None:
    """Raise LawBroken unless a rule was kept."""
    if not kept:
        raise LawBroken(part=part, law=law, found=found)


Returned = TypeVar("Returned")


def require_call(part: str, law: str, function: Callable[[], Returned]) -> Returned:
    """Call a function of the part; raise LawBroken if it raises anything."""
    try:
        return function()
    except Exception as error:  # whatever a function of another package does
        found = f"it raised {type(error).__name__}: {error}"
        raise LawBroken(part=part, law=law, found=found) from error


def require_refusal(part: str, law: str, function: Callable[[], object]) -> UnderstudyError:
    """Call a function of the part that must refuse what it is given, and return its error."""
    try:
        found: object = function()
    except UnderstudyError as error:
        return error
    except Exception as error:  # whatever a function of another package does
        raise LawBroken(part=part, law=law, found=f"it raised {type(error).__name__}: {error}") from error
    raise LawBroken(part=part, law=law, found=f"it returned {found!r:.60}")
