"""Command `understudy advise`: suggest what to show next in a lesson."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

from understudy.ui.cli.options import LIBRARY, Bind, Json, KitName, LibraryOption, SomeWorld

if TYPE_CHECKING:
    from understudy.coaching.advice import Advice, AdviceKind
    from understudy.model.lesson import Lesson

MOST = 8


def advise(
    name: Annotated[str, typer.Argument(help="Name of the automaton.")],
    library: LibraryOption = LIBRARY,
    world: SomeWorld = None,
    kit: KitName = None,
    bind: Bind = None,
    most: Annotated[int, typer.Option("--most", min=1, help="Maximum number of suggestions.")] = MOST,
    as_json: Json = False,
) -> None:
    """Suggest what to show next in a lesson, most useful first.

    With --world, situations are taken from that world, and features that the lesson left out are tried on
    contradictions. Without it, situations are made up from the examples.

    [dim]understudy advise goto --library demo/library --world forage[/]
    """
    from understudy.coaching.give_advice import give_advice
    from understudy.learning.fit import learn
    from understudy.storage.library_folder import open_each_automaton
    from understudy.ui.cli.options import find_optional_kit, import_learner
    from understudy.ui.cli.output import print_json

    if bind and world is None:
        raise _refused("--bind", bind[0], "needs a world", "add --world SCENARIO")
    parts = find_optional_kit(kit, world)
    listing = open_each_automaton(library, parts, import_learner())
    if name not in listing.opened and (error := listing.problems.get(f"{name}.json")):
        raise error
    listing.library.automaton(name)
    lesson = listing.opened[name].taught.lesson
    if lesson is None:
        raise _refused(
            f"automaton {name!r}", "its lesson", "is missing: it was written by hand", "name a taught one"
        )
    situations = None if world is None else _situations(lesson, world, bind)
    found = give_advice(lesson, learn(lesson), kit=parts, situations=situations)
    if as_json:
        print_json({"name": name, "advice": [_make_row(each, lesson) for each in found[:most]]})
    else:
        _show(name, found, most)


def _refused(where: str, setting: str, problem: str, remedy: str) -> Exception:
    from understudy.errors import SettingError

    return SettingError(where=where, setting=setting, problem=problem, remedy=remedy)


def _situations(lesson: Lesson, world: str, bind: list[str] | None) -> Any:
    """Sample readings of a robot at many places in the scenario; own features are as in the examples."""
    from understudy.coaching.pose_sampling import sample_posed_situations
    from understudy.sim.world import World
    from understudy.training.lesson_design import check_parameter_targets
    from understudy.ui.cli.options import open_scenario, parse_bindings

    body = World(open_scenario(world))
    automaton = lesson.automaton
    targets = dict.fromkeys(automaton.parameters, body.targets[0]) | parse_bindings(bind)
    check_parameter_targets(automaton, targets, body.targets)
    return sample_posed_situations(body, automaton.features, targets)


@dataclass(frozen=True, kw_only=True)
class AdviceRow:
    """One suggestion as `--json` prints it; `region` holds the ranges of feature values concerned."""

    kind: AdviceKind
    sentence: str
    state: str | None
    weight: float
    examples: Sequence[int]
    region: Mapping[str, Any] | None


def _make_row(each: Advice, lesson: Lesson) -> AdviceRow:
    return AdviceRow(
        kind=each.kind,
        sentence=each.sentence,
        state=each.state or None,
        weight=round(each.weight, 3),
        examples=each.examples,
        region=None if each.region is None else _region(each, lesson),
    )


def _region(each: Advice, lesson: Lesson) -> dict[str, Any]:
    """Describe the part of the feature space that an advice is about, as JSON.

    For each feature that is restricted there, the result has the ranges of its values, and whether it may be absent.
    """
    from math import isinf

    from understudy.model.tree_regions import make_full_value_set

    found = {}
    for bound, part in zip(lesson.automaton.features, each.region or (), strict=True):
        if part != make_full_value_set(bound.kind):
            ends = [[None if isinf(end) else end for end in ends] for ends in part.parts]
            found[str(bound)] = {"parts": ends, "absent": part.absent}
    return found


def _show(name: str, found: tuple[Advice, ...], most: int) -> None:
    from rich.markup import escape
    from rich.padding import Padding

    from understudy.ui.cli.output import make_console

    out = make_console()
    out.print(f"[bold]{escape(name)}[/]")
    if not found:
        out.print("No suggestions: the lesson is consistent")
    for number, each in enumerate(found[:most], 1):
        color = "yellow" if each.weight > 0.7 else "default" if each.weight > 0.3 else "dim"
        out.print(Padding(f"[{color}]{number}. {escape(each.sentence)}[/]", (0, 0, 0, 2), expand=False))
    if len(found) > most:
        out.print(f"[dim]{len(found) - most} more: --most {len(found)}[/]")
