"""Live teaching of a behavior of the repertoire until it holds: the teacher goes on where it went wrong in new worlds.

Success is the goal of the behavior as the experiment measures it, by true positions. In a world where that is not
reached, the teacher watches the robots at all levels from the beginning on, and opens the automaton that first does
something else than it should.

    python -m understudy_lab.behavior_suite.keep_going 4600000 3 wall_left triangle
"""

from __future__ import annotations

import json
import sys
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np

from understudy.addons.checks.falsification.holding_test import HoldingTest
from understudy.addons.checks.falsification.new_worlds import Mistake, NewWorldsResult
from understudy.addons.checks.falsification.open_failure import TeachingMoment
from understudy.judging.rollout import Progress, skip_progress
from understudy.model.features import Percept
from understudy.model.library import Library
from understudy.runtime.body import list_reading_keys
from understudy.runtime.interpreter import Interpreter, StackFrame
from understudy.runtime.link import IDLE_PROGRAM, link
from understudy.runtime.run_loop import Run
from understudy.training.feature_values import collect_own_values, compute_feature_values
from understudy.training.trainee import Mode, SessionView
from understudy_lab.behavior_suite.study import FEATS
from understudy_lab.behavior_suite.task import BehaviorTask, TaskTrial, make_taught_controller, share_done
from understudy_lab.teachers.live_teacher import MOST_LOOKS, Expectations, LiveTeacher
from understudy_lab.teachers.person import KEEP
from understudy_lab.teachers.teacher import LessonPlan, Situation

FIRST_TESTED, FOR_TESTS = 2**42, 100_000
"""The first seed of the worlds in which behaviors are tested, and the number of seeds for each teaching."""
UNSEEN = 200
"""The number of worlds in which the behavior is judged in the end."""
LASTS = 3
"""The number of wrong ticks after which the teacher looks closer at the robot."""
FIDGETS, FIDGETING_TICKS = 6, 20
"""The number of mistakes within a number of ticks after which the robot is paused and corrected."""


@dataclass(frozen=True)
class TaskWorlds:
    """New worlds of a task, in which its behavior is judged by the goal of the task.

    Parameters
    ----------
    task
        The task, which binds the parameters of each robot.
    seeds
        The seed of each world.
    """

    task: BehaviorTask
    seeds: Sequence[int]

    def run(
        self,
        library: Library,
        behavior: str,
        binding: Mapping[str, str],
        *,
        progress: Progress = skip_progress,
    ) -> NewWorldsResult:
        """Run a behavior on all robots; a mistake is not timed, since the goal is judged at the end."""
        trial = self.task.trial(self.seeds)
        seconds = trial.judge(make_taught_controller(trial, library, behavior)).seconds
        progress(len(self.seeds), len(self.seeds))
        failed = np.flatnonzero(np.isnan(seconds)).tolist()
        mistakes = [Mistake(self.seeds[row], binding, 0.0, f"not: {self.task.measured}") for row in failed]
        return NewWorldsResult(~np.isnan(seconds), seconds, tuple(mistakes))


@dataclass(frozen=True)
class Complaint:
    """A moment at which an automaton does something else than it should: the robot, the automaton's level, the world.

    `states` are the run states of all robots. `wanted` is the state that it should be in. `wished` is the state to show
    while the robot is paused, where it switches too quickly to be pressed in time; None: it is watched.
    """

    agent: int
    level: int
    body: bytes
    states: Sequence[Sequence[StackFrame]]
    wanted: str
    wished: str | None = None


