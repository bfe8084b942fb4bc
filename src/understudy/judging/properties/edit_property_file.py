"""Write one table of a file of properties, and leave all else in the file as a person wrote it."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from understudy.errors import FileError
from understudy.judging.properties.property_file import HEAD, parse_tables, read_text
from understudy.sim.scenario.toml_writer import format_toml_key, format_toml_value
from understudy.storage.atomic_write import convert_os_errors, lock_folder, write_atomically


@dataclass(frozen=True, slots=True)
class Statement:
    """The fewest lines of a TOML text that are TOML by themselves: a heading, a key with its value, or a comment.

    `heading` is the path of a heading's table, and `key` the first part of a key; both are empty for comments.
    """

    text: str
    heading: tuple[str, ...] = ()
    key: str = ""

    @property
    def comment(self) -> str:
        """The comment at its end; empty without one."""
        meaning = tomllib.loads(self.text)
        for at, sign in enumerate(self.text):
            if sign == "#" and "\n" not in self.text[at:].rstrip("\n") and _is_same(self.text[:at], meaning):
                return self.text[at:].rstrip("\n")
        return ""


def _is_same(text: str, meaning: Mapping[str, Any]) -> bool:
    try:
        return tomllib.loads(text) == meaning
    except ValueError:
        return False


def split_statements(text: str) -> Iterator[Statement]:
    """Yield the statements of a valid TOML text in order; together they are the text."""
    waiting = ""
    for line in re.split(r"(?<=\n)", text):
        waiting += line
        try:
            meaning = tomllib.loads(waiting)
        except ValueError:
            continue  # its value goes on in the next line
        yield _make_statement(waiting, meaning)
        waiting = ""


def _make_statement(text: str, meaning: Mapping[str, Any]) -> Statement:
    if not meaning:
        return Statement(text)
    if not text.lstrip().startswith("["):
        return Statement(text, key=next(iter(meaning)))
    path = list[str]()
    while isinstance(meaning, dict) and meaning:
        ((name, meaning),) = meaning.items()
        path.append(name)
    return Statement(text, heading=tuple(path))


def set_table(text: str, name: str, table: Mapping[str, Any]) -> str:
    """Return the text of a file of properties with one table added, or changed where its values differ.

    Comments and the order of keys are kept. An added table comes last.
    """
    before = tomllib.loads(text).get(name)
    if before is None:
        lines = [f"[{format_toml_key(name)}]", *(_format_key(key, value) for key, value in table.items())]
        return f"{text.rstrip()}\n\n" + "\n".join(lines) + "\n"
    written, parts, at = set[str](), list[str](), 0
    heading = tuple[str, ...]()
    for each in split_statements(text):
        heading = each.heading or heading
        if heading[:1] != (name,):
            parts.append(each.text)
            continue
        key = each.key if len(heading) == 1 else heading[1]
        is_of_table = len(heading) > 1 or bool(key)
        if not is_of_table:  # its heading, or a comment
            parts.append(each.text)
        elif key in table and before[key] == table[key]:
            written.add(key)
            parts.append(each.text)
        elif not (each.key or each.heading):
            parts.append(each.text)
        else:
            comment = each.comment
            if key in table and key not in written and len(heading) == 1:
                written.add(key)
                parts.append(_format_key(key, table[key]) + (f"  {comment}" if comment else "") + "\n")
            elif comment:
                parts.append(f"{comment}\n")
        if len(heading) == 1 and (each.heading or each.key):
            at = len(parts)
    added = [f"{_format_key(key, value)}\n" for key, value in table.items() if key not in written]
    if at and not parts[at - 1].endswith("\n"):
        parts[at - 1] += "\n"
    return "".join([*parts[:at], *added, *parts[at:]])


def _format_key(key: str, value: Any) -> str:
    return f"{format_toml_key(key)} = {format_toml_value(value)}"


def remove_table(text: str, name: str) -> str:
    """Return the text of a file of properties without one table; comments above and below it are kept."""
    parts, waiting = list[str](), list[str]()
    heading = tuple[str, ...]()
    for each in split_statements(text):
        heading = each.heading or heading
        if heading[:1] != (name,):
            parts += [*_without_double(parts, waiting), each.text]
            waiting = []
        elif each.heading or each.key:
            waiting = []  # comments above it are in the table
        else:
            waiting.append(each.text)
    return "".join([*parts, *_without_double(parts, waiting)]).rstrip() + "\n"


def _without_double(before: list[str], after: list[str]) -> list[str]:
    """Return lines without the first one, if it is empty and follows an empty one."""
    return after[1:] if before and after and not before[-1].strip() and not after[0].strip() else after


def write_property(path: Path | str, name: str, table: Mapping[str, Any] | None) -> None:
    """Write a property to a library's file, which is made if there is none.

    Parameters
    ----------
    path
        The file.
    name
        The name of the property.
    table
        Its keys and values, which have been checked. None: the property is removed.

    Raises
    ------
    FileError
        If the file cannot be read or written, is not a file of properties, or has the property in a form that only a
        person can change. It is left as it is.
    """
    path = Path(path)
    with convert_os_errors(path, "writing the property", remedy="make the library's folder writable"):
        path.parent.mkdir(parents=True, exist_ok=True)
        with lock_folder(path.parent):
            before = read_text(path) if path.exists() else HEAD
            tables = parse_tables(path, before)
            text = before.replace("\r\n", "\n")
            after = remove_table(text, name) if table is None else set_table(text, name, table)
            wanted = {key: value for key, value in tables.items() if key != name}
            if table is not None:
                wanted = tables | {name: dict(table)}
            if not _has_tables(path, after, wanted):
                remedy = f"change it there, or begin the property with [{format_toml_key(name)}]"
                problem = "is written in a form that only a person can change"
                raise FileError(path=path, place=name, problem=problem, remedy=remedy)
            ends = after.replace("\n", "\r\n") if "\r\n" in before else after
            write_atomically(path, ends.encode())


def _has_tables(path: Path, text: str, wanted: Mapping[str, Any]) -> bool:
    """Return whether a text is a file of properties with these tables."""
    try:
        return parse_tables(path, text) == wanted
    except FileError:
        return False
