"""Command `understudy falsify-body`: look for seeds with which a body of the user's own fails, and record a run."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

from understudy.addons.bridges.environments.body_maker import find_world
from understudy.addons.checks.falsification.body_search import BodyMeasure, BodyReplay, falsify_on_body
from understudy.addons.checks.falsification.failing_world import WHY_FILE, choose_folder
from understudy.addons.checks.falsification.falsify import AT_RANDOM
from understudy.errors import SettingError
from understudy.extras import ExtraMissing
from understudy.judging.evaluate import make_evaluation_task
from understudy.judging.evaluation_task import EvaluationFailed, EvaluationTask
from understudy.runtime.body import close_body
from understudy.sim.scenario.schema import Scenario
from understudy.storage.atomic_write import convert_os_errors, write_atomically
from understudy.ui.cli.commands.falsify import check_settings, report_search
from understudy.ui.cli.commands.falsify_output import FalsifyResult, show_search
from understudy.ui.cli.falsify_options import FalsifyBodyOptions
from understudy.ui.cli.named_inputs import RunAssignment, assign_run, choose_kit
from understudy.ui.cli.recorded_runs import describe_body_run, record_ticks

if TYPE_CHECKING:
    from understudy.addons.bridges.environments.body_maker import BodyMaker
    from understudy.records.header import RunInfo

RECORDING_FILE = "run.mcap"


def falsify_own_body(options: FalsifyBodyOptions) -> None:
    """Look for seeds with which a behavior misses its goal on a body of your own, and record a run that fails."""
    check_settings(options)
    opened = find_world(options.world)
    if isinstance(opened, Scenario):
        problem, remedy = "makes a scenario", f"give it to understudy falsify: --world {options.world}"
        raise SettingError(where="falsify-body", setting=options.world, problem=problem, remedy=remedy)
    report_search(falsify_body(options, opened), as_json=options.as_json)


def falsify_body(options: FalsifyBodyOptions, maker: BodyMaker) -> FalsifyResult:
    """Search for a seed with which the behavior fails; record and explain the run."""
    limit_s = _find_limit(options, maker)
    kit = choose_kit(options.kit, maker)
    assigned = assign_run(maker, options.behavior, options.library, kit, options.bind)
    task = make_evaluation_task(
        assigned.libraries[assigned.sort],
        assigned.behavior,
        maker,
        binding=assigned.binding,
        goal=options.goal,
        limit_s=limit_s,
    )
    try:
        with show_search(quiet=options.as_json) as report:
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
    return FalsifyResult(assigned.behavior, maker.name, limit_s, found, failure)


def _find_limit(options: FalsifyBodyOptions, maker: BodyMaker) -> float:
    """Return the time limit, s; refuse one that is missing or no time."""

    def refuse(option: str, problem: str, remedy: str) -> SettingError:
        return SettingError(where="falsify", setting=option, problem=problem, remedy=remedy)

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
    options: FalsifyBodyOptions,
    maker: BodyMaker,
    limit_s: float,
) -> dict[str, Any]:
    """Run the failing world again, write its recording and explanation to a new folder, and describe it."""
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
    bound = [word for pair in options.bind or [] for word in ("--bind", pair)]
    where = ["--world", maker.name]
    words = ["understudy", "run", *where, "--behavior", assigned.behavior, *settings, *bound]
    command = shlex.join([*words, "--seconds", f"{limit_s:g}"])
    correct = shlex.join(["understudy", "teach", assigned.behavior, *where, *settings])
    lines = [f"{assigned.behavior} fails in {maker.name}, seed {seed}", "", *why]
    lines += ["", "Run it again:", f"  {command}", "Correct it:", f"  {correct}"]
    if recording is not None:
        explain = shlex.join(["understudy", "why", str(recording), "--time"])
        lines += ["Explain another moment, in s:", f"  {explain} 1.0"]
    with convert_os_errors(folder, "writing the failing world", remedy="name a folder that you may write to"):
        write_atomically(folder / WHY_FILE, "\n".join([*lines, ""]).encode())
    return {
        "folder": folder,
        "scenario": None,
        "seed": seed,
        "found_by": AT_RANDOM,
        "robustness": -1.0,
        "wrong_s": None,
        "steps": [],
        "why": why,
        "command": command,
        "recording": recording,
    }


def _record(
    seed: int,
    task: EvaluationTask,
    assigned: RunAssignment,
    options: FalsifyBodyOptions,
    maker: BodyMaker,
    limit_s: float,
    recording: Path | None,
) -> tuple[str, ...]:
    """Run a world to its end, recorded if there is a path for that; return why it failed."""
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
