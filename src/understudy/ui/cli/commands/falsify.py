"""Command `understudy falsify`: look for worlds in which a behavior fails, and keep one, as simple as possible."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NoReturn

import typer

from understudy.addons.checks.falsification.failing_world import SCENARIO_FILE, choose_folder
from understudy.addons.checks.falsification.falsify import Falsification, falsify, keep_failure
from understudy.addons.checks.falsification.property_measure import (
    PropertyMeasure,
    choose_property,
    make_success_measure,
)
from understudy.addons.checks.falsification.search_space import ASPECTS
from understudy.errors import SettingError
from understudy.jit.settings import compile_on_first_call
from understudy.judging.properties.property_file import FILE, load_properties
from understudy.judging.properties.run_property import check_property, make_property_task
from understudy.sim.catalog import find_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.ui.cli import INTERRUPTED
from understudy.ui.cli.commands.falsify_output import (
    FalsifyResult,
    describe_failure,
    describe_falsification,
    show_falsification,
    show_search,
)
from understudy.ui.cli.falsify_options import FalsifyOptions, SearchOptions
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.named_inputs import RunAssignment, assign_run, find_kit
from understudy.ui.cli.options import WORLD

if TYPE_CHECKING:
    from understudy.addons.checks.falsification.trial import TrialMeasure
    from understudy.model.property import Property


def falsify_behavior(options: FalsifyOptions) -> None:
    """Look for worlds in which a behavior misses its goal, or a property fails; keep one, as simple as possible."""
    check_settings(options)
    subject = find_tested_property(options)
    named = options.world or (WORLD if subject is None else subject.start.world)
    report_search(falsify_in_scenario(options, find_scenario(named), named, subject), as_json=options.as_json)


def report_search(result: FalsifyResult, *, as_json: bool) -> NoReturn:
    """Print what was found, and end with the exit code that says whether a world failed."""
    if as_json:
        print_json(describe_falsification(result))
    else:
        show_falsification(result)
    raise typer.Exit(1 if result.failure is not None else INTERRUPTED if result.found.interrupted else 0)


def falsify_in_scenario(
    options: FalsifyOptions, where: Scenario, named: str, subject: Property | None
) -> FalsifyResult:
    """Search for a failing world of a scenario, and keep it."""
    bind = options.bind or []
    if subject is not None:
        bind = [*(f"{parameter}={target}" for parameter, target in subject.targets.items()), *bind]
    assigned = assign_run(where, options.behavior, options.library, find_kit(options.kit, named), bind)
    measure = _make_measure(assigned, where, options.limit_s, subject)
    compile_on_first_call()
    with show_search(quiet=options.as_json) as report:
        found = falsify(
            measure,
            where,
            seed=options.seed,
            seconds=options.seconds,
            worlds=options.worlds,
            jobs=options.jobs,
            vary=options.vary or ASPECTS,
            report=report,
        )
    failure = _keep(found, measure, assigned, options, world=named, bind=bind)
    return FalsifyResult(assigned.behavior, where.name, measure.get_limit(where), found, failure)


def check_settings(options: SearchOptions) -> None:
    """Refuse settings that cannot be used, before anything runs."""

    def refuse(option: str, problem: str, remedy: str) -> SettingError:
        return SettingError(where="falsify", setting=option, problem=problem, remedy=remedy)

    if not 0 < options.seconds < float("inf"):
        raise refuse("--seconds", f"is {options.seconds:g}", "give a time in s")
    if options.worlds is not None and not 1 <= options.worlds <= 1_000_000_000:
        raise refuse("--worlds", f"is {options.worlds}", "give a number from 1 to 1000000000")
    for name in (isinstance(options, FalsifyOptions) and options.vary) or ():
        if name not in ASPECTS:
            raise refuse("--vary", f"is {name!r:.60}", f"give {', '.join(ASPECTS[:-1])} or {ASPECTS[-1]}")
    if options.out.exists() and not options.out.is_dir():
        raise refuse("--out", f"is the file {options.out}", "name a folder")


def find_tested_property(options: FalsifyOptions) -> Property | None:
    """Return the property that is to fail, or None if the goal is."""
    if options.tested is None:
        return None
    file = options.library / FILE
    return choose_property(load_properties(file), options.tested, behavior=options.behavior, file=str(file))


def _make_measure(
    assigned: RunAssignment, where: Scenario, limit_s: float | None, subject: Property | None
) -> TrialMeasure:
    """Make what runs the behavior and judges it; everything that it names is checked here."""
    measure: TrialMeasure
    if subject is None:
        name = f"{assigned.sort}/{assigned.behavior}"
        measure = make_success_measure(
            assigned.libraries, name, where, binding=assigned.binding, limit_s=limit_s
        )
    else:
        task = make_property_task(subject, assigned.libraries, where)
        check_property(subject, task, where)
        measure = PropertyMeasure(task, limit_s, subject=subject)
    if not measure.get_limit(where) >= where.tick_s:
        problem = f"is {measure.get_limit(where):g} s, less than a tick"
        raise SettingError(
            where="falsify", setting="--limit", problem=problem, remedy=f"give at least {where.tick_s:g} s"
        )
    return measure


def _keep(
    found: Falsification,
    measure: TrialMeasure,
    assigned: RunAssignment,
    options: FalsifyOptions,
    *,
    world: str,
    bind: Sequence[str],
) -> dict[str, Any] | None:
    """Explain the failing world and write it to a new folder; describe it for `--json`. None: no world failed."""
    shrinking = found.shrinking
    if shrinking is None or found.found_by is None:
        return None
    folder, seed = choose_folder(options.out, assigned.behavior), shrinking.trial.seed
    words = ["understudy", "run", str(folder / SCENARIO_FILE), "--behavior", assigned.behavior]
    words += ["--library", str(options.library), "--seed", str(seed)]
    words += [] if options.kit is None else ["--kit", options.kit]
    words += [word for pair in bind for word in ("--bind", pair)]
    kept = keep_failure(
        folder,
        shrinking,
        measure,
        assigned.libraries,
        assigned.roots,
        about=f"{assigned.behavior} fails here with seed {seed}; found in {world} by a {found.found_by} search.",
        command=shlex.join(words),
        found_by=found.found_by,
    )
    return describe_failure(kept, shlex.join(words))
