"""The readings of a body of the user's own as text, in place of a picture of its world."""

from __future__ import annotations

from math import isnan

from rich.text import Text

from understudy.model.features import format_reading_label
from understudy.model.plain_names import format_names
from understudy.model.value_kinds import Categorical
from understudy.runtime.body import Reading, list_reading_keys
from understudy.sim.body_world import BodyWorld

DIM = "dim"
NAME_WIDTH = 18
ABSENT = "–"


def render_body_readings(body: BodyWorld, agent: int, *, lines: int) -> Text:
    """Render all readings of an agent, as far as there are lines, and say that there is no drawing."""
    reading_of = {reading.name: reading for reading in body.readings}
    text = Text.assemble(("No drawing here. Readings:\n" if lines > 2 else "", DIM))
    keys = list_reading_keys(body)
    listed = keys[: max(0, lines - 2)]
    percept = body.sense(listed)
    for key in listed:
        label = format_names(format_reading_label(key))
        value = float(percept[key][agent])
        text.append(f"{label:<{NAME_WIDTH}.{NAME_WIDTH}} ")
        text.append(f"{format_reading(reading_of[key[0]], value)}\n", "bold")
    if len(listed) < len(keys):
        text.append(f"and {len(keys) - len(listed)} more", DIM)
    return text


def format_reading(reading: Reading, value: float) -> str:
    """Format a value of a reading with its unit; a dash if it is absent."""
    if isnan(value):
        return ABSENT
    if isinstance(reading.kind, Categorical):
        return reading.kind.labels[int(value)]
    unit = f" {reading.unit}" if reading.unit else ""
    return f"{value:.2f}{unit}".replace("-", "−")
