"""Command `understudy eval`: measure the success rate, the speed and other numbers of a behavior or a team."""

from __future__ import annotations

import shlex
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer
from msgspec import UNSET

from understudy.errors import SettingError
from understudy.ui.cli.options import (
    LIBRARY,
    WORLD,
    BehaviorName,
    Bind,
    Json,
    KitName,
    LibraryOption,
    SameWorld,
    ScenarioName,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from understudy.adapters.body_maker import BodyMaker
    from understudy.model.library import Library
    from understudy.sim.scenario.schema import Scenario
    from understudy.sim.team.libraries import Libraries
    from understudy.ui.cli.options import RunAssignment

MOST_SEEDS = 1_000_000


def evaluate_behavior(
    scenario: ScenarioName = None,
    behavior: BehaviorName = None,
    library: LibraryOption = LIBRARY,
    world: SameWorld = None,
    seeds: Annotated[
        str,
        typer.Option("--seeds", metavar="A:B", help="Seeds of the worlds, from A up to but not including B."),
    ] = "0:100",
    bind: Bind = None,
    kit: KitName = None,
    goal: Annotated[
        str | None,
        typer.Option(
            "--goal",
            metavar="NAME",
            help="Flag, or reading that is yes or no, that counts as success: 'at_station'.",
            show_default=False,
        ),
    ] = None,
    metric: Annotated[
        list[str] | None,
        typer.Option(
            "--metric", metavar="NAME", help="Reading to measure at the end of each world; can be repeated."
        ),
    ] = None,
    limit_s: Annotated[
        float | None,
        typer.Option(
            "--limit", metavar="SECONDS", help="Time limit of each world, in simulated s.", show_default=False
        ),
    ] = None,
    against: Annotated[
        Path | None,
        typer.Option(
            "--against",
            metavar="FOLDER",
            help="Library to compare with in the same worlds.",
            show_default=False,
        ),
    ] = None,
    against_behavior: Annotated[
        str | None,
        typer.Option(
            "--against-behavior",
            metavar="NAME",
            help="Behavior to compare with in the same worlds; the same one if left out.",
            show_default=False,
        ),
    ] = None,
    jobs: Annotated[
        int, typer.Option("--jobs", "-j", metavar="N", help="Processes to share the worlds.")
    ] = 1,
    each: Annotated[bool, typer.Option("--each", help="Print one row per world.")] = False,
    layout: Annotated[
        str | None,
        typer.Option(
            "--format",
            metavar="FORMAT",
            help="Print a table for a paper: markdown, latex or csv.",
            show_default=False,
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Evaluate a behavior in many worlds of a scenario; all its robots run it, or follow their coordinators.

    The world can be a body of your own, too, such as a Gymnasium environment; give --goal and --limit then.

    A world is a success if the behavior raises its flag done, or its only one, within the scenario's time limit. A
    behavior without such a flag has to reach the scenario's goal by then. Where there is a hand-written controller to
    compare with, as for foraging by a single robot, the limit is three times its time in the same world. --goal and
    --limit replace these. A goal that was chosen for the behavior when it was taught counts instead, unless --goal,
    --metric or --limit is given.

    With --against or --against-behavior, both are run in the same worlds, and compared pair by pair: success with
    McNemar's exact test, numbers with Wilcoxon's signed-rank test.

    [dim]understudy eval --library demo/library --behavior forage --seeds 1000:1100[/]

    [dim]understudy eval arena --library mine --behavior goto --bind A=red_flag[/]

    [dim]understudy eval --world cart_pole:make --behavior balance --goal truncated --limit 11[/]

    [dim]understudy eval --library mine --against demo/library --behavior forage --metric food_stored --format latex[/]
    """
    from understudy.analysis.comparison import compare
    from understudy.analysis.evaluate import evaluate
    from understudy.analysis.evaluation import Evaluation
    from understudy.model.property import Property
    from understudy.properties.monitor import PropertyRule
    from understudy.properties.offered_goals import find_behavior_success
    from understudy.sim.scenario.schema import Scenario
    from understudy.ui.cli import evaluation_output as output
    from understudy.ui.cli.options import (
        assign_run,
        choose_scenario_name,
        find_kit,
        make_world_kit,
        open_world,
    )
    from understudy.ui.cli.output import print_json, show_progress

    _check_layout(layout, as_json=as_json)
    chosen, named = parse_seeds(seeds), choose_scenario_name(scenario, world)
    where = open_world(named)
    _check_limit(where, limit_s)
    parts = make_world_kit(where) if kit is None else find_kit(kit, named)
    assigned = [assign_run(where, behavior, library, parts, bind)]
    if against is not None or against_behavior is not None:
        second = against_behavior or behavior, against or library
        assigned.append(
            assign_run(where, *second, parts, bind, bound_for_others=against_behavior is not None)
        )
    began = perf_counter()
    judged = list[Evaluation]()
    with show_progress("Worlds run", quiet=as_json) as report:
        for ran in assigned:
            before = len(judged) * len(chosen)
            progress = partial(_report_after, before, len(assigned) * len(chosen), report)
            meant = find_behavior_success(ran.libraries[ran.sort], ran.behavior)
            is_chosen = isinstance(where, Scenario) and not (goal or metric or limit_s)
            rule = PropertyRule(meant) if isinstance(meant, Property) and is_chosen else None
            judged.append(
                evaluate(
                    *_choose_library(ran, where),
                    where,
                    chosen,
                    binding=ran.binding,
                    goal=goal or rule,
                    metrics=metric or (),
                    limit_s=limit_s,
                    jobs=jobs,
                    progress=progress,
                )
            )
    one, compared = judged[0], compare(*judged) if len(judged) > 1 else None
    names = _name_pair(library, assigned[0].behavior, against or library, assigned[-1].behavior)
    output.show_problems([problem for each_one in judged for problem in each_one.problems])
    if layout is not None:
        table = output.format_results(one, layout, each=each)
        typer.echo(table if compared is None else compared.to_table(layout, names=names), nl=False)
        raise typer.Exit(0)
    found = output.summarize_evaluation(
        one,
        output.make_world_rows(one) if each else UNSET,
        seconds=perf_counter() - began,
        comparison=UNSET if compared is None else output.make_comparison_result(compared, names[1]),
    )
    if as_json:
        print_json(found)
        raise typer.Exit(0)
    watch = format_run_command(named, behavior or assigned[0].behavior, library, bind=bind or [], kit=kit)
    output.show_results(found, watch, wanted=one.flag or one.goal)
    if compared is not None:
        output.show_comparison(compared, names)
    raise typer.Exit(0)


def _choose_library(ran: RunAssignment, where: Scenario | BodyMaker) -> tuple[Library | Libraries, str]:
    """Return the library and the name of a behavior: of all sorts of agents, or of a body's only one."""
    from understudy.sim.scenario.schema import Scenario

    if isinstance(where, Scenario):
        return ran.libraries, f"{ran.sort}/{ran.behavior}"
    return ran.libraries[ran.sort], ran.behavior


def _check_limit(where: Scenario | BodyMaker, limit_s: float | None) -> None:
    """Refuse a body of the user's own without a limit: that of a scenario is known."""
    from understudy.sim.scenario.schema import Scenario

    if not isinstance(where, Scenario) and limit_s is None:
        problem = f"is missing, and {where.name} makes a body, which has none"
        raise SettingError(
            where="eval", setting="--limit", problem=problem, remedy="give the time limit in s: --limit 20"
        )


def _report_after(before: int, total: int, report: Callable[[int, int], None], through: int, _: int) -> None:
    """Report the progress of one of several evaluations as that of all."""
    report(before + through, total)


def _check_layout(layout: str | None, *, as_json: bool) -> None:
    """Refuse a format that does not exist, or one beside --json, before anything runs."""
    from understudy.analysis.result_table import LAYOUTS

    if layout is None:
        return
    if layout not in LAYOUTS:
        problem, remedy = "is unknown", "give markdown, latex or csv"
    elif as_json:
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
