"""The form of a property: its fields as the table of the file, and the table as fields."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from msgspec import UnsetType

from understudy.errors import FileError
from understudy.model.property import PROGRESS
from understudy.properties.property_file import CLAIMS, PropertyTable
from understudy.sim.scenario.toml_decode import DecodeProblem, decode_toml_values
from understudy.sim.scenario.toml_writer import format_toml_value
from understudy.ui.web.messages.property_requests import PropertyFieldsData, PropertyKindName

FIELDS = {
    "": "name",
    "never": "condition",
    "always": "condition",
    "while": "condition",
    "without": "kind",
    "within_s": "seconds",
    "never_longer_than_s": "seconds",
}
"""By the key of a table, the field of the form, where it has another name."""
SECONDS = {"always": "within_s", "never longer": "never_longer_than_s", "progress": "never_longer_than_s"}
"""By the kind of a property, the key of its time."""


def make_property_table(path: Path | str, name: str, fields: PropertyFieldsData) -> dict[str, Any]:
    """Make the table of a property from the fields of its form; FileError if a field is empty that must not be."""
    table: dict[str, Any] = {"behavior": fields.behavior}
    if fields.targets:
        table["targets"] = dict(fields.targets)
    table |= {"world": fields.world, "seeds": _parse_seeds(path, name, fields.seeds)}
    seconds = SECONDS.get(fields.kind)
    if seconds is not None:
        if fields.seconds is None:
            raise _wrong(path, name, seconds, "is missing", "give the time in s")
        time = _shorten(fields.seconds)
        if fields.kind == "always":
            table |= {"always": fields.condition, seconds: time}
        else:
            table |= {seconds: time}
            table |= {"without": PROGRESS} if fields.kind == "progress" else {"while": fields.condition}
    else:
        table["never"] = fields.condition
    if fields.limit_s is not None:
        table["limit_s"] = _shorten(fields.limit_s)
    if fields.at_least is not None:
        table["at_least"] = _shorten(fields.at_least)
    return table


def _parse_seeds(path: Path | str, name: str, text: str) -> Any:
    try:
        table = tomllib.loads(f"seeds = {text}")
    except ValueError:
        table = {}
    if list(table) != ["seeds"]:
        remedy = "give their number, as 200, or a list, as [1, 4], or { first = 1000, count = 200 }"
        raise _wrong(path, name, "seeds", f"are {text!r:.60}" if text.strip() else "are missing", remedy)
    return table["seeds"]


def _shorten(number: float) -> float:
    """Return a whole number as one, so that it is written without a point."""
    return int(number) if number.is_integer() else number


def _wrong(path: Path | str, name: str, key: str, problem: str, remedy: str) -> FileError:
    return FileError(path=path, place=f"{name}.{key}", problem=problem, remedy=remedy)


def find_field(name: str, error: FileError) -> tuple[str, str]:
    """Return the field of a property's form that an error is about, and the error without its file and table."""
    key = error.place.removeprefix(name).removeprefix(".")
    of_table = error.place == name or error.place.startswith(f"{name}.")
    if not of_table:
        return "", str(error)
    field = FIELDS.get(key, key.partition(".")[0])
    return field, f"{key or name}: {error.problem}; {error.remedy}"


def read_fields(table: object) -> PropertyFieldsData | None:
    """Return the fields of a table's form; None if its keys are not those of a property."""
    if not isinstance(table, dict):
        return None
    decoded = decode_toml_values(table, PropertyTable)
    if isinstance(decoded, DecodeProblem) or sum(key in table for key in CLAIMS) != 1:
        return None
    kind, condition, seconds = _read_claim(decoded)
    return PropertyFieldsData.of(
        decoded,
        kind=kind,
        condition=condition,
        seconds=None if isinstance(seconds, UnsetType) else seconds,
        seeds=format_toml_value(table["seeds"]),
    )


def _read_claim(table: PropertyTable) -> tuple[PropertyKindName, str, float | UnsetType]:
    if not isinstance(table.never, UnsetType):
        return "never", table.never, table.within_s
    if not isinstance(table.always, UnsetType):
        return "always", table.always, table.within_s
    if not isinstance(table.while_, UnsetType):
        return "never longer", table.while_, table.never_longer_than_s
    return "progress", "", table.never_longer_than_s
