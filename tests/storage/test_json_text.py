"""Values of the domain as JSON: what msgspec does not know by itself, and several values as one object."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest
from msgspec import UNSET, Struct, UnsetType

from understudy.storage.json_text import encode_json, format_json


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
