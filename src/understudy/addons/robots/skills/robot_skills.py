"""The skills of a robot: which one is carried out, and how the last goal of each ended."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from math import nan
from pathlib import Path
from threading import RLock
from typing import Any

import numpy as np

from understudy.addons.robots.robot_file import RobotFile
from understudy.addons.robots.ros.interfaces import Interfaces
from understudy.addons.robots.ros.message_readings import Extract, make_field_extractor
from understudy.addons.robots.ros.transport import Transport
from understudy.addons.robots.skill_file import SkillSpec
from understudy.addons.robots.skills.action_client import ActionClient
from understudy.addons.robots.skills.execution import CANCELLED, Execution
from understudy.addons.robots.skills.goal_fields import GoalFields, Locate, PlaceUnknown
from understudy.addons.robots.skills.service_client import ServiceClient
from understudy.errors import FileError, SettingError, UnknownName
from understudy.model.binding import Binding
from understudy.model.features import ReadingKey
from understudy.model.value_kinds import BOOLEAN, Continuous
from understudy.records.message_types import TEXT, encode_text, resolve_topic_name
from understudy.runtime.body import Reading
from understudy.sim.scenario.toml_decode import DecodeProblem
from understudy.sim.skill_parts import ABORTED, MEANINGS, OUTCOMES, REJECTED, TIMED_OUT, name_outcome_reading
from understudy.storage.json_text import encode_json

TOPIC = "understudy/skills"
"""The topic of records of skills, within the robot's namespace."""


class Skill:
    """A skill of a robot file, with the client of its action or service; FileError if it does not fit its type."""

    def __init__(
        self,
        name: str,
        file: RobotFile,
        interfaces: Interfaces,
        transport: Transport,
        path: Path | str,
        *,
        clock: Callable[[], float],
    ) -> None:
        self.name, self.spec = name, file.skills[name]
        spec, endpoint = self.spec, file.topic(self.spec.endpoint)
        if not interfaces.knows(spec.type):
            where = f"{file.definitions or 'definitions'}/{spec.type.replace('/', '/', 1)}"
            interface = spec.type.split("/")[1]
            problem, remedy = (
                f"is {spec.type!r:.60}, which is unknown",
                f"put its definition into {where}.{interface}",
            )
            if file.definitions is None:
                remedy = f'{remedy}, and write definitions = "definitions"'
            raise self._wrong(path, DecodeProblem("type", problem, remedy))
        self._extractors: dict[str, Extract] = {}
        self._client: ActionClient | ServiceClient
        if spec.action is not None:
            types = interfaces.find_action(spec.type)
            self.fields = GoalFields(spec, interfaces, types.goal)
            for place in spec.feedback:
                extractor = make_field_extractor(types.feedback, place, "", interfaces.list_fields)
                if isinstance(extractor, DecodeProblem):
                    raise self._wrong(path, DecodeProblem("feedback", extractor.problem, extractor.remedy))
                self._extractors[name_feedback_reading(name, place)] = extractor[2]
            self._client = ActionClient(
                endpoint, types, interfaces, transport, self._read_feedback, clock=clock
            )
        else:
            service = interfaces.find_service(spec.type)
            self.fields = GoalFields(spec, interfaces, service.request)
            self._client = ServiceClient(endpoint, service, interfaces, transport)
        if (problem_found := self.fields.find_problem()) is not None:
            raise self._wrong(path, problem_found)
        self.last = Execution(0.0)
        self.last.end(CANCELLED)

    @property
    def readings(self) -> Sequence[Reading]:
        """The readings of its outcome, then those of its feedback."""
        return make_skill_readings(self.name, self.spec)

    def find_problem(self) -> str:
        """Return why it cannot be carried out now; empty if it can."""
        return self._client.find_problem()

    def start(self, binding: Mapping[str, str], locate: Locate, now: float) -> Execution:
        """Send a goal; it is rejected at once if a target's place is unknown."""
        self.last = execution = Execution(now)
        try:
            goal = self.fields.make(binding, locate)
        except PlaceUnknown as error:
            execution.end(REJECTED, str(error))
        else:
            execution.goal = goal
            self._client.start(goal, execution, timeout_s=self.spec.timeout_s)
        return execution

    def cancel(self) -> None:
        """Cancel all its goals that may still run, also those whose answer was lost."""
        self._client.cancel()

    def repeat_cancellations(self) -> None:
        """Send requests to cancel goals again that were not answered; call this often."""
        self._client.repeat_cancellations()

    def list_values(self) -> dict[ReadingKey, float]:
        """Return a value for each of its readings; feedback is absent before the first message."""
        last = self.last
        values = {name_outcome_reading(self.name, each): float(last.outcome == each) for each in OUTCOMES}
        values |= {name: last.feedback.get(name, nan) for name in self._extractors}
        return {(name, None): value for name, value in values.items()}

    def _read_feedback(self, message: Any) -> Mapping[str, float]:
        return {name: extract(message) for name, extract in self._extractors.items()}

    def _wrong(self, path: Path | str, problem: DecodeProblem) -> FileError:
        place = f"skills.{self.name}.{problem.key}"
        return FileError(path=path, place=place, problem=problem.problem, remedy=problem.remedy)


