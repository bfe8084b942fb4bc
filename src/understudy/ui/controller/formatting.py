"""How the trainer speaks of values and examples: units, angles in degrees with a sign, one line each."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import degrees, inf, isnan, nan, radians

from understudy.errors import KindError
from understudy.model.features import BoundFeature
from understudy.model.kinds import Categorical, Toroidal
from understudy.model.lesson import Example, ExampleKind
from understudy.training.session_view import Screen

SPARKS = "▁▂▃▄▅▆▇█"
ABSENT = "–"
_DIGITS = {"m": 2, "s": 1}
_DEGREES = re.compile(r"(\d+(?:\.\d+)?)°")


def is_angle(bound: BoundFeature) -> bool:
    """Whether its values are angles, said in degrees: left of ahead above 0, right below."""
    return isinstance(bound.kind, Toroidal) and bound.feature.unit == "rad"


def value(bound: BoundFeature, number: float, *, unit: bool = True) -> str:
    """A value with its unit: 3.42 m, −31°, yes; a dash where it is absent."""
    if isnan(number):
        return ABSENT
    if isinstance(bound.kind, Categorical):
        return bound.kind.labels[int(number)]
    if is_angle(bound):
        text = f"{_around_zero(round(degrees(number))):d}°"
    else:
        name = bound.feature.unit
        digits = _DIGITS.get(name, 0 if float(number).is_integer() else 2)
        text = f"{number:.{digits}f}{f' {name}' if name and unit else ''}"
    return text.replace("-", "−")


def number(bound: BoundFeature, text: str) -> float:
    """A value as it is said, with its unit or without: the other way round."""
    said = text.strip().replace("−", "-")
    if said in ("", ABSENT):
        return nan
    if isinstance(bound.kind, Categorical):
        if said not in bound.kind.labels:
            remedy = f"give {' or '.join(bound.kind.labels)}, or nothing where it is absent"
            raise KindError(
                where=str(bound), problem=f"{text.strip()!r} is none of its values", remedy=remedy
            )
        return float(bound.kind.labels.index(said))
    try:
        found = float(said.removesuffix("°" if is_angle(bound) else bound.feature.unit))
    except ValueError:
        remedy = "give one, or nothing where it is absent"
        raise KindError(where=str(bound), problem=f"{text.strip()!r} is no number", remedy=remedy) from None
    return radians(found) if is_angle(bound) else found


def _around_zero(angle: float) -> int:
    return int((angle + 179) % 360 - 179)


def signed(text: str) -> str:
    """A condition whose angles are said like the readings: "between 350° and 10°" is between −10° and 10°."""

    def turned(match: re.Match[str]) -> str:
        angle = float(match[1])
        return f"{angle - 360 if angle > 180 else angle:g}°".replace("-", "−")

    return _DEGREES.sub(turned, text)


def values(features: Sequence[BoundFeature], numbers: Sequence[float]) -> str:
    """Labels and values: "distance_to(A) = 3.42 m, angle_to(A) = −31°"."""
    return ", ".join(
        f"{bound} = {value(bound, number)}" for bound, number in zip(features, numbers, strict=True)
    )


def step(example: Example) -> str:
    """What an example says: "forward → done", or "forward stays"."""
    return f"{example.state} stays" if example.state == example.next else f"{example.state} → {example.next}"


def recorded(examples: Sequence[Example], features: Sequence[BoundFeature]) -> str:
    """What one press showed: "forward → rotate_left, angle_to(A) = 31°, with its default"."""
    first = examples[0]
    parts = [f"{first.state} confirmed" if first.kind is ExampleKind.CONFIRMATION else step(first)]
    if features:
        parts.append(values(features, first.values))
    if any(example.kind is ExampleKind.DEFAULT for example in examples):
        parts.append("with its default")
    return ("correction: " if first.correction else "") + ", ".join(parts)


def speed(times: float) -> str:
    """How fast the world goes: 4 times as fast as in life."""
    if times == inf:
        return "As fast as it goes"
    return "As fast as in life" if times == 1 else f"{times:g} times as fast as in life"


def clock(seconds: float) -> str:
    """Minutes and seconds: 0:48.3."""
    tenths = round(seconds * 10)
    return f"{tenths // 600}:{tenths // 10 % 60:02d}.{tenths % 10}"


def spark(bound: BoundFeature, numbers: Sequence[float], width: int) -> str:
    """The last values as little bars; angles from −180° to 180°, others between their least and most."""
    shown = list(numbers)[-width:]
    if is_angle(bound):
        shown = [float("nan") if isnan(number) else float(_around_zero(degrees(number))) for number in shown]
    present = [number for number in shown if not isnan(number)]
    low, high = (-180.0, 180.0) if is_angle(bound) else (min(present, default=0.0), max(present, default=0.0))
    if isinstance(bound.kind, Categorical):
        low, high = 0.0, float(len(bound.kind.labels) - 1)
    return "".join(" " if isnan(number) else _bar(number, low, high) for number in shown).rjust(width)


def _bar(number: float, low: float, high: float) -> str:
    part = 0.0 if high <= low else (number - low) / (high - low)
    return SPARKS[min(int(part * len(SPARKS)), len(SPARKS) - 1)]


def standing(screen: Screen) -> str:
    """What the parameters stand for: "(A = station)", or nothing."""
    inside = ", ".join(f"{parameter} = {target}" for parameter, target in screen.targets.items())
    return f"({inside})" if inside else ""
