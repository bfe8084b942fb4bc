"""The skills of robot files as skills of a scenario, so that its kit has their behaviors and features."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from understudy.addons.robots.robot_file import RobotFile
from understudy.errors import SettingError, join_names
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario.skill_schema import SkillStandIn


def add_robot_skills(scenario: Scenario, files: Iterable[RobotFile]) -> Scenario:
    """Add the skills of robot files to their types in a scenario.

    SettingError is raised if the scenario has a skill of this name with other parameters or feedback.
    """
    types = dict(scenario.types)
    for file in files:
        kind = file.kind or next(iter(types))
        skills = dict(types[kind].skills)
        for name, spec in file.skills.items():
            fields = [field.replace(".", "_") for field in spec.feedback]
            stand_in = SkillStandIn(
                parameters=tuple(spec.parameters),
                feedback=dict.fromkeys(fields, "number"),
                timeout_s=spec.timeout_s,
                doc=spec.doc,
            )
            there = skills.setdefault(name, stand_in)
            for what in ("parameters", "feedback"):
                here, expected = set(getattr(stand_in, what)), set(getattr(there, what))
                if here != expected:
                    raise SettingError(
                        where=f"robot {file.name!r}", setting=f"skills.{name}",
                        problem=f"has the {what} {join_names(sorted(here)) or 'none'}, and "
                        f"{join_names(sorted(expected)) or 'none'} in the scenario {scenario.name}",
                        remedy="give both the same",
                    )  # fmt: skip
        if skills != types[kind].skills:
            types[kind] = msgspec.structs.replace(types[kind], skills=skills)
    return msgspec.structs.replace(scenario, types=types)
