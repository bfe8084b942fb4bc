"""Command `understudy falsify`: look for worlds in which a behavior fails, and keep one, as simple as possible."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.errors import SettingError
from understudy.ui.cli.commands.falsify_output import (
    FalsifyResult,
    make_directed_result,
    make_failure_result,
    make_random_result,
    show_falsification,
    show_search,
)
from understudy.ui.cli.options import FAILURES, WORLD, Bind, Json, KitName

if TYPE_CHECKING:
    from understudy.falsification.failing_world import FailingWorld
    from understudy.falsification.falsify import Falsification
    from understudy.falsification.trial import TrialMeasure
    from understudy.model.property import Property
    from understudy.sim.scenario.schema import Scenario
    from understudy.ui.cli.options import RunAssignment


def falsify_behavior(
    library: Annotated[Path, typer.Argument(metavar="LIBRARY", help="Folder of the library.")],
    behavior: Annotated[str, typer.Argument(metavar="NAME", help="Name of the behavior.")],
    world: Annotated[
        str | None,
        typer.Option(
            "--world",
            "-w",
            metavar="SCENARIO",
            help=f"Scenario to search; that of the property, or {WORLD}, if left out.",
            show_default=False,
        ),
    ] = None,
    tested: Annotated[
        str | None,
        typer.Option(
            "--property",
            metavar="PROPERTY",
            help="Property of the library's file that is to fail, instead of the goal.",
            show_default=False,
        ),
    ] = None,
    seconds: Annotated[
        float, typer.Option("--seconds", metavar="S", help="Time to search, half of it at random, in s.")
    ] = 60.0,
    worlds: Annotated[
        int | None,
        typer.Option(
            "--worlds",
            metavar="N",
            help="Number of worlds to run at random, instead of half of the time.",
            show_default=False,
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the search.")] = 0,
    limit_s: Annotated[
        float | None,
        typer.Option(
            "--limit",
            metavar="SECONDS",
            help="Time limit of each world, in simulated s; the scenario's if left out.",
            show_default=False,
        ),
    ] = None,
    goal: Annotated[
        str | None,
        typer.Option(
            "--goal",
            metavar="NAME",
            help="Flag or reading (yes or no) that counts as success on a body of your own.",
            show_default=False,
        ),
    ] = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            "--vary",
            metavar="WHAT",
            help="What the directed search varies: places, sizes or disturbances; all if left out.",
            show_default=False,
        ),
    ] = None,
    jobs: Annotated[
        int, typer.Option("--jobs", "-j", metavar="N", min=1, help="Processes for the search at random.")
    ] = 1,
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="FOLDER", help="Folder that keeps failing worlds.")
    ] = FAILURES,
    bind: Bind = None,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Look for worlds in which a behavior misses its goal, or a property fails; keep one, as simple as possible.

    First it runs fresh worlds at random, and gives an exact interval of the share that fails. If none fails, it
    varies places, sizes and disturbances from the worlds that came closest to failing. A failing world is made
    simpler as long as it fails, and kept as a scenario with its seed, a picture, and the decision that went wrong.
    Ctrl-C ends the search; what was found is kept.

    On a body of your own (--world MODULE:NAME), all the time goes to seeds at random. The run that fails is recorded.

    The exit code is 1 if a world failed, 0 if none did, and 2 if something given cannot be used.

    [dim]understudy falsify demo/library forage --seconds 60[/]

    [dim]understudy falsify mine goto --world arena --bind A=red_flag --limit 60[/]

    [dim]understudy falsify demo/library forage --property keeps_clear[/]

    [dim]understudy falsify mine balance --world cart_pole:make --goal truncated --limit 11[/]
    """
    from understudy.falsification.search_space import ASPECTS
    from understudy.sim.scenario.schema import Scenario
    from understudy.ui.cli import INTERRUPTED
    from understudy.ui.cli.commands.falsify_body import BodyFalsifyOptions, falsify_body
    from understudy.ui.cli.options import open_world
    from understudy.ui.cli.output import print_json

    _check_settings(seconds, worlds, vary, ASPECTS, out)
    subject = None if tested is None else _find_property(library, behavior, tested)
    named = world or (WORLD if subject is None else subject.start.world)
    where = open_world(named)
    if isinstance(where, Scenario):
        _refuse_goal(goal)
        result = _falsify_in_scenario(
            library,
            behavior,
            where,
            named,
            subject,
            seconds=seconds,
            worlds=worlds,
            seed=seed,
            limit_s=limit_s,
            vary=vary or ASPECTS,
            jobs=jobs,
            out=out,
            bind=bind or [],
            kit=kit,
            quiet=as_json,
        )
    else:
        options = BodyFalsifyOptions(
            library=library,
            behavior=behavior,
            tested=tested,
            seconds=seconds,
            worlds=worlds,
            seed=seed,
            limit_s=limit_s,
            goal=goal,
            vary=vary,
            jobs=jobs,
            out=out,
            bind=bind or [],
            kit=kit,
            quiet=as_json,
        )
        result = falsify_body(options, where)
    if as_json:
        print_json(result)
    else:
        show_falsification(result)
    raise typer.Exit(1 if result.failure is not None else INTERRUPTED if result.interrupted else 0)


def _refuse_goal(goal: str | None) -> None:
    """Refuse a goal for a scenario, which has its own."""
    if goal is not None:
        problem = f"is {goal!r:.60}, and a scenario has a goal of its own"
        remedy = "leave it out, or name a property of the library's file with --property"
        raise SettingError(where="falsify", setting="--goal", problem=problem, remedy=remedy)