class PersistentTeacher(LiveTeacher):
    """A teacher of a task who goes on where its behavior goes wrong, until it holds."""

    def __init__(self, task: BehaviorTask, seed: int) -> None:
        super().__init__(Library(task.kit), task.practice, seed, options=task.options)
        self._task, self._batches = task, dict[int, Sequence[int]]()
        self.tested = HoldingTest(self._make_worlds, FIRST_TESTED + FOR_TESTS * seed)

    def _make_worlds(self, seeds: Sequence[int]) -> TaskWorlds:
        self._batches.update(dict.fromkeys(seeds, seeds))
        return TaskWorlds(self._task, seeds)

    def watch_whole_world(self, behavior: str, mistake: Mistake) -> None:
        """Watch the robots of a world in which the goal was not reached, and press at the first thing that is wrong.

        A robot that would never get on is what one sees first. Where nothing is seen that is clearly wrong, the
        behavior is watched again, and shown again where it differs from what the teacher would do.
        """
        ends = {name: Expectations(self._plan_way_out(topic)) for name, topic in self._topics.items()}
        again = {name: Expectations(topic) for name, topic in self._topics.items()}
        looks = [(self._expected, self._expected), (again, again)]
        for seen, shown in [(ends, self._expected), *looks] if self._task.dead_ends else looks:
            before = self.presses
            self._look_through(behavior, mistake, seen, shown)
            if self.presses > before:
                return

    def _plan_way_out(self, topic: LessonPlan) -> LessonPlan:
        """Return a topic in which nothing but dead ends is wrong."""
        wish = self._task.dead_ends.get(topic.name, wish_nothing)
        return replace(topic, show=wish_nothing, complain=wish, complain_live=None, settle=None)

    def _look_through(
        self,
        behavior: str,
        mistake: Mistake,
        seen: Mapping[str, Expectations],
        shown: Mapping[str, Expectations],
    ) -> None:
        """Watch a world from its beginning, until a press was needed or nothing came of looking closer.

        `seen` is what one complains of from afar, `shown` is by what one directs when looking closer.
        """
        seeds = self._batches[mistake.seed]
        trial = self._task.trial(seeds)
        first = seeds.index(mistake.seed) * len(trial.bindings)
        mine = {first + robot: binding for robot, binding in enumerate(trial.bindings)}
        programs = {agent: link(self.library, behavior, binding) for agent, binding in mine.items()}
        drivers = [Interpreter(programs.get(agent, IDLE_PROGRAM)) for agent in range(trial.world.agents)]
        before = self.presses
        for complaint in islice(self._list_complaints(trial, drivers, list(mine), seen), MOST_LOOKS):
            if seen is not shown:  # what is seen from afar would not be seen closer
                complaint = replace(complaint, wished=complaint.wanted)
            self._look_closer(trial, drivers, complaint, behavior, mine[complaint.agent], shown)
            if self.presses > before:
                return

    def _list_complaints(
        self,
        trial: TaskTrial,
        drivers: Sequence[Interpreter],
        mine: Sequence[int],
        expected: Mapping[str, Expectations],
    ) -> Iterator[Complaint]:
        """Run a world to its end, and yield the moments at which an automaton begins to do something wrong."""
        world, keys = trial.world, list_reading_keys(trial.world)
        run, own = Run(world, list(drivers)), dict[tuple[int, str], Expectations]()
        begun: dict[tuple[int, str], tuple[int, str, str, Complaint]] = {}
        times: dict[tuple[int, str], deque[int]] = {}
        for tick in range(round(trial.seconds / world.tick_s)):
            percept = world.sense(keys)
            for agent in mine:
                for level, view in self._list_views(trial, drivers[agent], agent, percept):
                    key = agent, drivers[agent].active[level].automaton.name
                    wished = own.setdefault(key, expected[key[1]].begin_again()).wish(view)
                    last, wrong = begun.get(key), None
                    at_once = last is not None and tick == last[0] + 1 and view.state not in last[1:3]
                    if last is not None and at_once and expected is not self._expected:
                        wrong = replace(
                            last[3], wished=last[2]
                        )  # it switched to another state than it should
                    if wished is None or wished in (KEEP, view.state):
                        begun.pop(key, None)
                    elif last is None or last[1:3] != (view.state, wished):
                        begun[key] = (
                            tick,
                            view.state,
                            wished,
                            Complaint(agent, level, *_capture(trial, drivers), wished),
                        )
                        often = times.setdefault(key, deque(maxlen=FIDGETS))
                        often.append(tick)
                        if len(often) == FIDGETS and tick - often[0] <= FIDGETING_TICKS:
                            often.clear()
                            wrong = replace(begun[key][3], wished=wished)
                    elif tick - last[0] == LASTS:
                        wrong = last[3]
                    if wrong is not None:
                        here = _capture(trial, drivers)
                        yield wrong
                        _restore(trial, drivers, *here)
            run.tick()

    def _list_views(
        self, trial: TaskTrial, driver: Interpreter, agent: int, percept: Percept
    ) -> Iterator[tuple[int, SessionView]]:
        """Yield what a session of each running automaton would show, innermost first."""
        now = trial.world.time_s
        for level, machine in reversed(list(enumerate(driver.active))):
            targets, automaton = dict(machine.instance.binding), machine.automaton
            lesson = self.library.taught[automaton.name].lesson
            yield (
                level,
                SessionView(
                    time_s=now,
                    mode=Mode.LIVE,
                    state=machine.state_name,
                    path=driver.path[level:],
                    flag=machine.flag,
                    features=compute_feature_values(
                        automaton.features,
                        collect_own_values(machine, now),
                        targets,
                        percept,
                        trial.world,
                        agent,
                    ),
                    states=automaton.state_names,
                    targets=targets,
                    waiting=None,
                    examples=0 if lesson is None else sum(each.is_from_press for each in lesson.examples),
                    undoable=None,
                    redoable=None,
                ),
            )

    def _look_closer(
        self,
        trial: TaskTrial,
        drivers: Sequence[Interpreter],
        complaint: Complaint,
        behavior: str,
        binding: Mapping[str, str],
        expected: Mapping[str, Expectations],
    ) -> None:
        """Open the automaton that does something wrong, at that moment, and watch it."""
        _restore(trial, drivers, complaint.body, complaint.states)
        machine = drivers[complaint.agent].active[complaint.level]
        name, targets = machine.automaton.name, dict(machine.instance.binding)
        lesson = self.library.taught[name].lesson
        if lesson is None:
            return
        moment = TeachingMoment(
            trial.world,
            trial.world,
            complaint.agent,
            name,
            lesson,
            self.library,
            targets,
            tuple(complaint.states[complaint.agent][complaint.level :]),
            behavior,
            binding,
            drivers,
        )
        session = moment.open_session()
        self._expected[name] = expected[name].begin_again()
        self._expected[name].begin_situation(None)
        if complaint.wished is not None:
            self._person.press_paused(session, complaint.wished)
        ends = replace(
            self._topics[name],
            finished=lambda screen: screen.flag is not None or screen.time_s >= trial.seconds,
        )
        self._see(ends, session, Situation("", targets))


