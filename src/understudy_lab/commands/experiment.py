"""The command `understudy experiment`: run the published experiments again."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import typer
from rich.markup import escape

from understudy.errors import SettingError, UnderstudyError
from understudy.jit.settings import compile_on_first_call
from understudy.learning.tree_growth import compile_tree_kernels as prepare_learner
from understudy.sim.catalog import compile_world_kernels as prepare_world
from understudy.sim.catalog import find_scenario
from understudy.ui.cli.commands.eval import parse_seeds
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import make_console, make_table
from understudy.ui.cli.progress_bar import show_progress
from understudy_lab import figures, results
from understudy_lab.results import RowCache, StudyResult, differences, list_uncompared, load_published
from understudy_lab.runner import Part, find_missing_modules, gather, run, run_on_cluster
from understudy_lab.study import QUESTIONS, StudyPlan, find_experiment, list_questions

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.sim.scenario.schema import Scenario
    from understudy_lab.commands.options import ExperimentOptions
    from understudy_lab.study import Study

RESULTS = Path("results")
SHOWN = 12
"""The largest number of differences from the published result that is printed."""
SLOW_S = 2.0


def experiment(options: ExperimentOptions) -> None:
    """Run published experiments again, and compare."""
    if options.name == "list":
        _list(as_json=options.as_json)
        return
    is_all, quiet = options.name == "all", options.as_json
    chosen = None if options.seeds is None else parse_seeds(options.seeds)
    mine = None if options.part is None else Part.parse(options.part)
    _refuse_several(part=options.part, gather=options.gathers or None, cluster=options.cluster)
    parameters = _read_parameters(options.cluster_option or [])
    processes = options.jobs or os.cpu_count() or 1
    reports: dict[str, dict[str, Any]] = {}
    for each in QUESTIONS if is_all else [options.name]:
        study = find_experiment(each)
        try:
            study.check_machine()
        except UnderstudyError as error:
            if not is_all:
                raise
            reports[each] = {"skipped": str(error)}
            make_console(err=True).print(f"[yellow]Skipped:[/] {escape(str(error))}")
            continue
        folder = _choose_folder(each, options)
        published = study.seeds[: study.quick] if options.quick else study.seeds
        plan = StudyPlan(chosen or published, options.quick, options.data)
        if mine is not None:
            reports[each] = _run_part(study, plan, folder, mine, jobs=processes, quiet=quiet)
            continue
        if options.cluster is not None:
            _run_on_cluster(study, plan, folder, options.cluster, parameters, parts=processes, quiet=quiet)
        if options.gathers or options.cluster is not None:
            gather(study, plan, folder)
        result = _run(study, plan, folder, jobs=processes, quiet=quiet)
        wrong, unknown = _compared(result, study)
        reports[each] = {"result": result, "wrong": wrong, "uncompared": unknown, "passed": not wrong}
        if not quiet:
            _tell(result, wrong, unknown, folder, make_console())
    passed = all(each.get("passed", True) for each in reports.values())
    if quiet:
        print_json(reports | {"passed": passed} if is_all else reports[options.name])
    raise typer.Exit(0 if passed else 1)


def _choose_folder(name: str, options: ExperimentOptions) -> Path:
    """Choose the folder of the results of an experiment: that of --out, or one in it where all are run."""
    if options.out is not None and options.name != "all":
        return options.out
    return (options.out or RESULTS) / (f"{name}-quick" if options.quick else name)


def _list(*, as_json: bool) -> None:

    if as_json:
        rows = [{"name": name, "question": question} for name, question in list_questions().items()]
        print_json({"experiments": rows})
        return
    table = make_table("experiment", "~question")
    for row in list_questions().items():
        table.add_row(*row)
    make_console().print(table)


def _refuse_several(**options: object) -> None:
    """Refuse several ways to run an experiment at once."""
    chosen = [f"--{name}" for name, value in options.items() if value is not None]
    if len(chosen) > 1:
        raise SettingError(
            where="understudy experiment",
            setting=chosen[1],
            problem=f"is given with {chosen[0]}",
            remedy="give one of them",
        )


def _read_parameters(options: Sequence[str]) -> dict[str, str | int]:
    """Read parameters of the form KEY=VALUE."""
    parameters: dict[str, str | int] = {}
    for option in options:
        key, equals, value = option.partition("=")
        if not (key and equals):
            raise SettingError(
                where="understudy experiment",
                setting="--cluster-option",
                problem=f"is {option!r:.60}",
                remedy="give KEY=VALUE, such as timeout_min=240",
            )
        parameters[key] = int(value) if value.isdigit() else value
    return parameters


def _prepare(study: Study, *, quiet: bool) -> None:
    """Name optional modules that are missing, and compile kernels."""
    for module, install in find_missing_modules(study).items():
        skipped = f"[yellow]Skipped:[/] what needs {module}, which is not installed: {escape(install)}"
        make_console(err=True).print(skipped)
    compile_on_first_call()
    compile_once(learner=True, quiet=quiet)
    for world in study.worlds:
        compile_once(world=find_scenario(world), quiet=quiet)


@contextmanager
def _open_rows(study: Study, folder: Path, *file_name: str) -> Iterator[RowCache]:
    """Open the rows of an experiment, and say where they stay if the run is interrupted."""
    notes = make_console(err=True)
    cache = RowCache(study.name, folder, *file_name)
    if cache.put_aside:
        notes.print(f"[dim]What {folder} held is of another version of the program, and was put aside.[/]")
    elif len(cache):
        notes.print(f"[dim]Going on: {len(cache)} pieces are in {folder} already.[/]")
    try:
        yield cache
    except KeyboardInterrupt:
        notes.print(f"{len(cache)} pieces are kept in {folder}: the same command goes on from there.")
        raise


def _run(study: Study, plan: StudyPlan, folder: Path, *, jobs: int, quiet: bool) -> StudyResult:
    """Run an experiment and write its result and its figure into the folder."""
    with _open_rows(study, folder) as cache:
        _prepare(study, quiet=quiet)
        with show_progress(study.name, quiet=quiet) as report:
            rows = run(study, plan, cache, jobs=jobs, progress=report)
    seeds, findings = list(plan.seeds), study.conclude(rows)
    result = results.StudyResult(
        study.name, study.question or QUESTIONS[study.name], seeds, plan.quick, findings, rows
    )
    results.save(result, folder / "result.json")
    figures.save(study.draw(rows), folder / "figure.svg")
    return result


def _run_part(
    study: Study, plan: StudyPlan, folder: Path, part: Part, *, jobs: int, quiet: bool
) -> dict[str, Any]:
    """Run one part of an experiment, and say where its rows are."""
    with _open_rows(study, folder, part.file_name) as cache:
        _prepare(study, quiet=quiet)
        with show_progress(f"{study.name} {part}", quiet=quiet) as report:
            rows = run(study, plan, cache, part=part, jobs=jobs, progress=report)
    file = folder / part.file_name
    if not quiet:
        after = f"When all {part.of} parts have ended: understudy experiment {study.name} --gather"
        make_console().print(f"{len(rows)} pieces are in {file}. {after}", markup=False)
    return {"experiment": study.name, "part": str(part), "pieces": len(rows), "file": str(file)}


def _run_on_cluster(
    study: Study,
    plan: StudyPlan,
    folder: Path,
    cluster: str,
    parameters: Mapping[str, str | int],
    *,
    parts: int,
    quiet: bool,
) -> None:

    _prepare(study, quiet=quiet)
    with show_progress(f"{study.name} on {cluster}", quiet=quiet) as report:
        run_on_cluster(
            study.name, plan, folder, cluster=cluster, parts=parts, parameters=parameters, progress=report
        )


def _compared(result: StudyResult, experiment: Study) -> tuple[list[str], list[str]]:
    """Return the differences from the published result, and what could not be compared.

    Differences are in rows of the same tasks and in goals that were reached; without a published result, in all goals.
    """
    published = load_published(result.experiment)
    short = [] if published is None else [goal.what for goal in published.findings.misses]
    missed = [
        f"{goal.what}: {goal.measured}, not {goal.wanted}"
        for goal in (() if result.quick else result.findings.misses)
        if goal.what not in short
    ]
    if published is None:
        return missed, []
    wrong = [*missed, *differences(result.rows, published, experiment)]
    return wrong, list_uncompared(result.rows, published, experiment)


def _tell(result: StudyResult, wrong: list[str], unknown: list[str], folder: Path, out: Console) -> None:

    findings = result.findings
    out.print(f"[bold]{result.question}[/]")
    if result.quick:
        out.print("[dim]The quick version: too few teachings to judge by.[/]")
    out.print(findings.headline + "\n")
    for each in findings.tables:
        table = make_table(*each.columns, title=each.title)
        for row in each.rows:
            table.add_row(*row)
        out.print(table)
    if not result.quick and findings.goals:
        table = make_table("~goal", "#wanted", "#measured", "", title="What it was to reach")
        for goal in findings.goals:
            table.add_row(goal.what, goal.wanted, goal.measured, "" if goal.held else "[red]short[/]")
        out.print(table)
    for note in findings.notes:
        out.print(note)
    for problem in wrong[:SHOWN]:
        out.print(f"[red]Not as published:[/] {escape(problem)}")
    if len(wrong) > SHOWN:
        out.print(f"[dim]… and {len(wrong) - SHOWN} more.[/]")
    for each_unknown in unknown:
        out.print(f"[dim]{escape(each_unknown)}[/]")
    out.print(f"[dim]Kept in {folder}: result.json, figure.svg, rows.jsonl[/]\n")


def compile_once(*, learner: bool = False, world: Scenario | None = None, quiet: bool = False) -> None:
    """Compile the kernels that a measurement needs, and say so on stderr if it takes longer than 2 s."""
    out = make_console(err=True)
    out.quiet = quiet
    began = perf_counter()
    with out.status("Compiling once; the next run starts at once …"):
        if learner:
            prepare_learner()
        if world is not None:
            prepare_world(world)
    if perf_counter() - began > SLOW_S:
        out.print(f"[dim]Compiled in {perf_counter() - began:.0f} s; the next run starts at once.[/]")
