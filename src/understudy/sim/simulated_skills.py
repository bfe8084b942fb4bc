"""Stand-ins for skills in simulated worlds: they take their time, and end as the scenario says."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import hypot, isnan, nan, tau
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.errors import UnknownName
from understudy.model.binding import Binding
from understudy.model.features import ReadingKey
from understudy.model.value_kinds import Column
from understudy.runtime.body import ISSUED, SKILL, Commands
from understudy.sim.kernels.angles import compute_angle
from understudy.sim.kernels.rng import draw_uniform_column
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario.skill_schema import SkillStandIn
from understudy.sim.skill_parts import (
    ABORTED,
    OUTCOMES,
    REJECTED,
    SUCCEEDED,
    TIMED_OUT,
    list_skill_calls,
    name_outcome_reading,
)
from understudy.sim.target_lookup import Place, find_target_place

if TYPE_CHECKING:
    from understudy.sim.world import World

NUMBER, SINCE, BEGAN, TICKS, LASTS, SUCCEEDS, RUNS = range(7)
"""The columns of a robot's memory: number of the skill, when its state was entered, tick at which it began, ticks until
it would succeed, ticks until it ends, and whether it succeeds and still runs."""
STREAM = 1 << 30
"""The first stream of random draws, which no sensor and no placement uses: duration, success, and time of an abort."""


class SkillStandIns:
    """The skills of all robots of a world, whose state is in columns of the world's `memory` from `first` on.

    All that it needs is in the arrays of the world, so that worlds are stored, restored and copied with their skills.
    """

    def __init__(self, scenario: Scenario, *, first: int) -> None:
        self._first, self._tick_s = first, scenario.tick_s
        self._calls = list_skill_calls(scenario)
        self._names = list(self._calls)
        self._types = tuple(scenario.types.values())
        self._targets = tuple(scenario.targets)
        skills = dict.fromkeys(name for name, _ in self._calls)
        self._outcomes = {name: first + RUNS + 1 + index for index, name in enumerate(skills)}
        fed = dict.fromkeys(
            (name, each)
            for kind in self._types
            for name in kind.skills
            for each in kind.skills[name].feedback
        )
        start = first + RUNS + 1 + len(skills)
        self._feedback = {key: start + index for index, key in enumerate(fed)}
        self.columns = RUNS + 1 + len(skills) + len(fed) if skills else 0
        """The number of columns of memory that it needs."""
        self._readings: dict[str, tuple[str, int, float]] = {
            name_outcome_reading(name, outcome): (name, column, float(code))
            for name, column in self._outcomes.items()
            for code, outcome in enumerate(OUTCOMES)
        } | {f"{name}_{field}": (name, column, nan) for (name, field), column in self._feedback.items()}

    def index(self, name: str, binding: Mapping[str, str]) -> int:
        """Return the number of a skill with targets, from 1; UnknownName if there is none."""
        if name not in self._outcomes:
            raise UnknownName(what="skill", name=name, where="the scenario", known=list(self._outcomes))
        return self._calls[name, Binding(binding)]

    def is_reading(self, key: ReadingKey) -> bool:
        """Return whether a reading is one of a skill."""
        return key[0] in self._readings

    def sense(self, world: World, name: str) -> Column:
        """Return a reading of all robots: NaN for those without the skill, and for those that failed."""
        skill, column, code = self._readings[name]
        memory = world.state.memory[:, column]
        values = memory.copy() if isnan(code) else np.where(memory == code, 1.0, 0.0)
        has = np.array([skill in kind.skills for kind in self._types])[world.state.robots["type"]]
        values[~has | (world.state.robots["frozen"] != 0)] = nan
        return values

    def begin(self, world: World, commands: Commands) -> None:
        """Start and end skills by the commands of a tick."""
        zeros = np.zeros(world.agents)
        numbers, issued = (np.asarray(commands.get(name, zeros)) for name in (SKILL, ISSUED))
        for agent, number in enumerate(numbers.astype(int).tolist()):
            memory = self._memory(world, agent)
            if not number:
                memory[[NUMBER, RUNS]] = nan, 0.0
            elif memory[NUMBER] != number or memory[SINCE] != issued[agent]:
                self._start(world, agent, number, float(issued[agent]))

    def list_running(self, world: World) -> Iterator[int]:
        """Yield the robots that carry out a skill."""
        runs = world.state.memory[:, self._first + RUNS] == 1.0
        yield from np.flatnonzero(runs & (world.state.robots["frozen"] == 0)).tolist()

    def advance(self, world: World, agent: int) -> None:
        """Carry on a robot's skill by one tick, after the robots have moved."""
        memory, (name, skill) = self._memory(world, agent), self._find(world, agent)
        done = int(world.state.tick[agent // world.robots] - memory[BEGAN])
        place = self._find_end(world, agent, skill)
        if place is not None:
            left = max(int(memory[TICKS]) - done, 0)
            _move_to(world.state.robots[agent], place, share=1.0 / (left + 1), within=skill.within)
        row = world.state.robots[agent]
        for field, meaning in skill.feedback.items():
            distance = nan if place is None else hypot(place[0] - row["x"], place[1] - row["y"])
            value = {"time": done * self._tick_s, "distance": distance}.get(meaning, nan)
            world.state.memory[agent, self._feedback[name, field]] = value
        if done >= memory[LASTS]:
            self._end(world, agent, SUCCEEDED if memory[SUCCEEDS] else ABORTED)
        elif done * self._tick_s >= skill.timeout_s:
            self._end(world, agent, TIMED_OUT)

    def _start(self, world: World, agent: int, number: int, issued: float) -> None:
        memory = self._memory(world, agent)
        memory[[NUMBER, SINCE, RUNS]] = number, issued, 0.0
        name, _ = self._names[number - 1]
        if name not in self._types[world.state.robots["type"][agent]].skills:
            return  # a robot of another type stands still
        name, skill = self._find(world, agent)
        world.state.memory[agent, self._outcomes[name]] = nan
        for field in skill.feedback:
            world.state.memory[agent, self._feedback[name, field]] = nan
        if skill.ends is not None and self._find_end(world, agent, skill) is None:
            self._end(world, agent, REJECTED)
            return
        least, most = skill.duration_s if isinstance(skill.duration_s, tuple) else (skill.duration_s,) * 2
        of, robot = agent // world.robots, int(world.state.robots["id"][agent])
        tick = int(world.state.tick[of])
        duration, chance, part = (
            float(
                draw_uniform_column(
                    world.state.seeds[of : of + 1], item=robot, tick=tick, stream=STREAM + each
                )[0]
            )
            for each in range(3)
        )
        ticks = max(1, round((least + duration * (most - least)) / self._tick_s))
        succeeds = chance < skill.success
        memory[[BEGAN, TICKS, SUCCEEDS, RUNS]] = tick, ticks, float(succeeds), 1.0
        memory[LASTS] = ticks if succeeds else max(1, round(part * ticks))

    def _end(self, world: World, agent: int, outcome: str) -> None:
        memory = self._memory(world, agent)
        memory[RUNS] = 0.0
        name, _ = self._names[int(memory[NUMBER]) - 1]
        world.state.memory[agent, self._outcomes[name]] = OUTCOMES.index(outcome)

    def _memory(self, world: World, agent: int) -> Any:
        return world.state.memory[agent, self._first : self._first + RUNS + 1]

    def _find(self, world: World, agent: int) -> tuple[str, SkillStandIn]:
        """Return the skill that a robot carries out, by name and as its type has it."""
        name, _ = self._names[int(self._memory(world, agent)[NUMBER]) - 1]
        return name, self._types[world.state.robots["type"][agent]].skills[name]

    def _find_end(self, world: World, agent: int, skill: SkillStandIn) -> Place | None:
        if skill.ends is None:
            return None
        _, binding = self._names[int(self._memory(world, agent)[NUMBER]) - 1]
        return find_target_place(world, binding.get(skill.ends, skill.ends), agent)


def _move_to(robot: Any, place: Place, *, share: float, within: float) -> None:
    """Move a robot by a share of the straight line to a place, less the distance at which it ends, and face it."""
    dx, dy = place[0] - robot["x"], place[1] - robot["y"]
    distance = hypot(dx, dy)
    if distance <= within:
        return
    step = share * (distance - within) / distance
    robot["x"] += step * dx
    robot["y"] += step * dy
    robot["heading"] = compute_angle(dy, dx) % tau % tau
    robot["aim"] = nan