def wish_nothing(screen: SessionView) -> str | None:
    """Return None: the robot may go on."""
    return None


def _capture(
    trial: TaskTrial, drivers: Sequence[Interpreter]
) -> tuple[bytes, Sequence[Sequence[StackFrame]]]:
    """Return the present moment of a world and its robots."""
    return trial.world.snapshot(), [driver.snapshot(trial.world.time_s) for driver in drivers]


def _restore(
    trial: TaskTrial,
    drivers: Sequence[Interpreter],
    body: bytes,
    states: Sequence[Sequence[StackFrame]],
) -> None:
    """Go back to a moment of a world and its robots."""
    trial.world.restore(body)
    for driver, levels in zip(drivers, states, strict=True):
        driver.restore(levels, now=trial.world.time_s)


def measure_keep_going(task: BehaviorTask, seed: int) -> dict[str, Any]:
    """Teach a behavior live, go on until it holds, and judge it in unseen worlds before and after."""
    teacher, behavior = PersistentTeacher(task, seed), task.behavior
    teacher.teach(*task.topics)
    taught, presses = teacher.library, teacher.presses
    result = teacher.go_on(task.topics[-1], teacher.tested, [{}], watch=teacher.watch_whole_world)
    return {
        "behavior": task.name,
        "seed": seed,
        "presses": presses,
        "more_presses": teacher.presses - presses,
        "versions": teacher.tested.versions,
        "verdict": result.verdict.value,
        "held": result.held,
        "worlds": result.worlds,
        "success_before": judge(task, taught, behavior, seed),
        "success": judge(task, teacher.library, behavior, seed),
    }


def judge(task: BehaviorTask, library: Library, behavior: str, seed: int) -> float:
    """Return the share of unseen worlds in which a behavior reaches the task's goal; no two teachings share one."""
    trial = task.trial(range(UNSEEN * seed, UNSEEN * (seed + 1)))
    return share_done(trial.judge(make_taught_controller(trial, library, behavior)))


def main(first: str, count: str, *names: str) -> None:
    """Print a row for each behavior and each of some seeds."""
    for name in names or FEATS:
        for seed in range(int(first), int(first) + int(count)):
            sys.stdout.write(json.dumps(measure_keep_going(FEATS[name], seed)) + "\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
