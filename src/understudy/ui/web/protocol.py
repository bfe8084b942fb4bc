"""Write the page's `protocol.ts`: `python -m understudy.ui.web.protocol FILE`, or `make protocol`."""

from __future__ import annotations

import ast
import inspect
import json
import sys
from collections.abc import Iterable, Iterator
from itertools import pairwise
from pathlib import Path
from textwrap import dedent, indent
from types import ModuleType
from typing import Any, NamedTuple, get_origin

import msgspec.inspect as mi
from msgspec import NODEFAULT, Struct

from understudy.ui.controller import key_bindings, status
from understudy.ui.web.actions import handler_table
from understudy.ui.web.actions.handler_table import list_reply_types
from understudy.ui.web.drive_server import DriveNewsData
from understudy.ui.web.messages import (
    base,
    drive,
    review,
    session,
)
from understudy.ui.web.server import (
    AnswerData,
    HelloData,
    SceneNewsData,
    SessionNewsData,
    TeamNewsData,
)
from understudy.ui.web.views import drive_review as drive_review_view
from understudy.ui.web.views import scene, watched_team
from understudy.ui.web.views import session as session_view

SUFFIX = "Data"
"""A struct called `ExampleData` is the interface `Example`."""
WIDTH = 110
"""The line length of the page's source, in characters."""


class _Alias(NamedTuple):
    name: str
    meaning: mi.Type
    comment: str


class TypeScript:
    """A TypeScript module under construction, formatted as prettier does.

    Structs, dataclasses and the type aliases of `modules` are declared once, after what refers to them. Docstrings,
    those below fields too, and the limits of values become comments.
    """

    def __init__(self, header: str, modules: Iterable[ModuleType]) -> None:
        self._parts = [_comment(header)]
        self._aliases = [alias for module in modules for alias in _aliases(module)]
        self._waiting: list[type[Any] | _Alias] = []
        self._declared: set[str] = set()

    def text(self) -> str:
        """Return the source of the module with all declarations that are referred to."""
        while self._waiting:
            each = self._waiting.pop(0)
            if isinstance(each, _Alias):
                self._alias(each)
            else:
                self.interface(each)
        return "\n".join(self._parts)

    def requests(self, name: str, structs: Iterable[type[Struct]], *, without: str) -> None:
        """Declare a union of tagged structs, each written in place; the field `without` is left out."""
        members = "".join(f"{_comment(_doc(each))}| {self._in_place(each, without)}\n" for each in structs)
        self._parts.append(f"export type {name} =\n{indent(members, '  ').rstrip()};\n")

    def union(self, name: str, members: Iterable[type[Struct] | str], *, comment: str) -> None:
        """Declare a union of structs, or of types declared under a name."""
        names = [each if isinstance(each, str) else self._name(each) for each in members]
        self._parts.append(f"{_comment(comment)}export type {name} = {' | '.join(names)};\n")

    def interface(self, struct: type[Any], *, partly: Iterable[type[Struct]] = ()) -> None:
        """Declare an interface, with the fields of the structs `partly` as optional ones."""
        if struct.__name__ in self._declared:
            return
        self._declared.add(struct.__name__)
        base = struct.__base__
        inherited: set[str] = set()
        bases = []
        if base is not None and issubclass(base, Struct) and base.__struct_fields__:
            inherited = set(base.__struct_fields__)
            bases.append(self._name(base))
        bases += [f"Partial<{self._name(each)}>" for each in partly]
        head = f"export interface {_name(struct)}"
        if bases:
            short = f"{head} extends {', '.join(bases)}"
            separator = ",\n    "
            head = short if len(short) + 2 <= WIDTH else f"{head}\n  extends\n    {separator.join(bases)}"
        body = indent("".join(self._fields(struct, without=inherited)), "  ")
        self._parts.append(f"{_comment(_doc(struct))}{head} {{\n{body}}}\n")

    def _alias(self, alias: _Alias) -> None:
        if alias.name not in self._declared:
            self._declared.add(alias.name)
            comment = " ".join(filter(None, [alias.comment, _limits(alias.meaning)]))
            head, meaning = f"{_comment(comment)}export type {alias.name} =", self._type(alias.meaning)
            line = f"export type {alias.name} = {meaning};"
            broken = "".join(f"\n  | {each}" for each in meaning.split(" | "))
            self._parts.append(f"{head} {meaning};\n" if len(line) <= WIDTH else f"{head}{broken};\n")

    def _in_place(self, struct: type[Struct], without: str) -> str:
        lines = self._fields(struct, without={without}, sent=True)
        short = f"{{ {' '.join(line.rstrip() for line in lines).removesuffix(';')} }}"
        if len(short) + 4 <= WIDTH and not any("\n" in line.rstrip() for line in lines):
            return short
        return f"{{\n{indent(''.join(lines), '    ')}  }}"

    def _fields(self, struct: type[Any], *, without: set[str], sent: bool = False) -> list[str]:
        """Return the declarations of the fields, each below its comment.

        A sent request may omit fields with a default; the studio's messages omit only fields that are UNSET.
        """
        info, comments = mi.type_info(struct), _field_comments(struct)
        lines = []
        if isinstance(info, mi.StructType) and info.tag is not None:
            lines.append(f"{info.tag_field}: {json.dumps(info.tag)};\n")
        for field in info.fields if isinstance(info, mi.StructType | mi.DataclassType) else ():
            if field.name not in without:
                named, limits = self._named(field.type), _limits(field.type)
                comment = " ".join(filter(None, [comments.get(field.name), None if named else limits]))
                defaults = field.default is not NODEFAULT or field.default_factory is not NODEFAULT
                optional = "" if field.required or (defaults and not sent) else "?"
                lines.append(
                    f"{_comment(comment)}{field.encode_name}{optional}: {self.type_of(field.type)};\n"
                )
        return lines

    def type_of(self, kind: mi.Type) -> str:
        """Return the TypeScript type: its alias if there is one, else written out."""
        return self._named(kind) or self._type(kind)

    def _named(self, kind: mi.Type) -> str | None:
        alias = next((each for each in self._aliases if each.meaning == kind), None)
        if alias is None:
            return None
        self._waiting.append(alias)
        return alias.name

    def _name(self, struct: type[Any]) -> str:
        self._waiting.append(struct)
        return _name(struct)

    def _type(self, kind: mi.Type) -> str:
        match kind:
            case mi.BoolType():
                return "boolean"
            case mi.IntType() | mi.FloatType():
                return "number"
            case mi.StrType():
                return "string"
            case mi.NoneType():
                return "null"
            case mi.EnumType():
                return self._enum(kind)
            case mi.LiteralType():
                return " | ".join(map(json.dumps, kind.values))
            case mi.TupleType():
                return f"readonly [{', '.join(map(self.type_of, kind.item_types))}]"
            case mi.CollectionType():
                item = self.type_of(kind.item_type)
                return f"readonly {item}[]" if item.isidentifier() else f"readonly ({item})[]"
            case mi.DictType():
                return f"Readonly<Record<{self.type_of(kind.key_type)}, {self.type_of(kind.value_type)}>>"
            case mi.UnionType():
                return self._union(kind)
            case mi.DataclassType() if get_origin(kind.cls) is not None:
                # A generic class for some type has no name of its own.
                return f"{{ {'; '.join(f'{each.name}: {self.type_of(each.type)}' for each in kind.fields)} }}"
            case mi.StructType() | mi.DataclassType():
                return self._name(kind.cls)
        raise TypeError(f"no TypeScript type for {kind}")

    def _enum(self, kind: mi.EnumType) -> str:
        values = mi.LiteralType(tuple(each.value for each in kind.cls))
        self._waiting.append(_Alias(kind.cls.__name__, values, _doc(kind.cls)))
        return kind.cls.__name__

    def _union(self, kind: mi.UnionType) -> str:
        """Return a union type with null last."""
        null_last = sorted(kind.types, key=lambda each: isinstance(each, mi.NoneType))
        return " | ".join(map(self.type_of, null_last))


