"""Base types and field types of messages, and the descriptions of invalid ones."""

from __future__ import annotations

import re
from typing import Annotated, ClassVar, Self, TypeAlias

from msgspec import Meta, Struct

from understudy.storage.json_text import take_facts

Seed: TypeAlias = Annotated[int, Meta(ge=0, le=2**53 - 1)]
Id: TypeAlias = Annotated[int, Meta(ge=0, le=2**53 - 1)]
NameField: TypeAlias = Annotated[str, Meta(min_length=1, max_length=150, pattern=r"^[^\x00-\x1f\x7f]*$")]
Call: TypeAlias = Annotated[str, Meta(min_length=1, max_length=1000, pattern=r"^[^\x00-\x1f\x7f]*$")]
"""A behavior or feature with its targets, such as goto(station)."""
ValueField: TypeAlias = Annotated[str, Meta(max_length=150, pattern=r"^[^\x00-\x1f\x7f]*$")]
"""A feature's value as the page shows it: 3.42 m, −31°, yes, or nothing."""
Calls: TypeAlias = Annotated[list[Call], Meta(max_length=200)]
NameListField: TypeAlias = Annotated[list[NameField], Meta(max_length=200)]
Targets: TypeAlias = dict[NameField, NameField]
"""The target of each parameter."""
Index: TypeAlias = Annotated[int, Meta(ge=0, le=2**31 - 1)]
_FOUND = re.compile(r"(Expected .*) - at (`key` in )?`\$\.(\w+)(?:\[(\d+|\.\.\.)\])?`")
_SENTENCES = (
    (r"`str` of length <= (\d+)", "{what} has more than {0} characters: shorten it"),
    (r"`str` of length >= 1", "{what} is empty: give one"),
    (
        r"`str` matching regex .*",
        "{what} has a character that cannot be printed, such as a line break: leave it out",
    ),
    (r"`array` of length <= (\d+)", "{what} must be at most {0}: leave some out"),
    (r"`int` <= (\d+)", "{what} is more than {0}: give a smaller number"),
    (r"`int` >= 0|`int.*, got .*", "{what} is not a whole number of 0 or more"),
    (r"`float` > 0.0", "{what} must be above 0"),
    (r"`float` <= ([\d.]+)", "{what} is more than {0}: give a smaller number"),
    (r"`float.*, got .*", "{what} is not a number"),
)
_CALLED = {"to": "the new name", "reaction_s": "the reaction time", "within_s": "the time"}
_KEYS = {"targets": "a parameter", "values": "a feature", "renamed": "a state"}


class Data(Struct, frozen=True):
    """A message part that the studio sends; a struct `ExampleData` is the type `Example` on the page."""

    @classmethod
    def of(cls, facts: object, **derived: object) -> Self:
        """Take the fields from the attributes of these names that a value of the domain has, and from `derived`.

        A field that the page calls otherwise than the domain has the domain's name here, and the page's as
        `field(name=...)`.
        """
        return take_facts(cls, facts, **derived)


class Message(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="do"):
    """A request of a page; its number `id` is repeated in the answer."""

    id: Id
    by_anyone: ClassVar[bool] = False
    """Whether a page that is not in control may send this message."""


def describe_schema_error(problem: str) -> str | None:
    """Return a schema error as a sentence; None if it is not about a value that a person typed."""
    matched = _FOUND.fullmatch(problem)
    if matched is None:
        return None
    expected, key, field, index = matched.groups()
    for pattern, sentence in _SENTENCES:
        if match := re.fullmatch(f"Expected (?:{pattern})", expected):
            return sentence.format(*match.groups(), what=_what(field, index, key=key is not None))
    return None


def _what(field: str, index: str | None, *, key: bool) -> str:
    if key:
        return _KEYS.get(field, "a name")
    if index is None:
        return _CALLED.get(field, f"the {field}")
    one = field.removesuffix("s")
    return f"a {one}" if index == "..." else f"{one} {int(index) + 1}"
