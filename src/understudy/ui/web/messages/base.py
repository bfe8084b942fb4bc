"""What messages are made of: the fields that a page fills in, and what all messages have."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from msgspec import Meta, Struct

Id: TypeAlias = Annotated[int, Meta(ge=0, le=2**53 - 1)]
Name: TypeAlias = Annotated[str, Meta(min_length=1, max_length=150, pattern=r"^[^\x00-\x1f\x7f]*$")]
Call: TypeAlias = Annotated[str, Meta(min_length=1, max_length=1000, pattern=r"^[^\x00-\x1f\x7f]*$")]
"""What a state runs, or a feature of targets: a name and what it is called with, as goto(station)."""
Value: TypeAlias = Annotated[str, Meta(max_length=150, pattern=r"^[^\x00-\x1f\x7f]*$")]
"""A feature's value as it is shown: 3.42 m, −31°, yes, or nothing."""
Calls: TypeAlias = Annotated[list[Call], Meta(max_length=200)]
Names: TypeAlias = Annotated[list[Name], Meta(max_length=200)]
Targets: TypeAlias = dict[Name, Name]
Seed: TypeAlias = Annotated[int, Meta(ge=0, le=2**53 - 1)]
Index: TypeAlias = Annotated[int, Meta(ge=0, le=2**31 - 1)]


class Message(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="do"):
    """What all messages have: a number that the answer repeats."""

    id: Id
