"""The error of all checks, and the assertion that raises it."""

from __future__ import annotations

from understudy.errors import UnderstudyError


class LawBroken(UnderstudyError, json_type="LawBroken"):
    """A feature, behavior, body or world that breaks a rule of its contract.

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
