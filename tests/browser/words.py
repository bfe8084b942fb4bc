"""How the page writes names of the code."""

from __future__ import annotations

import re

CALL = re.compile(r"(\w+)\((.*)\)")


def plain(name: str) -> str:
    """Return a name as people read it on the page: distance_to(A) is "distance to A", rotate_left "turn left"."""
    if found := CALL.fullmatch(name):
        what, targets = plain(found[1]), ", ".join(map(plain, found[2].split(",")))
        return f"{what} {targets}" if what.endswith("to") else f"{what} ({targets})"
    return name.replace("rotate_", "turn_").replace("_", " ").strip()