class RobotSkills:
    """All skills of a robot, of which it carries out one at a time.

    Methods may be called from any thread. `locate` returns the place of a target, and `clock` the time in s.
    """

    def __init__(
        self,
        file: RobotFile,
        transport: Transport,
        *,
        path: Path | str,
        locate: Locate,
        clock: Callable[[], float],
    ) -> None:
        self._where, self._path, self._targets = f"robot {file.name!r}", Path(path), file.targets
        self._locate, self._clock = locate, clock
        self.skills: dict[str, Skill] = {}
        if file.skills:
            folder = None if file.definitions is None else self._path.parent / file.definitions
            interfaces = Interfaces(folder)
            for name in file.skills:
                self.skills[name] = Skill(name, file, interfaces, transport, path, clock=clock)
        self.readings = tuple(reading for each in self.skills.values() for reading in each.readings)
        self._records = SkillRecords(transport, file.namespace) if file.skills else None
        self._calls: list[tuple[str, Binding]] = []
        self._asked: tuple[int, float] | None = None
        self._running: tuple[Skill, Execution] | None = None
        self._lock = RLock()

    def index(self, name: str, binding: Mapping[str, str]) -> int:
        """Return the number of a skill with targets; refuse a target for whose place the robot file has no source."""
        if name not in self.skills:
            raise UnknownName(what="skill", name=name, where=self._where, known=list(self.skills))
        for target in (binding[parameter] for parameter in self.skills[name].spec.parameters):
            if target not in self._targets:
                raise SettingError(
                    where=self._where, setting=f"targets.{target}",
                    problem=f"is missing, and the skill {name} needs its place",
                    remedy=f"write at = [x, y] or a topic under [targets.{target}]",
                )  # fmt: skip
        call = (name, Binding(binding))
        if call not in self._calls:
            self._calls.append(call)
        return self._calls.index(call) + 1

    @property
    def drives(self) -> bool:
        """True while a skill runs that moves the robot."""
        running = self._running
        return running is not None and running[0].spec.moves and running[1].runs

    def will_drive(self, number: int, issued: float) -> bool:
        """Return whether the robot will be moved by a skill if this is asked for now."""
        if number and self._asked != (number, issued):
            return self._skill(number).spec.moves
        return self.drives

    def ask(self, number: int, issued: float) -> None:
        """Carry out skill `number`, or none (0); a goal is sent if the number or the time `issued` (s) is new."""
        with self._lock:
            request = (number, issued) if number else None
            if request == self._asked:
                self._repeat_cancellations()
                return
            self._end(CANCELLED, "its state was left")
            self._asked = request
            if request is not None:
                skill = self._skill(number)
                self._running = skill, skill.start(self._calls[number - 1][1], self._locate, self._clock())

    def stop(self, cause: str) -> None:
        """Cancel what runs, because the robot must not move: it counts as aborted, and is not started again."""
        with self._lock:
            self._end(ABORTED, cause)

    def values(self, now: float) -> dict[ReadingKey, float]:
        """Return a value for each reading at time `now` (s), and cancel what has taken too long.

        Requests to cancel goals are repeated, too, if they were not answered.
        """
        with self._lock:
            if self._running is not None:
                skill, execution = self._running
                if now - execution.began_s >= skill.spec.timeout_s:
                    self._end(TIMED_OUT, f"took longer than {skill.spec.timeout_s:g} s")
            self._repeat_cancellations()
        for each in self.skills.values():
            self._record(each)
        return {key: value for each in self.skills.values() for key, value in each.list_values().items()}

    def find_problems(self) -> Mapping[str, str]:
        """Find the skills that cannot be carried out now, each with the reason."""
        problems = {name: each.find_problem() for name, each in self.skills.items()}
        return {name: problem for name, problem in problems.items() if problem}

    def _end(self, outcome: str, cause: str) -> None:
        running, self._running = self._running, None
        if running is not None:
            running[1].end(outcome, cause)
        for each in self.skills.values():  # also goals whose answer was lost
            each.cancel()
        if running is not None:
            self._record(running[0])

    def _repeat_cancellations(self) -> None:
        for each in self.skills.values():
            each.repeat_cancellations()

    def _record(self, skill: Skill) -> None:
        """Publish the news of the last execution of a skill, if there was one."""
        if self._records is not None and (skill.last.goal is not None or skill.last.problem):
            self._records.publish_changes(skill.name, skill.last)

    def _skill(self, number: int) -> Skill:
        return self.skills[self._calls[number - 1][0]]


