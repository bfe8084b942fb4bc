"""Command `understudy advise`: suggest what to show next in a lesson."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.markup import escape
from rich.padding import Padding

from understudy.addons.checks.falsification.lesson_score import find_wrong_decisions, score_behavior
from understudy.addons.checks.falsification.new_worlds import NewWorlds
from understudy.addons.checks.falsification.session_setup import SessionSetup
from understudy.coaching.give_advice import give_advice
from understudy.coaching.pose_sampling import sample_posed_situations
from understudy.errors import SettingError
from understudy.judging.properties.offered_goals import find_success
from understudy.learning.fit import learn, learn_automaton
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree_regions import make_full_value_set
from understudy.sim.catalog import find_scenario
from understudy.sim.world import World
from understudy.storage.library_folder import open_each_automaton
from understudy.training.lesson_design import check_parameter_targets
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.library_data import find_optional_kit, report_left_out
from understudy.ui.cli.library_options import AdviseOptions
from understudy.ui.cli.options import parse_bindings
from understudy.ui.cli.output import make_console
from understudy.ui.cli.progress_bar import show_progress

if TYPE_CHECKING:
    from understudy.coaching.advice import Advice, WrongDecisions
    from understudy.model.lesson import Lesson

MOST = 8
FIRST_SEED = 1_100_000_000
"""The first seed of the new worlds in which the automaton runs."""
WORLDS, WORLDS_BY_GOAL = 100, 30
"""The number of new worlds for an automaton with a flag, and for one that is judged by the goal of the world."""


def advise(options: AdviseOptions) -> None:
    """Suggest what to show next in a lesson, most useful first."""
    if options.bind and options.world is None:
        raise _refused("--bind", options.bind[0], "needs a world", "add --world SCENARIO")
    parts = find_optional_kit(options.kit, options.world)
    listing = open_each_automaton(options.library, parts, learn)
    if options.name not in listing.opened and (error := listing.problems.get(f"{options.name}.json")):
        raise error
    report_left_out({"": listing})
    listing.library.automaton(options.name)
    lesson = listing.opened[options.name].taught.lesson
    if lesson is None:
        raise _refused(
            f"automaton {options.name!r}",
            "its lesson",
            "is missing: it was written by hand",
            "name a taught one",
        )
    situations, wrong = None, None
    if options.world is not None:
        body, targets = _place(lesson, options.world, options.bind)
        situations = sample_posed_situations(body, lesson.automaton.features, targets)
        wrong = _run_in_new_worlds(
            lesson,
            listing.library,
            body,
            _list_bindings(lesson, body, targets, options.bind),
            quiet=options.as_json,
        )
    with show_progress("Looks at the lesson", quiet=options.as_json) as report:
        found = give_advice(
            lesson, learn(lesson), kit=parts, situations=situations, wrong=wrong, progress=report
        )
    if options.as_json:
        advice = [_describe(each, lesson) for each in found[: options.most]]
        print_json({"name": options.name, "advice": advice})
    else:
        _show(options.name, found, options.most)


def _refused(where: str, setting: str, problem: str, remedy: str) -> Exception:
    return SettingError(where=where, setting=setting, problem=problem, remedy=remedy)


def _place(lesson: Lesson, world: str, bind: list[str] | None) -> tuple[World, Mapping[str, str]]:
    """Return a world of a scenario, and the target of each parameter there: its first one if none was named."""
    body = World(find_scenario(world))
    targets = dict.fromkeys(lesson.automaton.parameters, body.targets[0]) | parse_bindings(bind)
    check_parameter_targets(lesson.automaton, targets, body.targets)
    return body, targets


def _list_bindings(
    lesson: Lesson, body: World, targets: Mapping[str, str], bind: list[str] | None
) -> list[Mapping[str, str]]:
    """List the targets at presses that this world has, each once; those that were named, if there are any."""
    shown = {tuple(each.binding.items()): dict(each.binding) for each in lesson.examples}
    names, known = set(lesson.automaton.parameters), set(body.targets)
    usual = [each for each in shown.values() if set(each) == names and set(each.values()) <= known]
    return [targets] if bind or not usual else [*usual]


def _run_in_new_worlds(
    lesson: Lesson, library: Library, body: World, bindings: Sequence[Mapping[str, str]], *, quiet: bool
) -> WrongDecisions | None:
    """Run what was learned in new worlds, with each of some targets; None if nothing says where it works."""
    taught = TrainedAutomaton(learn_automaton(lesson), lesson)
    success = find_success(lesson)
    if not lesson.examples or not (success or body.scenario.goal):
        return None
    seeds = range(FIRST_SEED, FIRST_SEED + (WORLDS if isinstance(success, str) else WORLDS_BY_GOAL))
    setup, whole = SessionSetup(body.scenario), library.with_automaton(taught)
    with show_progress("Worlds run", quiet=quiet) as report:
        score = score_behavior(
            whole, taught.automaton.name, NewWorlds(setup, seeds), bindings, progress=report
        )
    return find_wrong_decisions(whole, setup, score)


def _describe(each: Advice, lesson: Lesson) -> dict[str, Any]:
    """Describe a suggestion for `--json`, with the ranges of the features that are restricted in its region."""
    bounds = zip(lesson.automaton.features, each.region or (), strict=each.region is not None)
    ranges = {str(bound): part._asdict() for bound, part in bounds if part != make_full_value_set(bound.kind)}
    return {
        "kind": each.kind,
        "sentence": each.sentence,
        "evidence": each.evidence or None,
        "state": each.state or None,
        "weight": round(each.weight, 3),
        "examples": each.examples,
        "region": None if each.region is None else ranges,
    }


def _show(name: str, found: tuple[Advice, ...], most: int) -> None:
    out = make_console()
    out.print(f"[bold]{escape(name)}[/]")
    if not found:
        out.print("No suggestions: the lesson is consistent")
    for number, each in enumerate(found[:most], 1):
        color = "yellow" if each.weight > 0.7 else "default" if each.weight > 0.3 else "dim"
        text = escape(f"{number}. {each.sentence} {each.evidence}".rstrip())
        out.print(Padding(f"[{color}]{text}[/]", (0, 0, 0, 2), expand=False))
    if len(found) > most:
        out.print(f"[dim]{len(found) - most} more: --most {len(found)}[/]")
