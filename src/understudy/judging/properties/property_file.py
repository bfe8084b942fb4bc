"""The file `properties.toml` in a library's folder: what its behaviors must never do, or must do in time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any

from msgspec import UNSET, UnsetType, field

from understudy.errors import (
    DefinitionError,
    FileError,
    SettingError,
    UnderstudyError,
    join_names,
)
from understudy.judging.properties.condition import parse_condition
from understudy.judging.properties.contradictions import check_condition
from understudy.model.binding import Binding
from understudy.model.property import GOAL, PROGRESS, Property, PropertyKind, SeededWorlds
from understudy.sim.scenario.squad_schema import StrictStruct
from understudy.sim.scenario.toml_decode import DecodeProblem, decode_toml_values, parse_toml

FILE = "properties.toml"
FORMAT, VERSION = "properties", 1
HEAD = f'understudy = "{FORMAT}"\nversion = {VERSION}\n'
MOST_SEEDS = 10_000_000
CLAIMS = ("never", "always", "never_longer_than_s")
CLAIM_KEYS: Mapping[PropertyKind, tuple[str, ...]] = MappingProxyType(
    {
        PropertyKind.NEVER: ("never",),
        PropertyKind.ALWAYS: ("always", "within_s"),
        PropertyKind.NEVER_LONGER: ("never_longer_than_s", "while"),
        PropertyKind.PROGRESS: ("never_longer_than_s", "without"),
    }
)
"""By the kind of a property, the keys of its condition and its time, as they are written."""


class SeedRange(StrictStruct, frozen=True, kw_only=True):
    """A number of seeds in a row, from `first`."""

    first: int = 0
    count: int


class PropertyTable(StrictStruct, frozen=True, kw_only=True):
    """A table of the file, which is one property.

    One of `never`, `always` and `never_longer_than_s` says what it claims.
    """

    behavior: str
    world: str
    seeds: int | tuple[int, ...] | SeedRange
    targets: Mapping[str, str] = field(default_factory=dict)
    limit_s: float | None = None
    at_least: float | None = None
    never: str | UnsetType = UNSET
    always: str | UnsetType = UNSET
    within_s: float | UnsetType = UNSET
    never_longer_than_s: float | UnsetType = UNSET
    while_: str | UnsetType = field(default=UNSET, name="while")
    without: str | UnsetType = UNSET


def load_properties(path: Path | str) -> tuple[Property, ...]:
    """Load a file of properties.

    Parameters
    ----------
    path
        The file. The names of scenario files in it are relative to its folder.

    Returns
    -------
    tuple[Property, ...]
        The properties, in order. Names of behaviors, scenarios and readings are not checked.

    Raises
    ------
    FileError
        If the file cannot be read or is not valid. It names the table and the key.
    """
    path = Path(path)
    return tuple(parse_property(path, name, table) for name, table in load_tables(path).items())


def load_tables(path: Path | str) -> dict[str, Any]:
    """Load the tables of a file of properties, by name, without looking into them; FileError if it is not one."""
    return parse_tables(path, read_text(path))


def read_text(path: Path | str) -> str:
    """Return the text of a file of properties with its own ends of lines; FileError if it cannot be read."""
    try:
        return Path(path).read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise FileError(
            path=path, place="", problem=f"cannot be read ({error})", remedy="give a file"
        ) from None
    except UnicodeDecodeError:
        raise FileError(path=path, place="", problem="is not UTF-8 text", remedy="save it as UTF-8") from None


def parse_tables(path: Path | str, text: str) -> dict[str, Any]:
    """Parse the text of a file of properties into its tables, by name; FileError if it is not such a text."""
    document = parse_toml(text, path)
    begin = "let the file begin with " + join_names(repr(line) for line in HEAD.splitlines())
    mark = document.pop("understudy", None)
    if mark != FORMAT:
        problem = "is missing" if mark is None else f"is {mark!r:.60}: this is not a file of properties"
        raise FileError(path=path, place="understudy", problem=problem, remedy=begin)
    version = document.pop("version", None)
    if type(version) is not int or version < 1:
        problem = "is missing" if version is None else f"is {version!r:.60}"
        raise FileError(path=path, place="version", problem=problem, remedy=begin)
    if version > VERSION:
        problem = f"is {version}, and this Understudy reads properties up to version {VERSION}"
        raise FileError(path=path, place="version", problem=problem, remedy="use a newer Understudy")
    return document


def parse_property(path: Path | str, name: str, table: object) -> Property:
    """Parse one table of a file of properties.

    Parameters
    ----------
    path
        The file, which errors name.
    name
        The name of the table.
    table
        Its keys and values.

    Returns
    -------
    Property
        The property. Names of behaviors, scenarios and readings are not checked.

    Raises
    ------
    FileError
        If the table is not valid. It names the table and the key.
    """
    path = Path(path)
    if not isinstance(table, dict):
        raise FileError(
            path=path, place=name, problem="is not a table", remedy=f"begin a property with [{name}]"
        )
    decoded = decode_toml_values(table, PropertyTable)
    if isinstance(decoded, DecodeProblem):
        raise _error(path, name, decoded.key, decoded.problem, decoded.remedy)
    claims = [key for key in CLAIMS if key in table]
    if len(claims) != 1:
        problem = f"is there beside {claims[0]}" if claims else "is missing"
        remedy = f"give one of {join_names(CLAIMS)}"
        raise _error(path, name, claims[1] if claims else "never", problem, remedy)
    kind, what, seconds = _read_claim(path, name, decoded)
    if kind is not PropertyKind.PROGRESS:
        with locate_errors(path, name, find_condition_key(kind)):
            check_condition(kind, parse_condition(what))
    for key, time in (("within_s", decoded.within_s), ("never_longer_than_s", decoded.never_longer_than_s)):
        if not isinstance(time, UnsetType) and not 0 < time <= 86_400:
            raise _error(path, name, key, f"is {time:g}", "give seconds above 0, and at most 86400")
    if decoded.limit_s is not None and not 0 < decoded.limit_s < float("inf"):
        raise _error(path, name, "limit_s", f"is {decoded.limit_s:g}", "give seconds above 0")
    if decoded.limit_s is not None and kind is PropertyKind.ALWAYS:
        raise _error(path, name, "limit_s", "is not needed: within_s is the limit", "leave it out")
    if decoded.at_least is not None and not 0 < decoded.at_least < 1:
        remedy = "give a share between 0 and 1, or leave it out for all worlds"
        raise _error(path, name, "at_least", f"is {decoded.at_least:g}", remedy)
    start = SeededWorlds(locate_world(path, decoded.world), _list_seeds(path, name, decoded), decoded.limit_s)
    return Property(
        kind=kind,
        what=what,
        seconds=seconds,
        start=start,
        behavior=decoded.behavior,
        targets=Binding(decoded.targets),
        name=name,
        at_least=decoded.at_least,
    )


def _read_claim(path: Path, name: str, table: PropertyTable) -> tuple[PropertyKind, str, float | None]:
    """Return the kind of a property, its condition, and its time."""
    values = {
        "within_s": table.within_s,
        "while": table.while_,
        "without": table.without,
    }
    if not isinstance(table.never, UnsetType):
        _refuse(path, name, values, "never")
        return PropertyKind.NEVER, table.never, None
    if not isinstance(table.always, UnsetType):
        if isinstance(table.within_s, UnsetType):
            raise _error(path, name, "within_s", "is missing", "give the time in s")
        _refuse(path, name, values, "always", "within_s")
        return PropertyKind.ALWAYS, GOAL if table.always == "goal" else table.always, table.within_s
    seconds = 0.0 if isinstance(table.never_longer_than_s, UnsetType) else table.never_longer_than_s
    if not isinstance(table.while_, UnsetType):
        _refuse(path, name, values, "never_longer_than_s", "while")
        return PropertyKind.NEVER_LONGER, table.while_, seconds
    if table.without != PROGRESS:
        problem = "is missing" if isinstance(table.without, UnsetType) else f"is {table.without!r:.60}"
        raise _error(path, name, "without", problem, "write without = 'progress', or while = CONDITION")
    _refuse(path, name, values, "never_longer_than_s", "without")
    return PropertyKind.PROGRESS, PROGRESS, seconds


def _refuse(path: Path, name: str, values: dict[str, Any], claim: str, *fitting: str) -> None:
    """Refuse keys that do not belong to a claim."""
    for key, value in values.items():
        if not isinstance(value, UnsetType) and key not in fitting:
            raise _error(path, name, key, f"does not belong to {claim}", "leave it out")


def _list_seeds(path: Path, name: str, table: PropertyTable) -> tuple[int, ...]:
    seeds = table.seeds
    remedy = "give their number, as seeds = 200, or a list, or { first = 1000, count = 200 }"
    if isinstance(seeds, tuple):
        chosen = seeds
    else:
        first, count = (0, seeds) if isinstance(seeds, int) else (seeds.first, seeds.count)
        if not 1 <= count <= MOST_SEEDS:
            raise _error(path, name, "seeds", f"are {count}", f"{remedy}, at most {MOST_SEEDS}")
        chosen = tuple(range(first, first + count))
    if not chosen or min(chosen) < 0 or len(set(chosen)) < len(chosen):
        problem = "are none" if not chosen else "are below 0" if min(chosen) < 0 else "are not all different"
        raise _error(path, name, "seeds", problem, remedy)
    return chosen


def locate_world(path: Path | str, world: str) -> str:
    """Return the name of a scenario; a file that is there is found from the folder of the properties."""
    beside = Path(path).parent / world
    return str(beside) if world.endswith(".toml") and beside.exists() else world


def find_condition_key(kind: PropertyKind) -> str:
    """Return the key that says what a property is about."""
    return next(key for key in CLAIM_KEYS[kind] if not key.endswith("_s"))


def _error(path: Path, name: str, key: str, problem: str, remedy: str) -> FileError:
    return FileError(path=path, place=f"{name}.{key}" if key else name, problem=problem, remedy=remedy)


@contextmanager
def locate_errors(path: Path | str, name: str, key: str) -> Iterator[None]:
    """Turn errors about a name, a unit or a setting into errors about this file, table and key."""
    try:
        yield
    except FileError:
        raise
    except SettingError as error:
        setting = "" if error.setting == "threshold" else f"{error.setting} "
        where = f"{error.where}: " if error.where not in ("condition", "property") else ""
        raise _error(Path(path), name, key, f"{where}{setting}{error.problem}", error.remedy) from error
    except DefinitionError as error:
        raise _error(Path(path), name, key, error.problem, error.remedy) from error
    except UnderstudyError as error:
        problem, _, remedy = str(error).partition("; ")
        raise _error(Path(path), name, key, problem, remedy or "correct it") from error
