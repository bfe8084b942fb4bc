"""What skills add to a kit and to a body: a basic behavior, and readings of how its last goal ended."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product

from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Binding
from understudy.model.value_kinds import BOOLEAN, Continuous
from understudy.runtime.body import ISSUED, SKILL, Channel, Reading
from understudy.sim.scenario.schema import RobotType, Scenario
from understudy.sim.scenario.skill_schema import SkillStandIn

SUCCEEDED, ABORTED, REJECTED, TIMED_OUT = OUTCOMES = ("succeeded", "aborted", "rejected", "timed_out")
"""The outcomes of a goal; each is a reading NAME_OUTCOME, true from the end of a goal until the next one starts."""
MEANINGS = {
    SUCCEEDED: "The last goal of {} was reached.",
    ABORTED: "The last goal of {} was given up by the robot.",
    REJECTED: "The last goal of {} was not accepted.",
    TIMED_OUT: "The last goal of {} took too long and was cancelled.",
}
SKILL_CHANNELS = (
    Channel(SKILL, doc="The number of the skill that it carries out, with its targets; 0 for none."),
    Channel(ISSUED, unit="s", doc="When the state that carries it out was entered; anew, it starts again."),
)
UNITS = {"distance": "m", "time": "s", "number": ""}


def name_outcome_reading(skill: str, outcome: str) -> str:
    """Return the name of the reading of an outcome, such as go_to_succeeded."""
    return f"{skill}_{outcome}"


def list_skill_readings(robot_type: RobotType) -> Iterator[tuple[str, Reading]]:
    """List the readings of a type's skills, each with the name of its skill."""
    for name, skill in robot_type.skills.items():
        for outcome in OUTCOMES:
            doc = MEANINGS[outcome].format(name)
            yield name, Reading(name_outcome_reading(name, outcome), BOOLEAN, doc=doc)
        for last, meaning in skill.feedback.items():
            doc = f"{last.replace('_', ' ').capitalize()}, as {name} reports it."
            yield name, Reading(f"{name}_{last}", Continuous(), UNITS[meaning], doc=doc)


def make_skill_behavior(name: str, skill: SkillStandIn, *, number: int) -> Behavior:
    """Make the basic behavior that carries out a skill.

    Its command is the number of the skill, from 1, for programs that know nothing of targets. Bodies have numbers of
    their own, for each skill with each of its targets.
    """
    doc = skill.doc or f"Carry out the skill {name.replace('_', ' ')}."
    return Behavior(name, Command(skill=float(number)), doc=doc, parameters=tuple(skill.parameters))


def list_skill_calls(scenario: Scenario) -> Mapping[tuple[str, Binding], int]:
    """List all skills of a scenario's types with all targets of their parameters, with numbers from 1."""
    skills = {name: skill for kind in scenario.types.values() for name, skill in kind.skills.items()}
    calls = [
        (name, Binding(dict(zip(skill.parameters, targets, strict=True))))
        for name, skill in skills.items()
        for targets in product(scenario.targets, repeat=len(skill.parameters))
    ]
    return {call: number for number, call in enumerate(calls, 1)}


def has_skills(scenario: Scenario) -> bool:
    """Return whether any type of a scenario has skills."""
    return any(kind.skills for kind in scenario.types.values())
