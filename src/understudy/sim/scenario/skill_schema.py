"""Skills in scenarios: behaviors that a robot has already, such as driving to a place, and their stand-ins."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from msgspec import field

from understudy.sim.scenario.squad_schema import StrictStruct


class SkillStandIn(StrictStruct, frozen=True, kw_only=True):
    """A skill of a type of robots, as simulated worlds stand in for it.

    It lasts `duration_s`, a number or (least, most), and then succeeds with probability `success`, or else aborts. Its
    `parameters` are bound to targets. If it succeeds, the robot `ends` at the target of a parameter, or at a target of
    the scenario; it moves there on a straight line, through everything, and `within` is the distance from center to
    center at which it ends. If it aborts, it has gone a part of the way. `feedback` names readings: the "distance" that
    is left (m), the "time" since it started (s), or a "number" that only real robots know. After `timeout_s` it has
    timed out.
    """

    duration_s: float | tuple[float, float] = 5.0
    success: float = 1.0
    parameters: tuple[str, ...] = ()
    ends: str | None = None
    within: float = 0.0
    feedback: Mapping[str, Literal["distance", "time", "number"]] = field(default_factory=dict)
    timeout_s: float = 60.0
    doc: str = ""
