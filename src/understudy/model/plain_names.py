"""Names of the code as people read them: nearest_food is "nearest food", distance_to(A) "distance to A".

The page of the studio does the same in `page/src/words.ts`; one table tests both.
"""

from __future__ import annotations

import re

IDENTIFIER = re.compile(
    r"(?<![\w/\\.'-])(?:([A-Za-z]\w*)\(([^()=]+)\)|([A-Za-z]\w*_\w*[A-Za-z0-9]))(?![\w/\\]|[.-]\w)", re.ASCII
)
"""A call, or a name of several words, unless it stands in quotes or is part of a path."""
VERBS = {"rotate": "turn"}
"""First words of names, and what people say instead."""


def format_names(text: str) -> str:
    """Rewrite the names of the code in a text as people read them: "rotate_left" to "turn left".

    Names in quotes and paths stay, since people type them. So does a name of one word.
    """
    return IDENTIFIER.sub(_format_match, text)


def _format_match(match: re.Match[str]) -> str:
    name, targets, words = match.groups()
    if name is None:
        return _split(words)
    spoken, bound = _split(name), ", ".join(_split(target.strip()) for target in targets.split(","))
    return f"{spoken} {bound}" if spoken.endswith("to") else f"{spoken} ({bound})"


def _split(name: str) -> str:
    first, *rest = (word for word in name.split("_") if word)
    return " ".join((VERBS.get(first, first) if rest else first, *rest))
