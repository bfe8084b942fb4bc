"""The part of a robot file about skills: actions and services of ROS 2 that become basic behaviors."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite

from msgspec import field

from understudy.sim.scenario.squad_schema import StrictStruct
from understudy.sim.scenario.toml_decode import DecodeProblem

INTERFACE = re.compile(r"[a-z]\w*/(action|srv)/[A-Z]\w*", re.ASCII)
NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
FIELD = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", re.ASCII)
OF_TARGET = re.compile(r"([A-Z])\.(\w+)", re.ASCII)
"""A value that is taken from the target of a parameter, such as A.x."""
COORDINATES = ("x", "y")
LONGEST_S = 3600.0
"""The longest time limit of a skill, in s."""


class SkillSpec(StrictStruct, frozen=True, kw_only=True):
    """A skill: the `action` or `service` of the robot, its type, and the fields of its goal or request.

    `goal` maps fields, paths of names with dots, to constants and to coordinates of targets: "A.x" is x of the target
    that the parameter A is bound to. Fields that are left out are 0, empty or false. `feedback` lists fields of an
    action's feedback that become readings. A goal that has not ended after `timeout_s` is cancelled. Set `moves` if
    the robot drives by itself meanwhile.
    """

    action: str | None = None
    service: str | None = None
    type: str
    goal: Mapping[str, bool | int | float | str] = field(default_factory=dict)
    feedback: tuple[str, ...] = ()
    timeout_s: float = 60.0
    moves: bool = False
    doc: str = ""

    @property
    def parameters(self) -> Sequence[str]:
        """The parameters of the basic behavior, in alphabetical order."""
        matches = (OF_TARGET.fullmatch(value) for value in self.goal.values() if isinstance(value, str))
        return sorted({match[1] for match in matches if match is not None})

    @property
    def endpoint(self) -> str:
        """The name of the action or service."""
        return self.action or self.service or ""


def find_skill_problems(key: str, name: str, skill: SkillSpec) -> Iterator[DecodeProblem]:
    """Yield problems in the description of a skill that do not depend on its message type."""
    if not NAME.fullmatch(name):
        yield DecodeProblem(key, "is not a valid name of a skill", "give letters, digits and _")
    if (skill.action is None) == (skill.service is None):
        yield DecodeProblem(key, "has to have either `action` or `service`", "give one of the two")
    match = INTERFACE.fullmatch(skill.type)
    wanted, example = (
        ("srv", "std_srvs/srv/Trigger")
        if skill.action is None
        else ("action", "nav2_msgs/action/NavigateToPose")
    )
    if match is None or match[1] != wanted:
        what = "a service" if skill.action is None else "an action"
        problem = f"is {skill.type!r:.60}, which is not the type of {what}"
        yield DecodeProblem(f"{key}.type", problem, f"give one as {example}")
    for path, value in skill.goal.items():
        at = f"{key}.goal.{path}"
        if not FIELD.fullmatch(path):
            yield DecodeProblem(at, "is not a path of fields", "give names with dots between them")
        of = OF_TARGET.fullmatch(value) if isinstance(value, str) else None
        if of is not None and of[2] not in COORDINATES:
            yield DecodeProblem(
                at, f"is {value!r}, and a target has no {of[2]}", f"give {of[1]}.x or {of[1]}.y"
            )
        if isinstance(value, float) and not isfinite(value):
            yield DecodeProblem(at, f"is {value}", "give a finite number")
    if skill.feedback and skill.action is None:
        yield DecodeProblem(f"{key}.feedback", "is given for a service, which has none", "leave it out")
    if not 0 < skill.timeout_s <= LONGEST_S:
        problem = f"is {skill.timeout_s:g}"
        yield DecodeProblem(f"{key}.timeout_s", problem, f"give a number above 0, up to {LONGEST_S:g}")
