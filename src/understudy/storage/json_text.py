"""JSON text: values of the domain encoded, documents laid out for reading, and line numbers of places in them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from json import JSONDecodeError, JSONDecoder
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import msgspec

from understudy.errors import FileError, UnderstudyError

T = TypeVar("T")


@contextmanager
def convert_decode_errors() -> Iterator[None]:
    """Raise msgspec.DecodeError for every error of decoding JSON or MessagePack inside.

    msgspec itself raises other errors for text that is not UTF-8, and for values nested deeper than Python's stack.
    """
    try:
        yield
    except UnicodeDecodeError as error:
        raise msgspec.DecodeError("it is not UTF-8 text") from error
    except RecursionError as error:
        raise msgspec.DecodeError("it is nested too deeply") from error


def encode_json(value: Any, *more: Any) -> bytes:
    """Encode a value of the domain as JSON in one line: dataclasses and structs as objects of their fields.

    Further values are objects whose fields come behind those of the first. Mappings of any class are objects, paths are
    texts, and NaN is null.
    """
    if more:
        parts = [msgspec.to_builtins(each, enc_hook=_to_plain) for each in (value, *more)]
        value = {name: each for part in parts for name, each in part.items()}
    return msgspec.json.encode(value, enc_hook=_to_plain)


def format_json(value: Any) -> bytes:
    """Encode a value of the domain as JSON for people, too: indented, with a line feed at the end."""
    return msgspec.json.format(encode_json(value), indent=2) + b"\n"


def _to_plain(value: object) -> object:
    """Convert mappings and paths, which msgspec cannot encode, to plain data."""
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, Path):
        return str(value)
    raise NotImplementedError(f"a {type(value).__name__} in a result")


def take_facts(into: type[T], facts: object, **derived: object) -> T:
    """Make a dataclass or struct from the attributes that a value has by the names of its fields, and from `derived`.

    Fields that are structs themselves are made of their values in the same way. What is UNSET is left out.
    """
    return msgspec.convert(_Facts(facts, derived), into, from_attributes=True)


def select_facts(facts: object, *names: str, **derived: object) -> dict[str, Any]:
    """Take the attributes of these names that a value has, in order, for an object of JSON.

    What is in `derived` comes instead of an attribute of that name, or behind all of them.
    """
    return {name: derived[name] if name in derived else getattr(facts, name) for name in names} | derived


class _Facts:
    """The attributes of a value, and beside or instead of them those that were derived."""

    def __init__(self, facts: object, derived: Mapping[str, object]) -> None:
        self._facts, self._derived = facts, derived

    def __getattr__(self, name: str) -> Any:
        value = self._derived[name] if name in self._derived else getattr(self._facts, name)
        if value is msgspec.UNSET:
            raise AttributeError(name)
        return value


OPENED = (
    (),
    ("automaton",),
    ("automaton", "states"),
    ("automaton", "features"),
    ("lesson",),
    ("lesson", "examples"),
    ("lesson", "watched"),
    ("lesson", "watched", "*"),
    ("lesson", "watched", "*", "values"),
    ("lesson", "watched", "*", "own"),
    ("lesson", "record"),
    ("lesson", "record", "readings"),
    ("lesson", "outcomes"),
    ("built",),
    ("built", "trees"),
    ("built", "trees", "*"),
)
"""The objects and arrays whose members each get a line of their own; `*` stands for any key or index."""


def format_document(document: Any) -> bytes:
    """Format a document as JSON: indented, keys in declared order, UTF-8, with a line feed at the end."""
    return (_lines(msgspec.to_builtins(document), (), "") + "\n").encode("utf-8")


def _lines(value: Any, path: tuple[str, ...], indent: str) -> str:
    if path not in OPENED or not value or not isinstance(value, dict | list):
        return msgspec.json.format(encode_json(value), indent=0).decode("utf-8")
    below = indent + "  "
    if isinstance(value, dict):
        lines = [
            f"{_lines(key, ('',), '')}: {_lines(part, _under(path, key), below)}"
            for key, part in value.items()
        ]
    else:
        lines = [_lines(part, (*path, "*"), below) for part in value]
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    return f"{opening}\n{below}" + f",\n{below}".join(lines) + f"\n{indent}{closing}"


def _under(path: tuple[str, ...], key: str) -> tuple[str, ...]:
    return (*path, key) if (*path, key) in OPENED else (*path, "*")


def find_repeated_key(text: str) -> str | None:
    """Find the first key that occurs twice in an object of a JSON text, or None.

    JSON parsers would silently drop one of the two.
    """
    repeated: list[str] = []

    def look(pairs: list[tuple[str, Any]]) -> None:
        keys = [key for key, _ in pairs]
        repeated.extend(key for key in dict.fromkeys(keys) if keys.count(key) > 1)

    JSONDecoder(object_pairs_hook=look).decode(text)
    return repeated[0] if repeated else None


def find_line(text: str, steps: Sequence[str | int]) -> int | None:
    """Find the line, from 1, of the member at the given keys and indices, or of its nearest ancestor."""
    position = _skip(text, 0)
    try:
        for step in steps:
            position = _member(text, position, step)
    except (JSONDecodeError, IndexError, KeyError):
        pass
    return text.count("\n", 0, position) + 1 if position < len(text) else None


def format_json_path(steps: Sequence[str | int]) -> str:
    """Format keys and indices as a JSON path, such as "$.automaton.states[2].name"."""
    return "$" + "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps)


def parse_json_path(path: str) -> tuple[str | int, ...]:
    """Parse a JSON path as msgspec writes it into keys and indices, up to the first that it leaves out ("[...]")."""
    complete = path.removeprefix("$").partition("[...]")[0]
    return tuple(int(index) if index else key for key, index in re.findall(r"\.(\w+)|\[(\d+)\]", complete))


def _skip(text: str, position: int) -> int:
    while position < len(text) and text[position] in " \t\r\n,:":
        position += 1
    return position


def _member(text: str, position: int, step: str | int) -> int:
    """Return the position of the member `step` of the object or array at `position`."""
    decoder = JSONDecoder()
    opening, position = text[position], _skip(text, position + 1)
    for index in range(len(text)):
        if text[position] in "]}":
            break
        key: str | int = index
        if opening == "{":
            key, position = decoder.raw_decode(text, position)
            position = _skip(text, position)
        if key == step:
            return position
        _, position = decoder.raw_decode(text, position)
        position = _skip(text, position)
    raise KeyError(step)


JsonSteps: TypeAlias = tuple[str | int, ...]


@dataclass(frozen=True, slots=True)
class Source:
    """The text of a document and the path of its file, for error messages."""

    path: Path | str
    text: str

    def make_error(
        self, steps: JsonSteps, problem: str, remedy: str, kind: type[FileError] = FileError
    ) -> FileError:
        """Make the error for what is at the given keys and indices."""
        return kind(path=self.path, place=self.place(steps), problem=problem, remedy=remedy)

    def place(self, steps: JsonSteps) -> str:
        """Format keys and indices as a JSON path with its line."""
        line = find_line(self.text, steps)
        return format_json_path(steps) + (f" (line {line})" if line else "")

    @contextmanager
    def convert_errors(
        self, steps: JsonSteps, remedy: str = "edit it there, or restore an earlier version"
    ) -> Iterator[None]:
        """Convert errors of the model raised inside into a FileError at this place of the document."""
        try:
            yield
        except FileError:
            raise
        except UnderstudyError as error:
            raise self.make_error(steps, str(error), remedy) from error

    def check_unique(self, names: Sequence[str], steps: JsonSteps, what: str) -> None:
        """Refuse names of which one occurs twice."""
        first_indices: dict[str, int] = {}
        for index, name in enumerate(names):
            if name in first_indices:
                raise self.make_error(
                    (*steps, index), f"{what} {name!r} is there twice", "rename or remove one of the two"
                )
            first_indices[name] = index
