"""Write plain values as readable TOML: large tables with headings of their own, small ones on one line."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

OPENED = (
    ("types", "*"),
    ("types", "*", "behaviors"),
    ("regions",),
    ("targets",),
    ("features",),
    ("squads", "*"),
    ("squads", "*", "members", "*"),
    ("squads", "*", "statistics"),
    ("squads", "*", "orders"),
    ("radio",),
    ("goal",),
)
"""The tables with headings of their own; `*` is any key."""
LISTED = (("walls",), ("obstacles",), ("objects",), ("robots",), ("types", "*", "sensors"))
"""The lists of tables with headings of their own."""


ABOVE = tuple(opened[:-1] for opened in OPENED if opened[-1] == "*")
"""The tables that contain only tables with headings, and need no headings themselves."""


def format_toml(document: Mapping[str, Any]) -> str:
    """Return a document as TOML text."""
    return "\n".join(_lines(document, (), ())).strip() + "\n"


def _lines(table: Mapping[str, Any], keys: tuple[str, ...], path: tuple[str, ...]) -> list[str]:
    """Return a table's lines: values on one line first, then tables and lists of tables with headings."""
    lines: list[str] = []
    below: list[str] = []
    for key, value in table.items():
        here, at = (*keys, key), _under(path, key)
        heading = ".".join(map(format_toml_key, here))
        if at in OPENED and isinstance(value, Mapping):
            below += ["", f"[{heading}]", *_lines(value, here, at)]
        elif at in LISTED and _are_tables(value):
            for part in value:
                below += ["", f"[[{heading}]]", *_lines(part, here, at)]
        elif at in ABOVE and isinstance(value, Mapping) and _are_tables(list(value.values())):
            below += _lines(value, here, at)
        else:
            lines.append(f"{format_toml_key(key)} = {format_toml_value(value)}")
    return lines + below


def _are_tables(values: Any) -> bool:
    """Return whether a value is a list of tables that is not empty."""
    return (
        isinstance(values, list | tuple)
        and bool(values)
        and all(isinstance(each, Mapping) for each in values)
    )


def _under(path: tuple[str, ...], key: str) -> tuple[str, ...]:
    extended = (*path, key)
    every = {opened[: len(extended)] for opened in (*OPENED, *LISTED)}
    return extended if extended in every else (*path, "*")


def format_toml_key(key: str) -> str:
    """Return a key as TOML text, in quotes if needed."""
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else format_toml_value(key)


def format_toml_value(value: Any) -> str:
    """Return a value as TOML text on one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        inside = ", ".join(
            f"{format_toml_key(key)} = {format_toml_value(part)}" for key, part in value.items()
        )
        return f"{{ {inside} }}" if inside else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(format_toml_value, value))}]"
    return repr(value)
