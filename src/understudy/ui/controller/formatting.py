"""Formatting of values and examples for display: units, angles in degrees with a sign, one line each."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, inf, isnan, nan, radians
from pathlib import Path

from understudy.errors import KindError
from understudy.model.change_summary import ChangeSummary
from understudy.model.describe import ABSENT, around_zero, format_values, is_angle
from understudy.model.features import BoundFeature
from understudy.model.lesson import Example, ExampleKind
from understudy.model.value_kinds import Categorical
from understudy.training.trainee import SessionView

MOST_SAID = 2
"""How many regressions the message of a save names."""
SPARKS = "▁▂▃▄▅▆▇█"


def parse_displayed_value(bound: BoundFeature, text: str) -> float:
    """Parse a value as it is displayed, with or without its unit."""
    plain = text.strip().replace("−", "-")
    if plain in ("", ABSENT):
        return nan
    if isinstance(bound.kind, Categorical):
        if plain not in bound.kind.labels:
            remedy = f"give {' or '.join(bound.kind.labels)}, or nothing if it is absent"
            raise KindError(
                where=str(bound), problem=f"{text.strip()!r} is not one of its values", remedy=remedy
            )
        return float(bound.kind.labels.index(plain))
    try:
        number = float(plain.removesuffix("°" if is_angle(bound) else bound.feature.unit))
    except ValueError:
        remedy = "give a number, or nothing if it is absent"
        raise KindError(
            where=str(bound), problem=f"{text.strip()!r} is not a number", remedy=remedy
        ) from None
    return radians(number) if is_angle(bound) else number


def format_example(example: Example) -> str:
    """Format an example: "forward → done", or "forward stays"."""
    return f"{example.state} stays" if example.state == example.next else f"{example.state} → {example.next}"


def format_recorded_press(examples: Sequence[Example], features: Sequence[BoundFeature]) -> str:
    """Format the examples of one press: "forward → rotate_left, angle_to(A) = 31°, with its default"."""
    first = examples[0]
    parts = [f"{first.state} confirmed" if first.kind is ExampleKind.CONFIRMATION else format_example(first)]
    if features:
        parts.append(format_values(features, first.values))
    if any(example.kind is ExampleKind.DEFAULT for example in examples):
        parts.append("with its default")
    return ("correction: " if first.correction else "") + ", ".join(parts)


def format_switch(name: str, before: SessionView, after: SessionView, *, driving: bool) -> str:
    """Describe a switch without an example, such as a raised flag; "" if there is nothing to say."""
    if before.state == after.state:
        return ""
    if before.waiting is not None:
        return (
            f"{before.state} → {after.state}; nothing recorded: {name} had ended with {before.state}. The next press "
            f"teaches again. To change when it ends, go back to before {before.state}"
        )
    if after.flag is None or driving:
        return ""
    return f"{name} raised {after.flag}. If that is right, try another world; if not, press the right state"


def format_speed(times: float) -> str:
    """Format a speed: "4 × real time"."""
    if times == inf:
        return "As fast as possible"
    return "Real time" if times == 1 else f"{times:g} × real time"


def format_minutes(seconds: float) -> str:
    """Format minutes and seconds: "0:48.3"."""
    tenths = round(seconds * 10)
    return f"{tenths // 600}:{tenths // 10 % 60:02d}.{tenths % 10}"


def format_sparkline(bound: BoundFeature, numbers: Sequence[float], width: int) -> str:
    """Draw the last values as small bars: angles from −180° to 180°, others between their extremes."""
    values = list(numbers)[-width:]
    if is_angle(bound):
        values = [float("nan") if isnan(number) else float(around_zero(degrees(number))) for number in values]
    present = [number for number in values if not isnan(number)]
    low, high = (-180.0, 180.0) if is_angle(bound) else (min(present, default=0.0), max(present, default=0.0))
    if isinstance(bound.kind, Categorical):
        low, high = 0.0, float(len(bound.kind.labels) - 1)
    return "".join(" " if isnan(number) else _bar(number, low, high) for number in values).rjust(width)


def _bar(number: float, low: float, high: float) -> str:
    part = 0.0 if high <= low else (number - low) / (high - low)
    return SPARKS[min(int(part * len(SPARKS)), len(SPARKS) - 1)]


def format_targets(view: SessionView) -> str:
    """Format the targets of the parameters: "(A = station)", or nothing."""
    inside = ", ".join(f"{parameter} = {target}" for parameter, target in view.targets.items())
    return f"({inside})" if inside else ""


def format_saved_message(
    path: Path,
    worse: tuple[str, ...],
    others: tuple[str, ...] = (),
    changed: ChangeSummary | None = None,
) -> str:
    """Say that the automaton is saved, what no longer holds or else what changed, and what others saved meanwhile."""
    if others:
        return "; ".join((format_saved_message(path, worse, changed=changed), *others))
    if not worse:
        return f"Saved in {path}" + ("" if changed is None else f". Since it was last saved: {changed}")
    more = (
        f"; and {len(worse) - MOST_SAID} more, which `understudy test` lists"
        if len(worse) > MOST_SAID
        else ""
    )
    return f"Saved in {path}, but something that worked no longer does: {'; '.join(worse[:MOST_SAID])}{more}"
