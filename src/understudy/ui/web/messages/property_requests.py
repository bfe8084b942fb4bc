"""The requests of the page about the properties in the library's file."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, TypeAlias

from msgspec import Meta

from understudy.ui.web.messages.base import Data, Message, NameField, Targets

PropertyKindName: TypeAlias = Literal["never", "always", "never longer", "progress"]
ConditionField: TypeAlias = Annotated[str, Meta(max_length=1000, pattern=r"^[^\x00-\x1f\x7f]*$")]


class PropertyFieldsData(Data, frozen=True, kw_only=True):
    """The fields of a property's form; they are the keys of its table."""

    kind: PropertyKindName
    condition: ConditionField
    """The condition that must never hold, hold in time, or not hold for longer; "goal" is the scenario's goal."""
    seconds: float | None
    """The time in s; null for a condition that must never hold."""
    behavior: ConditionField
    targets: Targets
    world: ConditionField
    """A scenario by name, or a file, relative to the library's folder."""
    seeds: ConditionField
    """As in the file: a number of worlds, a list, or { first = 1000, count = 500 }."""
    limit_s: float | None
    at_least: float | None
    """The share of worlds in which it must hold; null for all."""


class SaveProperty(Message, frozen=True, kw_only=True, tag="save_property"):
    """Write a property to the library's file and test it; with `changes`, in place of the one of this name."""

    name: NameField
    fields: PropertyFieldsData
    changes: bool = False


class DeleteProperty(Message, frozen=True, kw_only=True, tag="delete_property"):
    """Remove a property from the library's file."""

    name: NameField


class TestProperties(Message, frozen=True, kw_only=True, tag="test_properties"):
    """Test one property of the library's file with what is in training; all of them without a name."""

    name: NameField | None = None


class ListPropertyChoices(Message, frozen=True, kw_only=True, tag="property_choices"):
    """List the names that a property in a world can use."""

    by_anyone: ClassVar[bool] = True
    world: ConditionField
    behavior: ConditionField
