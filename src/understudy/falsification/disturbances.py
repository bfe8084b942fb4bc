"""The noise, dropout and losses of a scenario that a search can make stronger or weaker, within limits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from msgspec.structs import replace

from understudy.sim.scenario.schema import Scenario

FACTOR = 2.0
"""The strongest disturbance that is tried, in multiples of the scenario's."""

MOST_SHARE = 0.95
"""The largest probability that is tried: readings that are never there tell nothing."""

MOTION = ("noise_drive", "noise_turn")
PROBABILITIES = ("dropout", "misses", "ghosts")
NOISES = ("noise", "noise_x", "noise_size", "noise_range", "noise_deg")
RADIO = ("delay_s", "loss")


@dataclass(frozen=True, slots=True)
class Disturbance:
    """A noise or probability of a scenario, from 0 to `most`.

    `type` and `sensor` say which type of robots and which of its sensors has it; None for the robot's motion, and for
    the radio.
    """

    type: str | None
    sensor: int | None
    field: str
    usual: float
    most: float

    @property
    def name(self) -> str:
        """The key of the disturbance in the scenario."""
        if self.type is None:
            return f"radio.{self.field}"
        return (
            f"types.{self.type}."
            + (f"sensors[{self.sensor}]." if self.sensor is not None else "")
            + self.field
        )

    @property
    def default(self) -> float:
        """The number from 0 to 1 that means what the scenario has."""
        return self.usual / self.most


def list_disturbances(scenario: Scenario) -> Iterator[Disturbance]:
    """Yield the disturbances that a scenario has; those that are 0 stay so."""
    for name, kind in scenario.types.items():
        for word in MOTION:
            yield from _find_disturbance(kind, name, None, word)
        for index, sensor in enumerate(kind.sensors):
            for word in (*NOISES, *PROBABILITIES):
                yield from _find_disturbance(sensor, name, index, word)
    for word in RADIO:
        yield from _find_disturbance(scenario.radio, None, None, word)


def _find_disturbance(part: Any, kind: str | None, sensor: int | None, word: str) -> Iterator[Disturbance]:
    usual = float(getattr(part, word, 0.0))
    if usual > 0.0:
        is_share = word in PROBABILITIES or word == "loss"
        most = max(usual, min(FACTOR * usual, MOST_SHARE)) if is_share else FACTOR * usual
        yield Disturbance(kind, sensor, word, usual, most)


def apply_disturbances(scenario: Scenario, strengths: Mapping[Disturbance, float]) -> Scenario:
    """Return a scenario with these disturbances, each at a strength from 0 to 1 of the most."""
    for disturbance, strength in strengths.items():
        value = {disturbance.field: disturbance.most * strength}
        if disturbance.type is None:
            scenario = replace(scenario, radio=replace(scenario.radio, **value))
            continue
        kind = scenario.types[disturbance.type]
        if disturbance.sensor is None:
            kind = replace(kind, **value)
        else:
            sensors = list(kind.sensors)
            sensors[disturbance.sensor] = replace(sensors[disturbance.sensor], **value)
            kind = replace(kind, sensors=tuple(sensors))
        scenario = replace(scenario, types={**scenario.types, disturbance.type: kind})
    return scenario