def name_feedback_reading(skill: str, field: str) -> str:
    """Return the name of the reading of a field of feedback, such as go_to_distance_remaining."""
    return f"{skill}_{field.replace('.', '_')}"


def make_skill_readings(name: str, skill: SkillSpec) -> Sequence[Reading]:
    """Make the readings of a skill: those of its outcome, then those of its feedback."""
    return (
        *(
            Reading(name_outcome_reading(name, each), BOOLEAN, doc=MEANINGS[each].format(name))
            for each in OUTCOMES
        ),
        *(Reading(name_feedback_reading(name, field), Continuous()) for field in skill.feedback),
    )


class SkillRecords:
    """The published state of a robot's skills, by which changes are found.

    Parameters
    ----------
    transport
        The transport to the robot; recordings keep what is published over it.
    namespace
        The robot's namespace.
    """

    def __init__(self, transport: Transport, namespace: str) -> None:
        self._publish = transport.publisher(resolve_topic_name(namespace, TOPIC), TEXT)
        self._told: dict[str, tuple[Execution, Mapping[str, float], str]] = {}

    def publish_changes(self, skill: str, execution: Execution) -> None:
        """Publish the changes of the last execution of a skill: its goal, its feedback, its outcome."""
        published, feedback, outcome = self._told.get(skill, (None, {}, ""))
        now = execution.feedback, execution.outcome
        if published is not execution:
            feedback, outcome = {}, ""
            if execution.goal is not None:
                self._write(skill, "goal", values=to_plain(execution.goal))
        if now[0] != feedback:
            self._write(skill, "feedback", values=dict(now[0]))
        if now[1] != outcome:
            self._write(skill, now[1], problem=execution.problem, values=to_plain(execution.result))
        self._told[skill] = (execution, *now)

    def _write(self, skill: str, step: str, **about: Any) -> None:
        record = {"skill": skill, "step": step, **{name: value for name, value in about.items() if value}}
        self._publish(encode_text(encode_json(record).decode()))


def to_plain(message: Any) -> Any:
    """Convert a ROS 2 message to objects, lists, numbers and texts; None stays None."""
    if is_dataclass(message):
        return {
            field.name: to_plain(getattr(message, field.name))
            for field in fields(message)
            if not field.name.startswith("_")
        }
    if isinstance(message, np.ndarray):
        return message.tolist()
    if isinstance(message, np.generic):
        return message.item()
    return [to_plain(each) for each in message] if isinstance(message, list) else message
