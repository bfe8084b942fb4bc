"""Values of the domain as JSON: what msgspec does not know by itself, and several values as one object."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest
from msgspec import UNSET, Struct, UnsetType, ValidationError, field

from understudy.storage.json_text import encode_json, format_json, select_facts, take_facts


class Tone(StrEnum):
    HIGH = "high"


@dataclass(frozen=True)
class Note:
    tone: Tone
    at: tuple[float, float]


class Answer(Struct):
    re: int
    error: str | UnsetType = UNSET


VALUES = [
    (Note(Tone.HIGH, (0.5, float("nan"))), b'{"tone":"high","at":[0.5,null]}'),
    (Answer(3), b'{"re":3}'),
    (MappingProxyType({"b": Path("x/y"), "a": None}), b'{"b":"x/y","a":null}'),
    ([Note(Tone.HIGH, (1.0, 2.0))], b'[{"tone":"high","at":[1.0,2.0]}]'),
]


@pytest.mark.parametrize(("value", "text"), VALUES)
def test_values_of_the_domain(value: Any, text: bytes) -> None:
    assert encode_json(value) == text


def test_several_values_are_one_object() -> None:
    note = MappingProxyType({"note": Note(Tone.HIGH, (1.0, 2.0))})
    assert encode_json(Answer(3), note) == b'{"re":3,"note":{"tone":"high","at":[1.0,2.0]}}'
    assert encode_json(Answer(3), {}) == b'{"re":3}'


def test_text_for_people() -> None:
    assert format_json({"a": [1]}) == b'{\n  "a": [\n    1\n  ]\n}\n'


def test_what_json_does_not_have() -> None:
    with pytest.raises(NotImplementedError, match="a object in a result"):
        encode_json(object())


class Mark(Struct):
    tone: Tone
    length: int = field(name="size")
    at: list[float]
    error: str | UnsetType = UNSET


@dataclass(frozen=True)
class Sheet:
    notes: tuple[Note, ...]

    @property
    def title(self) -> str:
        return "a sheet"


class Page(Struct):
    title: str
    notes: list[Mark]


def test_facts_are_taken_by_the_names_of_fields() -> None:
    mark = take_facts(Mark, Note(Tone.HIGH, (1.0, 2.0)), length=3, error=UNSET)
    assert encode_json(mark) == b'{"tone":"high","size":3,"at":[1.0,2.0]}'
    assert take_facts(Mark, Note(Tone.HIGH, (1.0, 2.0)), length=3, at=[], error="x") == Mark(
        Tone.HIGH, 3, [], "x"
    )


def test_facts_of_parts_are_taken_in_the_same_way() -> None:
    page = take_facts(Page, Sheet(()), notes=[Mark(Tone.HIGH, 1, [])])
    assert page == Page("a sheet", [Mark(Tone.HIGH, 1, [])])


def test_facts_are_selected_in_order() -> None:
    note = Note(Tone.HIGH, (1.0, float("inf")))
    facts = select_facts(note, "at", "length", "tone", length=3, error="x")
    assert encode_json(facts) == b'{"at":[1.0,null],"length":3,"tone":"high","error":"x"}'
    with pytest.raises(AttributeError, match="length"):
        select_facts(note, "at", "length")


def test_a_fact_that_is_missing_or_of_another_type() -> None:
    with pytest.raises(ValidationError, match="missing required field `length`"):
        take_facts(Mark, Note(Tone.HIGH, (1.0, 2.0)))
    with pytest.raises(ValidationError, match=r"Expected `int`, got `str` - at `\$.length`"):
        take_facts(Mark, Note(Tone.HIGH, (1.0, 2.0)), length="3")
