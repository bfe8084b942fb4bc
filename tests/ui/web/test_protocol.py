"""The page's `format_protocol.ts` is what the Python types of the messages say."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Generic, Literal, TypeAlias, TypeVar

import pytest
from msgspec import UNSET, Meta, Struct, UnsetType, field

from understudy.ui.web.protocol import TypeScript, format_protocol

FILE = Path(__file__).parents[3] / "page/src/protocol.ts"


def test_the_page_declares_the_messages_as_they_are() -> None:
    assert FILE.read_text(encoding="utf-8") == format_protocol(), f"{FILE.name} is stale: run make protocol"


Color: TypeAlias = Literal["red", "blue"]
"""How it is drawn."""
Count: TypeAlias = Annotated[int, Meta(ge=0, le=2_000)]


class PointData(Struct):
    """A place."""

    x: float
    y: float


@dataclass(frozen=True)
class Mark:
    """What the product's own values look like."""

    text: str = ""


class ThingData(PointData):
    """Something somewhere."""

    color: Color | None
    from_: Annotated[str, Meta(min_length=1)] = field(name="from")
    """Where it comes from."""
    corners: list[tuple[float, float]]
    next: PointData | None
    marks: tuple[Mark, ...]
    by_name: dict[str, list[Color]]
    label: str | UnsetType = UNSET
    count: Count = 0


class Move(Struct, tag_field="do", tag="move"):
    """Put it elsewhere."""

    id: int
    to: PointData
    times: Count = 1


class Stay(Struct, tag_field="do", tag="stay"):
    """Do nothing.

    Not even once.
    """

    id: int
    why: Annotated[str, Meta(max_length=9)]


TEXT = """\
/** A head. */

export type Request =
  /** Put it elsewhere. */
  | { do: "move"; to: Point; times?: Count }
  /**
   * Do nothing.
   *
   * Not even once.
   */
  | {
      do: "stay";
      /** At most 9 letters. */
      why: string;
    };

/** Something somewhere. */
export interface Thing extends Point {
  color: Color | null;
  /** Where it comes from. At least 1 letters. */
  from: string;
  corners: readonly (readonly [number, number])[];
  next: Point | null;
  marks: readonly Mark[];
  by_name: Readonly<Record<string, readonly Color[]>>;
  label?: string;
  count: Count;
}

/** A place. */
export interface Point {
  x: number;
  y: number;
}

/** Whole, at least 0, at most 2,000. */
export type Count = number;

/** How it is drawn. */
export type Color = "blue" | "red";

/** What the product's own values look like. */
export interface Mark {
  text: string;
}
"""


def test_types_as_typescript() -> None:
    module = TypeScript("A head.", [sys.modules[__name__]])
    module.requests("Request", [Move, Stay], without="id")
    module.interface(ThingData)
    assert module.text() == TEXT


class Odd(Struct):
    """Has a type that JSON does not have."""

    where: Path


def test_a_type_that_json_does_not_have() -> None:
    with pytest.raises(TypeError, match="no TypeScript type for CustomType"):
        TypeScript("", []).interface(Odd)


class Mode(StrEnum):
    """How it goes."""

    FAST = "fast"
    SLOW = "slow"


class Longest(StrEnum):
    """What fills a line."""

    FIRST = "a" * 60
    SECOND = "b" * 60


T = TypeVar("T")


@dataclass(frozen=True)
class Pair(Generic[T]):
    """Two values of one type, which has no name of its own on the page."""

    before: T
    after: T


class RunData(Struct):
    """A run."""

    mode: Mode
    longest: Longest
    count: Pair[int]


DOMAIN = f"""\
/** A run. */
export interface Run {{
  mode: Mode;
  longest: Longest;
  count: {{ before: number; after: number }};
}}

/** How it goes. */
export type Mode = "fast" | "slow";

/** What fills a line. */
export type Longest =
  | "{"a" * 60}"
  | "{"b" * 60}";
"""


def test_enums_and_generic_classes_of_the_domain() -> None:
    module = TypeScript("", [])
    module.interface(RunData)
    assert module.text().strip() == DOMAIN.strip()