def _falsify_in_scenario(
    library: Path,
    behavior: str,
    where: Scenario,
    named: str,
    subject: Property | None,
    *,
    seconds: float,
    worlds: int | None,
    seed: int,
    limit_s: float | None,
    vary: Sequence[str],
    jobs: int,
    out: Path,
    bind: Sequence[str],
    kit: str | None,
    quiet: bool,
) -> FalsifyResult:
    """Search for a failing world of a scenario, and keep it."""
    from understudy.falsification.falsify import falsify
    from understudy.jit.settings import compile_on_first_call
    from understudy.ui.cli.options import assign_run, find_kit

    if subject is not None:
        bind = [*(f"{parameter}={target}" for parameter, target in subject.targets.items()), *bind]
    assigned = assign_run(where, behavior, library, find_kit(kit, named), list(bind))
    measure = _make_measure(assigned, where, limit_s, subject)
    compile_on_first_call()
    with show_search(quiet=quiet) as report:
        found = falsify(
            measure, where, seed=seed, seconds=seconds, worlds=worlds, jobs=jobs, vary=vary, report=report
        )
    failure = None
    if found.shrinking is not None:
        kept, command = _keep(found, measure, assigned, out, library, world=named, kit=kit, bind=bind)
        failure = make_failure_result(kept, command)
    return FalsifyResult(
        behavior=assigned.behavior,
        world=where.name,
        limit_s=measure.get_limit(where),
        seconds=round(found.seconds, 3),
        interrupted=found.interrupted,
        random=make_random_result(found),
        directed=make_directed_result(found),
        failure=failure,
        notes=found.notes,
    )


def _check_settings(
    seconds: float, worlds: int | None, vary: list[str] | None, known: Sequence[str], out: Path
) -> None:
    """Refuse settings that cannot be used, before anything runs."""

    def refuse(option: str, problem: str, remedy: str) -> SettingError:
        return SettingError(where="falsify", setting=option, problem=problem, remedy=remedy)

    if not 0 < seconds < float("inf"):
        raise refuse("--seconds", f"is {seconds:g}", "give a time in s")
    if worlds is not None and not 1 <= worlds <= 1_000_000_000:
        raise refuse("--worlds", f"is {worlds}", "give a number from 1 to 1000000000")
    for name in vary or ():
        if name not in known:
            raise refuse("--vary", f"is {name!r:.60}", f"give {', '.join(known[:-1])} or {known[-1]}")
    if out.exists() and not out.is_dir():
        raise refuse("--out", f"is the file {out}", "name a folder")


def _find_property(library: Path, behavior: str, name: str) -> Property:
    from understudy.falsification.property_measure import choose_property
    from understudy.properties.property_file import FILE, load_properties

    file = library / FILE
    return choose_property(load_properties(file), name, behavior=behavior, file=str(file))


def _make_measure(
    assigned: RunAssignment, where: Scenario, limit_s: float | None, subject: Property | None
) -> TrialMeasure:
    """Make what runs the behavior and judges it; everything that it names is checked here."""
    from understudy.falsification.property_measure import PropertyMeasure, make_success_measure
    from understudy.properties.run_property import check_property, make_property_task

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
    out: Path,
    library: Path,
    *,
    world: str,
    kit: str | None,
    bind: Sequence[str],
) -> tuple[FailingWorld, str]:
    """Explain the failing world and write it to a new folder; return it with the command that runs it."""
    from understudy.falsification.failing_world import (
        SCENARIO_FILE,
        FailureFacts,
        choose_folder,
        write_failing_world,
    )
    from understudy.falsification.failure_replay import compute_end_hash, replay_failure
    from understudy.falsification.joint_worlds import Trial
    from understudy.falsification.property_measure import PropertyMeasure
    from understudy.falsification.simpler_worlds import strip_for_file

    shrinking = found.shrinking
    if shrinking is None or found.found_by is None:
        raise TypeError("nothing to keep")
    folder = choose_folder(out, assigned.behavior)
    seed = shrinking.trial.seed
    about = f"{assigned.behavior} fails here with seed {seed}; found in {world} by a {found.found_by} search."
    scenario = strip_for_file(shrinking.trial.scenario, name=shrinking.trial.scenario.name, about=about)
    trial = Trial(scenario, seed)
    replay = replay_failure(
        measure, trial, assigned.libraries, assigned.roots, progress_s=shrinking.progress_s
    )
    words = ["understudy", "run", str(folder / SCENARIO_FILE), "--behavior", assigned.behavior]
    words += ["--library", str(library), "--seed", str(seed)]
    words += [] if kit is None else ["--kit", kit]
    words += [word for pair in bind for word in ("--bind", pair)]
    command = shlex.join(words)
    facts = FailureFacts(
        behavior=assigned.behavior,
        binding=dict(assigned.binding),
        seed=seed,
        limit_s=measure.get_limit(scenario),
        robustness=float(shrinking.results.robustness[0]),
        wrong_s=replay.wrong_s,
        end_hash=compute_end_hash(measure, trial),
        robot=replay.robot,
        property=measure.name_in_file if isinstance(measure, PropertyMeasure) else None,
        place=replay.place,
        states=replay.states,
        found_by=found.found_by,
        steps=tuple(shrinking.steps),
        why=replay.sentences,
    )
    return write_failing_world(folder, trial, facts, replay, command=command), command
