"""Values of messages that bring the names of their fields, such as JSON, as numbers or texts."""

from __future__ import annotations

from collections.abc import Callable
from math import nan
from typing import Any, TypeAlias

from understudy.addons.recordings.table_cells import TRUTHS, parse_number
from understudy.addons.recordings.time_cells import parse_times
from understudy.errors import join_names

Extract: TypeAlias = Callable[[Any], Any]


class Stamp(float):
    """A time in s, which was split into seconds and nanoseconds."""


def _is_object(value: Any) -> bool:
    return hasattr(value, "__dict__") or hasattr(value, "__dataclass_fields__")


def _read_stamp(value: Any) -> float | None:
    """Return the s of a stamp of ROS 2 or ROS 1; None for all else."""
    for whole, part in (("sec", "nanosec"), ("secs", "nsecs")):
        if hasattr(value, whole) and hasattr(value, part):
            return float(getattr(value, whole) + getattr(value, part) * 1e-9)
    return None


def parse_command(value: Any) -> float:
    """Return a command, which may be a truth value or a text of a number; ValueError is raised if it is none."""
    number = TRUTHS.get(value.lower(), parse_number(value)) if isinstance(value, str) else value
    if number is None:
        raise ValueError(f"{value!r:.40} is no number")
    return float(number)


def parse_stamp(value: Any, unit_s: float) -> float:
    """Return a time in s, which may be a text of a date; NaN if it is none."""
    if isinstance(value, str):
        return float(parse_times([value], unit_s)[0])
    return value if isinstance(value, Stamp) else value * unit_s


def make_walk(path: str) -> Extract:
    """Make the function that takes a value out of a message by the names of its fields, as JSON has them."""
    names = path.split(".")

    def extract(message: Any) -> Any:
        value = message
        for name in names:
            if isinstance(value, list) and name.isdecimal():
                value = value[int(name)] if int(name) < len(value) else None
            elif _is_object(value):
                if not hasattr(value, name):
                    has = join_names([*vars(value)]) if hasattr(value, "__dict__") else "others"
                    raise ValueError(f"there is no {name!r} in {path!r}; the fields there are {has}")
                value = getattr(value, name)
            elif value is not None:
                raise ValueError(f"there is no {name!r} in {path!r}; end the path before it")
        if (seconds := _read_stamp(value)) is not None:
            return Stamp(seconds)
        if isinstance(value, list) or _is_object(value):
            inside = map(str, range(len(value))) if isinstance(value, list) else vars(value)
            raise ValueError(f"{path!r} is no number; name one of these in it: {join_names([*inside])}")
        if isinstance(value, bool):
            return str(value).lower()
        if isinstance(value, str):
            return value.strip() or nan
        number = parse_number(value)
        return nan if number is None else number

    return extract


def multiply_values(extract: Extract, factor: float) -> Extract:
    """Return a function whose values are in another unit; texts stay as they are."""
    if factor == 1.0:
        return extract

    def extract_in_unit(message: Any) -> Any:
        value = extract(message)
        number = parse_number(value)
        return value if number is None else number * factor

    return extract_in_unit
