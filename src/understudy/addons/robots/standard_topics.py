"""The parts of a robot's file for topics that most ROS 2 robots have: coordinate frames and diagnostics."""

from __future__ import annotations

from understudy.sim.scenario.squad_schema import StrictStruct


class FrameSpec(StrictStruct, frozen=True, kw_only=True):
    """The frames (REP 105) between which the robot's pose is read: the readings `x`, `y` and `heading`.

    They are the place and direction of the frame `robot` in the frame `fixed`. Transforms come on `topic`, and those
    that never change on `static`. The pose is as old as the oldest transform between the two frames, except for those
    on `static`. If older than `stale_s` it is absent; the robot then stops if it is `required`.
    """

    fixed: str = "map"
    robot: str = "base_link"
    topic: str = "/tf"
    static: str = "/tf_static"
    rate_hz: float | None = None
    stale_s: float = 0.5
    required: bool = False


class DiagnosticsSpec(StrictStruct, frozen=True, kw_only=True):
    """The robot's diagnostics (REP 107).

    With `publish`, the robot's state in Understudy is published there once a second. `unfit` and `stop` list names of
    statuses. While one of them has the level ERROR or STALE, the robot is not counted as a member of its squad; one of
    `stop` also stops it.
    """

    topic: str = "/diagnostics"
    publish: bool = False
    unfit: tuple[str, ...] = ()
    stop: tuple[str, ...] = ()
