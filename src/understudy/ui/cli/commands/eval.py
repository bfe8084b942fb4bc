"""Command `understudy eval`: measure the success rate, the speed and other numbers of a behavior or a team."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import typer

from understudy.addons.bridges.environments.body_maker import find_world
from understudy.errors import SettingError
from understudy.judging.comparison import compare
from understudy.judging.evaluate import evaluate
from understudy.judging.evaluation import Evaluation
from understudy.judging.properties.monitor import PropertyRule
from understudy.judging.properties.offered_goals import find_behavior_success
from understudy.judging.result_table import LAYOUTS
from understudy.model.property import Property
from understudy.sim.scenario.schema import Scenario
from understudy.ui.cli import evaluation_output as output
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.named_inputs import RunAssignment, assign_run, choose_kit
from understudy.ui.cli.options import LIBRARY, WORLD
from understudy.ui.cli.progress_bar import show_progress
from understudy.ui.cli.run_options import JSON, EvaluateOptions

if TYPE_CHECKING:
    from understudy.addons.bridges.environments.body_maker import BodyMaker
    from understudy.model.library import Library
    from understudy.sim.team.libraries import Libraries

MOST_SEEDS = 1_000_000


def evaluate_behavior(options: EvaluateOptions) -> None:
    """Evaluate a behavior in many worlds of a scenario; all its robots run it, or follow their coordinators."""
    _check_layout(options)
    named = options.world_name
    judging = Judging(find_world(named), parse_seeds(options.seeds), options)
    parts = choose_kit(options.kit, judging.world)
    assigned = [assign_run(judging.world, options.behavior, options.library, parts, options.bind)]
    if options.against is not None or options.against_behavior is not None:
        second, is_other = options.against_behavior or options.behavior, options.against_behavior is not None
        other = options.against or options.library
        assigned.append(
            assign_run(judging.world, second, other, parts, options.bind, bound_for_others=is_other)
        )
    names = _name_pair(
        options.library, assigned[0].behavior, options.against or options.library, assigned[-1].behavior
    )
    watch = format_run_command(
        named,
        options.behavior or assigned[0].behavior,
        options.library,
        bind=options.bind or [],
        kit=options.kit,
    )
    began = perf_counter()
    judged = judging.judge(assigned)
    _print_results(judged, names, watch, perf_counter() - began, options)


@dataclass(frozen=True, slots=True)
class Judging:
    """Worlds in which behaviors are evaluated, and what counts there; a body of the user's own needs a limit."""

    world: Scenario | BodyMaker
    seeds: range
    options: EvaluateOptions

    def __post_init__(self) -> None:
        if not isinstance(self.world, Scenario) and self.options.limit_s is None:
            problem = f"is missing, and {self.world.name} makes a body, which has none"
            remedy = "give the time limit in s: --limit 20"
            raise SettingError(where="eval", setting="--limit", problem=problem, remedy=remedy)

    def judge(self, assigned: Sequence[RunAssignment]) -> list[Evaluation]:
        """Evaluate behaviors one after another, all in the same worlds."""
        with show_progress("Worlds run", quiet=self.options.prints_json) as report:
            total = len(assigned) * len(self.seeds)
            return [
                self._judge_one(ran, partial(_report_after, index * len(self.seeds), total, report))
                for index, ran in enumerate(assigned)
            ]

    def _judge_one(self, ran: RunAssignment, progress: Callable[[int, int], None]) -> Evaluation:
        """Evaluate by the goal that was chosen when the behavior was taught, or by the options if any is given."""
        options, meant = self.options, find_behavior_success(ran.libraries[ran.sort], ran.behavior)
        is_given = options.goal or options.metric or options.limit_s
        is_chosen = isinstance(self.world, Scenario) and not is_given
        rule = PropertyRule(meant) if isinstance(meant, Property) and is_chosen else None
        return evaluate(
            *_choose_library(ran, self.world),
            self.world,
            self.seeds,
            binding=ran.binding,
            goal=options.goal or rule,
            metrics=options.metric or (),
            limit_s=options.limit_s,
            jobs=options.jobs,
            progress=progress,
        )


def _print_results(
    judged: Sequence[Evaluation],
    names: tuple[str, str],
    watch: str,
    seconds: float,
    options: EvaluateOptions,
) -> None:
    """Print one evaluation, or two and their comparison, as a table for a paper, as JSON or as text."""
    one, compared = judged[0], compare(*judged) if len(judged) > 1 else None
    output.show_problems([problem for evaluation in judged for problem in evaluation.problems])
    if options.layout not in (None, JSON):
        table = output.format_results(one, options.layout, each=options.each)
        typer.echo(table if compared is None else compared.to_table(options.layout, names=names), nl=False)
        return
    found = output.summarize_evaluation(
        one, seconds=seconds, each=options.each, compared=compared, against=names[1]
    )
    if options.prints_json:
        print_json(found)
        return
    output.show_results(found, watch, wanted=one.flag or one.goal)
    if compared is not None:
        output.show_comparison(compared, names)


def _choose_library(ran: RunAssignment, where: Scenario | BodyMaker) -> tuple[Library | Libraries, str]:
    """Return the library and the name of a behavior: of all sorts of agents, or of a body's only one."""
    if isinstance(where, Scenario):
        return ran.libraries, f"{ran.sort}/{ran.behavior}"
    return ran.libraries[ran.sort], ran.behavior


def _report_after(before: int, total: int, report: Callable[[int, int], None], through: int, _: int) -> None:
    """Report the progress of one of several evaluations as that of all."""
    report(before + through, total)


def _check_layout(options: EvaluateOptions) -> None:
    """Refuse a format that does not exist, or that of a table beside --json, before anything runs."""
    layout = options.layout
    if layout in (None, JSON):
        return
    if layout not in LAYOUTS:
        problem, remedy = "is unknown", "give markdown, latex or csv for a table, or json"
    elif options.as_json:
        problem, remedy = "is a table, and --json no table", "give one of them"
    else:
        return
    raise SettingError(where="--format", setting=repr(layout), problem=problem, remedy=remedy)


def _name_pair(library: Path, behavior: str, other: Path, other_behavior: str) -> tuple[str, str]:
    """Return what tells two compared behaviors apart: the name of the behavior, the folder, or both."""
    if library == other:
        return behavior, other_behavior
    if behavior == other_behavior:
        return str(library), str(other)
    return f"{library}/{behavior}", f"{other}/{other_behavior}"


def parse_seeds(text: str) -> range:
    """Return the seeds named by A:B (B excluded) or by a single number."""
    first, colon, last = text.partition(":")
    if first.isdecimal() and (last.isdecimal() if colon else True):
        seeds = range(int(first), int(last) if colon else int(first) + 1)
        if 0 < len(seeds) <= MOST_SEEDS:
            return seeds
    raise SettingError(
        where="--seeds",
        setting=repr(text),
        problem="is not a range of seeds",
        remedy="write A:B with A below B: 0:100",
    )


def format_run_command(
    world: str, behavior: str, library: Path, *, bind: Sequence[str] = (), kit: str | None = None
) -> str:
    """Return the shell command that runs a behavior as it was evaluated, without the seed."""
    words = ["understudy", "run", *([] if world == WORLD else [world]), "--behavior", behavior]
    words += [] if library == LIBRARY else ["--library", str(library)]
    words += [] if kit is None else ["--kit", kit]
    for pair in bind:
        words += ["--bind", pair]
    return shlex.join(words)
