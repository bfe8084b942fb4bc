"""Mode `understudy falsify` on a body of the user's own: seeds at random, and the run that fails is recorded."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from understudy.errors import SettingError
from understudy.ui.cli.commands.falsify_output import (
    FailureResult,
    FalsifyResult,
    make_random_result,
    show_search,
)

if TYPE_CHECKING:
    from understudy.adapters.body_maker import BodyMaker
    from understudy.analysis.evaluation_task import EvaluationTask
    from understudy.robots.recording.header import RunInfo
    from understudy.ui.cli.options import RunAssignment

RECORDING_FILE = "run.mcap"


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyFalsifyOptions:
    """Options of a falsification on a body of the user's own."""

    library: Path
    behavior: str
    tested: str | None
    seconds: float
    worlds: int | None
    seed: int
    limit_s: float | None
    goal: str | None
    vary: Sequence[str] | None
    jobs: int
    out: Path
    bind: Sequence[str]
    kit: str | None
    quiet: bool


def falsify_body(options: BodyFalsifyOptions, maker: BodyMaker) -> FalsifyResult:
    """Search for a seed with which the behavior fails; record and explain the run."""
    from understudy.analysis.evaluate import make_evaluation_task
    from understudy.analysis.evaluation_task import EvaluationFailed
    from understudy.falsification.body_search import falsify_on_body
    from understudy.ui.cli.options import assign_run, find_kit, make_world_kit

    limit_s = _check_options(options, maker)
    kit = make_world_kit(maker) if options.kit is None else find_kit(options.kit, maker.name)
    assigned = assign_run(maker, options.behavior, options.library, kit, list(options.bind))
    task = make_evaluation_task(
        assigned.libraries[assigned.sort],
        assigned.behavior,
        maker,
        binding=assigned.binding,
        goal=options.goal,
        limit_s=limit_s,
    )
    try:
        with show_search(quiet=options.quiet) as report:
            found = falsify_on_body(
                task,
                seed=options.seed,
                seconds=options.seconds,
                worlds=options.worlds,
                jobs=options.jobs,
                report=report,
            )
    except EvaluationFailed as error:
        remedy = "let it run in the world of every seed"
        raise SettingError(
            where="falsify",
            setting=f"--world {maker.name}",
            problem=f"failed: {error.problem}",
            remedy=remedy,
        ) from error
    failure = None
    if found.random.failures:
        failure = _keep(found.random.failures[0][1], task, assigned, options, maker, limit_s)
    return FalsifyResult(
        behavior=assigned.behavior,
        world=maker.name,
        limit_s=limit_s,
        seconds=round(found.seconds, 3),
        interrupted=found.interrupted,
        random=make_random_result(found),
        directed=None,
        failure=failure,
        notes=found.notes,
    )


def _check_options(options: BodyFalsifyOptions, maker: BodyMaker) -> float:
    """Refuse what needs a scenario; return the time limit, s."""

    def refuse(option: str, problem: str, remedy: str) -> SettingError:
        return SettingError(where="falsify", setting=option, problem=problem, remedy=remedy)

    if options.tested is not None:
        problem = f"is {options.tested!r:.60}, and properties are those of scenarios"
        raise refuse("--property", problem, "name a flag or a reading with --goal")
    if options.vary:
        problem = f"is given, and {maker.name} makes a body whose worlds are known by their seeds only"
        raise refuse("--vary", problem, "leave it out")
    if options.limit_s is None:
        problem = f"is missing, and {maker.name} makes a body, which has none"
        raise refuse("--limit", problem, "give the time limit in s: --limit 20")
    if not 0 < options.limit_s < float("inf"):
        raise refuse("--limit", f"is {options.limit_s:g}", "give a time in s")
    return options.limit_s


def _keep(
    seed: int,
    task: EvaluationTask,
    assigned: RunAssignment,
    options: BodyFalsifyOptions,
    maker: BodyMaker,
    limit_s: float,
) -> FailureResult:
    """Run the failing world again, and write its recording and explanation to a new folder."""
    from understudy.extras import ExtraMissing
    from understudy.falsification.body_search import BodyMeasure
    from understudy.falsification.failing_world import WHY_FILE, choose_folder
    from understudy.falsification.falsify import AT_RANDOM
    from understudy.storage.atomic_write import convert_os_errors, write_atomically

    folder = choose_folder(options.out, assigned.behavior)
    with convert_os_errors(folder, "writing the failing world", remedy="name a folder that you may write to"):
        folder.mkdir(parents=True)
    recording: Path | None = folder / RECORDING_FILE
    try:
        why = _record(seed, task, assigned, options, maker, limit_s, recording)
    except ExtraMissing:  # it is explained all the same
        recording = None
        why = _record(seed, task, assigned, options, maker, limit_s, recording)
    if BodyMeasure(task)([seed])[0] >= 0:
        why = (*why, f"Run once more with seed {seed}, it did not fail: the seed does not decide everything.")
    settings = ["--library", str(options.library), "--seed", str(seed)]
    settings += [] if options.kit is None else ["--kit", options.kit]
    bound = [word for pair in options.bind for word in ("--bind", pair)]
    where = ["--world", maker.name]
    command = shlex.join(
        [
            "understudy",
            "run",
            *where,
            "--behavior",
            assigned.behavior,
            *settings,
            *bound,
            "--seconds",
            f"{limit_s:g}",
        ]
    )
    correct = shlex.join(["understudy", "teach", assigned.behavior, *where, *settings])
    lines = [f"{assigned.behavior} fails in {maker.name}, seed {seed}", "", *why]
    lines += ["", "Run it again:", f"  {command}", "Correct it:", f"  {correct}"]
    if recording is not None:
        explain = shlex.join(["understudy", "why", str(recording), "--time"])
        lines += ["Explain another moment, in s:", f"  {explain} 1.0"]
    with convert_os_errors(folder, "writing the failing world", remedy="name a folder that you may write to"):
        write_atomically(folder / WHY_FILE, "\n".join([*lines, ""]).encode())
    return FailureResult(
        folder=str(folder),
        scenario=None,
        seed=seed,
        found_by=AT_RANDOM,
        robustness=-1.0,
        wrong_s=None,
        steps=[],
        why=why,
        command=command,
        recording=None if recording is None else str(recording),
    )


def _record(
    seed: int,
    task: EvaluationTask,
    assigned: RunAssignment,
    options: BodyFalsifyOptions,
    maker: BodyMaker,
    limit_s: float,
    recording: Path | None,
) -> tuple[str, ...]:
    """Run a world to its end, recorded if there is a path for that; return why it failed."""
    from understudy.falsification.body_search import BodyReplay
    from understudy.runtime.body import close_body
    from understudy.ui.cli.commands.run_body import describe_body_run
    from understudy.ui.cli.recordings import record_ticks

    body = maker(seed)
    try:
        replay = BodyReplay(body, task, limit_s)

        def describe() -> RunInfo:
            return describe_body_run(
                task.program, assigned, world=maker.name, seed=seed, library=options.library, kit=options.kit
            )

        with record_ticks(recording, body, replay.tick, lambda: replay.paths, ran=describe) as tick:
            while not replay.is_over:
                tick()
        return replay.explain()
    finally:
        close_body(body)
