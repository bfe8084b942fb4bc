"""The reference of exports answers rows of readings as a run does, and refuses what that refuses."""

from __future__ import annotations

from collections.abc import Iterator
from math import nan

import numpy as np
import pytest
from tests.export.exports import draw_job, open_fixture
from tests.export.test_translation import BODY, LIBRARY

from understudy.addons.export.conformance import ReferenceRun, ReferenceTick, RowBody
from understudy.addons.export.export_automaton import prepare_export
from understudy.addons.export.single_precision import compute_in_single
from understudy.addons.export.target_files import ExportJob
from understudy.errors import UnderstudyError
from understudy.model.value_kinds import Categorical
from understudy.runtime.interpreter import RunningBehavior
from understudy.runtime.link import Program, link
from understudy.runtime.run_loop import Run


def link_job(job: ExportJob) -> Program:
    """The program that a job exports."""
    return link(job.library, job.hierarchy.name, job.hierarchy.binding)


def answer_by_run(job: ExportJob) -> Iterator[ReferenceTick]:
    """What a run of the same program answers to the rows of a job."""
    program = compute_in_single(link_job(job)) if job.single_precision else link_job(job)
    body = RowBody(program, job.hierarchy, single_precision=job.single_precision)
    run = Run.from_program(body, program)
    for tick, now in zip(job.conformance.ticks, list_times(job), strict=True):
        body.row, body.time_s = tick.readings, now
        if tick.starts:
            run.interpreters[0].start(now)
        with np.errstate(all="ignore"):
            commands = run.decide(body.sense(run.keys))
        active = run.interpreters[0].active
        running = active[-1].active
        assert isinstance(running, RunningBehavior)
        yield ReferenceTick(
            tuple(each.state for each in active),
            tuple(-1 if each.flag is None else job.hierarchy.flags.index(each.flag) for each in active),
            running.index,
            tuple(float(commands[each.name][0]) for each in job.hierarchy.channels),
        )


def list_times(job: ExportJob) -> list[float]:
    """The times of a job's rows in s; those in ms overflow once."""
    if not job.single_precision:
        return [tick.time for tick in job.conformance.ticks]
    times: list[float] = []
    for tick in job.conformance.ticks:
        overflows = bool(times) and not tick.starts and tick.time / 1000 < times[-1]
        times.append((tick.time + 2**32 * overflows) / 1000)
    return times


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_random_libraries(seed: int, single: bool) -> None:
    job = draw_job(seed, to="c99", single=single)
    assert list(answer_by_run(job)) == [tick.expected for tick in job.conformance.ticks]


@pytest.mark.parametrize("single", [False, True])
def test_functions_of_features_and_behaviors(single: bool) -> None:
    job = prepare_export(
        LIBRARY, "a", to="c99", binding={}, body=BODY, fingerprint="", single_precision=single
    )
    assert {tick.expected.basic for tick in job.conformance.ticks} == {0, 1}  # one of them is a function
    assert list(answer_by_run(job)) == [tick.expected for tick in job.conformance.ticks]


def refuse(job: ExportJob, row: list[float]) -> str:
    """What the reference says of a row, in the same words as a run."""
    program = link_job(job)
    body = RowBody(program, job.hierarchy)
    body.row = row
    run = Run.from_program(body, program)
    with pytest.raises(UnderstudyError) as by_run:
        run.decide(body.sense(run.keys))
    with pytest.raises(UnderstudyError) as by_reference:
        ReferenceRun(program, job.hierarchy).pulse(row, 0.0)
    assert str(by_reference.value) == str(by_run.value)
    return str(by_reference.value)


def test_a_value_outside_its_kind_is_refused() -> None:
    library, body = open_fixture()
    job = prepare_export(library, "forage", to="c99", binding={}, body=body, fingerprint="")
    absent = [nan] * len(job.hierarchy.readings)
    ReferenceRun(link_job(job), job.hierarchy).pulse(absent, 0.0)
    for slot, reading in enumerate(job.hierarchy.readings):
        for value in [7.0, 0.5, -1.0] if isinstance(reading.kind, Categorical) else []:
            assert "label" in refuse(job, [*absent[:slot], value, *absent[slot + 1 :]])
