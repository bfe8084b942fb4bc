"""Checks of studies, and of baselines."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import msgspec
import numpy as np

from understudy.judging.baseline import Baseline
from understudy.judging.study import Row, Study, StudyFindings, StudyPlan, Task
from understudy.runtime.body import list_reading_keys
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World
from understudy.testing.laws import LawBroken, require, require_call
from understudy.testing.random_drive import TICKS, are_same, check_column, copy_percept


def check_study(study: Study) -> None:
    """Check that a study can be run in pieces and again: its quick version is run in this process.

    Tasks, rows and findings must be JSON data, and tasks all different. The quick tasks must be among those of the
    whole study. A task must give the same row again, except for what varies. The findings and the figure must follow
    from the rows alone.

    Parameters
    ----------
    study
        The study.

    Raises
    ------
    LawBroken
        If the study breaks a rule.
    """
    require(isinstance(study, Study), "study", "it is a Study", f"it is a {type(study).__name__}")
    part = f"study {study.name!r}"
    require(bool(study.question), part, "it says which question it answers", "it has no question")
    law = "its quick version has some of its seeds"
    require(0 < study.quick <= len(study.seeds), part, law, f"it has {study.quick} of {len(study.seeds)}")
    quick = _list_tasks(part, study, StudyPlan(study.seeds[: study.quick], quick=True))
    whole = {_encode(part, task) for task in _list_tasks(part, study, StudyPlan(study.seeds))}
    others = [task for task in quick if _encode(part, task) not in whole]
    require(not others, part, "the quick tasks are among those of the whole study", f"{others[:1]} is not")
    rows = [_work(part, study, task) for task in quick]
    again = _work(part, study, quick[0])
    fixed = [{key: each[key] for key in each if key not in study.varies} for each in (rows[0], again)]
    law = "a task gives the same row again"
    require(fixed[0] == fixed[1], part, law, f"{quick[0]} gave {fixed[0]} and {fixed[1]}")
    before = _encode(part, rows)
    findings = require_call(part, "findings follow from the rows", lambda: study.conclude(rows))
    law = "it concludes StudyFindings"
    require(isinstance(findings, StudyFindings), part, law, f"it concluded {findings!r:.60}")
    _encode(part, findings)
    for table in findings.tables:
        law = "a row of a table has a text for each column"
        widths = {len(each) for each in table.rows}
        require(widths <= {len(table.columns)}, part, law, f"{table.title!r} has rows of {sorted(widths)}")
    figure = require_call(part, "a figure follows from the rows", lambda: study.draw(rows))
    from matplotlib.figure import Figure

    require(isinstance(figure, Figure), part, "it draws a figure of Matplotlib", f"it drew {figure!r:.60}")
    require(_encode(part, rows) == before, part, "it leaves the rows as they are", "it changed them")


def _list_tasks(part: str, study: Study, plan: StudyPlan) -> Sequence[Task]:
    tasks = require_call(part, "it has tasks for a plan", lambda: study.tasks(plan))
    encoded = [_encode(part, task) for task in tasks]
    law = "the tasks of a plan are all different"
    require(0 < len(encoded) == len(set(encoded)), part, law, f"{len(set(encoded))} of {len(encoded)} are")
    return tasks


def _work(part: str, study: Study, task: Task) -> Row:
    row = require_call(part, "each task gives a row", lambda: study.work(task))
    encoded = _encode(part, {"task": task, **row})
    decoded: Row = msgspec.json.decode(encoded)
    return decoded


def _encode(part: str, data: object) -> bytes:
    law = "tasks, rows and findings are JSON data"
    return require_call(part, law, lambda: msgspec.json.encode(data, order="sorted"))


def check_baseline(
    find: Callable[[Scenario], Baseline | None],
    scenario: Scenario,
    *,
    seeds: Sequence[int] = (0, 1, 2),
    ticks: int = TICKS,
) -> None:
    """Check the baseline of a scenario: it drives the robots of some worlds.

    Its time limits must be finite float64, one for each world. Its controller must read only what the world has,
    leave the readings unchanged, and command channels of the world with finite float64 columns.

    Parameters
    ----------
    find
        The function from a scenario to its baseline, or None.
    scenario
        A scenario for which there is a baseline.
    seeds
        Seeds of the worlds.
    ticks
        Number of ticks for which they are driven.

    Raises
    ------
    LawBroken
        If the baseline breaks a rule.
    """
    part = f"baseline {getattr(find, '__name__', find)!r}"
    other = msgspec.structs.replace(scenario, name="scenario of another package")
    require_call(part, "it takes every scenario", lambda: find(other))
    baseline = require_call(part, "it takes every scenario", lambda: find(scenario))
    law = f"it returns a Baseline for {scenario.name!r}"
    if not isinstance(baseline, Baseline):
        raise LawBroken(part=part, law=law, found=f"it returned {baseline!r:.60}")
    world = World(baseline.scenario, seeds)
    limits = require_call(part, "it has a time limit for each world", lambda: baseline.limits_s(world))
    check_column(f"{part}, limits_s", limits, len(seeds), None)
    require(bool((np.asarray(limits) > 0).all()), part, "time limits are above 0", f"they are {limits}")
    controller = require_call(
        part, "it makes a controller of a World", lambda: baseline.make_controller(world)
    )
    strange = sorted(set(controller.keys) - set(list_reading_keys(world)), key=str)
    require(not strange, part, "its controller reads what the world has", f"it reads {strange}")
    channels = {channel.name for channel in world.channels}
    for _ in range(ticks):
        percept = world.sense(controller.keys)
        before = copy_percept(percept)
        decide = partial(controller.decide, percept)
        commands = require_call(part, "it decides on every percept", decide)
        kept = all(are_same(percept[key], before[key]) for key in before)
        require(kept, part, "it leaves the readings it is given untouched", "it changed them")
        unknown = sorted(set(commands) - channels)
        law = "it commands channels of the world"
        require(not unknown, part, law, f"it commands {unknown} where there are {sorted(channels)}")
        for channel, column in commands.items():
            check_column(f"{part}, channel {channel!r}", column, world.agents, None)
        world.act(commands)