def _name(struct: type[Any]) -> str:
    return struct.__name__.removesuffix(SUFFIX)


def _doc(struct: type[Any]) -> str:
    return inspect.getdoc(struct) or ""


def _aliases(module: ModuleType) -> Iterator[_Alias]:
    comments = dict(_comments_below(ast.parse(inspect.getsource(module)).body))
    for name, annotation in module.__annotations__.items():
        if annotation == "TypeAlias":
            yield _Alias(name, mi.type_info(getattr(module, name)), comments.get(name, ""))


def _field_comments(struct: type[Any]) -> dict[str, str]:
    (definition,) = ast.parse(dedent(inspect.getsource(struct))).body
    return dict(_comments_below(definition.body)) if isinstance(definition, ast.ClassDef) else {}


def _comments_below(statements: list[ast.stmt]) -> Iterator[tuple[str, str]]:
    """Yield the name and docstring of each declaration that has a string below it."""
    for declared, after in pairwise(statements):
        match declared, after:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(text))):
                yield name, inspect.cleandoc(text)


def _limits(kind: mi.Type) -> str:
    """Return the limits of a value in words; "" if there are none."""
    match kind:
        case mi.IntType():
            return _between(kind.ge, kind.le, what="Whole")
        case mi.FloatType():
            more = _between(kind.ge, kind.le)
            return more if kind.gt is None else f"More than {kind.gt:,g}. {more}"
        case mi.StrType():
            return _between(kind.min_length, kind.max_length, " letters")
        case mi.CollectionType():
            return _between(kind.min_length, kind.max_length, " items")
    return ""


def _between(least: float | None, most: float | None, unit: str = "", *, what: str = "") -> str:
    bounds = [f"at least {least:,.0f}"] if least is not None else []
    bounds += [f"at most {most:,.0f}"] if most is not None else []
    text = ", ".join([what, *bounds] if what else bounds)
    return f"{text[0].upper()}{text[1:]}{unit}." if bounds else ""


def _comment(text: str) -> str:
    if not text:
        return ""
    lines = text.splitlines()
    if len(lines) == 1:
        return f"/** {text} */\n"
    return "/**\n" + "".join(f" * {line}".rstrip() + "\n" for line in lines) + " */\n"


HEADER = (
    "What page and studio send each other as text. Generated by `make protocol`: change the Python types."
)
ALIASES = (
    base,
    session,
    review,
    drive,
    scene,
    session_view,
    watched_team,
    status,
    key_bindings,
)


def format_protocol() -> str:
    """Return all messages between page and studio as a TypeScript module."""
    module = TypeScript(HEADER, ALIASES)
    module.requests("Request", session.REQUESTS, without="id")
    module.interface(AnswerData, partly=list_reply_types(*handler_table.MODULES))
    module.union(
        "News",
        [HelloData, SceneNewsData, SessionNewsData, TeamNewsData],
        comment="What the studio sends by itself.",
    )
    module.requests("ReviewRequest", drive.REVIEW_REQUESTS, without="")
    module.requests("DriveRequest", drive.DRIVE_REQUESTS, without="")
    module.interface(DriveNewsData)
    module.interface(drive_review_view.ReviewData)
    module.interface(drive_review_view.RecordedSeriesData)
    return module.text()


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(format_protocol(), encoding="utf-8")
