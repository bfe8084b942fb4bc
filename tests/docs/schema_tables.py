"""Tables of the keys of a file, for the reference: types and defaults from its schema, meanings from its page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import msgspec
from msgspec import inspect

Rows = dict[str, str]
"""The meaning of each key."""
Parts = Mapping[type[msgspec.Struct], tuple[str, Rows]]
"""The heading and the rows of each part of a file."""


def format_tables(parts: Parts) -> str:
    """Return a heading and a table for each part, as Markdown, for files of JSON."""
    return "\n" + "\n".join(line for part in parts for line in _section(part, parts)) + "\n"


def _section(part: type[msgspec.Struct], parts: Parts) -> Iterator[str]:
    title, rows = parts[part]
    described = inspect.type_info(part)
    assert isinstance(described, inspect.StructType)
    yield f"### {title}\n"
    yield "| key | type | if left out | meaning |"
    yield "|---|---|---|---|"
    if described.tag is not None:
        yield f"| `{described.tag_field}` | `{described.tag}` | required | the sort of this object |"
    for field in described.fields:
        name = field.encode_name
        yield f"| `{name}` | {_type(field.type, parts)} | {_default(field)} | {rows[name]} |"
    yield ""


def _type(found: inspect.Type, parts: Parts) -> str:
    match found:
        case inspect.UnionType():
            return " or ".join(dict.fromkeys(_type(each, parts) for each in found.types))
        case inspect.EnumType():
            return " or ".join(f"`{value}`" for value in sorted(each.value for each in found.cls))
        case inspect.LiteralType():
            return " or ".join(f"`{value}`" for value in found.values)
        case inspect.ListType() | inspect.VarTupleType():
            return f"list of: {_type(found.item_type, parts)}"
        case inspect.TupleType():
            return f"{len(found.item_types)} × {_type(found.item_types[0], parts)}"
        case inspect.DictType():
            return f"object by name: {_type(found.value_type, parts)}"
        case inspect.StructType():
            title = parts[found.cls][0]
            return f"[{title.lower()}](#{title.lower().replace(' ', '-').replace('`', '')})"
        case _:
            return PLAIN[type(found)]


PLAIN: dict[type[inspect.Type], str] = {
    inspect.AnyType: "any value",
    inspect.StrType: "text",
    inspect.BoolType: "boolean",
    inspect.IntType: "integer",
    inspect.FloatType: "number",
    inspect.NoneType: "null",
}


def _default(field: inspect.Field) -> str:
    if field.required:
        return "required"
    default: Any = field.default
    if default is msgspec.NODEFAULT:
        default = field.default_factory() if callable(field.default_factory) else ""
    if (
        default is None
        or isinstance(default, msgspec.UnsetType | msgspec.Struct)
        or default in ("", {}, [], ())
    ):
        return "none"
    return f"`{str(default).lower()}`" if isinstance(default, bool) else f"`{default}`"
