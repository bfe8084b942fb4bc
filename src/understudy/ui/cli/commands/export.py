"""Commands `understudy export automaton`: code that runs without Understudy, and `export why` about its traces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.markup import escape

from understudy.addons.export.body_interface import (
    BodyInterface,
    RobotInterface,
    describe_kit,
    describe_robot,
)
from understudy.addons.export.export_automaton import (
    ExportResult,
    combine_fingerprints,
    export_automaton,
    fingerprint_automata,
    link_ground,
)
from understudy.addons.export.export_folder import check_export_folder
from understudy.addons.export.exported_trace import (
    ExportedDecision,
    ExportedTick,
    check_trace,
    find_tick,
    read_exported_trace,
)
from understudy.addons.robots.robot import find_robot_scenario
from understudy.addons.robots.robot_file import load_robot
from understudy.errors import SettingError, join_names
from understudy.judging.explanation_text import MOST_EXAMPLES, describe_decision
from understudy.learning.explain import Explanation, explain_leaf
from understudy.learning.fit import learn
from understudy.model.lesson import Lesson
from understudy.model.library import Kit, Library
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import list_readings, make_channels
from understudy.storage.json_text import select_facts
from understudy.ui.cli.export_options import ExportOptions, ExportWhyOptions
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.library_data import find_automaton, report_left_out
from understudy.ui.cli.named_inputs import choose_kit, find_kit, find_optional_scenario
from understudy.ui.cli.options import parse_bindings
from understudy.ui.cli.output import format_count, make_console
from understudy.ui.cli.recorded_runs import read_run
from understudy.ui.cli.robot_connection import find_robots_file
from understudy.ui.cli.world_libraries import (
    choose_library_world,
    find_fitting_world,
    open_all_libraries,
)

if TYPE_CHECKING:
    from understudy.addons.export.hierarchy import Hierarchy
    from understudy.sim.scenario.schema import Scenario


def open_library_to_export(
    folder: Path, name: str, world: str | None, kit: str | None
) -> tuple[Library, str, BodyInterface]:
    """Open the library of an automaton named NAME or SORT/NAME; also return its own name, and its body.

    Without a world, the first built-in scenario that fits is taken, or the kit alone if one is named. The same goes for
    a function that makes a body: it has no scenario.
    """
    named = choose_library_world(folder, world, kit, name)
    where = find_optional_scenario(named)
    library, name = _open_library(folder, name, where, find_kit(kit, named))
    if where is None:
        return library, name, describe_kit(library)
    if _is_for_coordinators(library):
        return library, name, describe_kit(library, tick_s=where.tick_s)
    body = BodyInterface(tuple(list_readings(where)), make_channels(where), where.tick_s)
    return library, name, body


def open_library_for_robot(
    folder: Path, name: str, robot: Path, world: str | None, kit: str | None
) -> tuple[Library, str, RobotInterface]:
    """Open the library of an automaton for the robot of a file, whose world it is taught in.

    A world is named only if the file names none; without either, the first built-in scenario that fits is taken.
    """
    file = load_robot(robot)
    where, _ = find_robot_scenario(file, robot)
    if where is not None:
        find_robots_file(robot, None, world=world)
    else:
        where = find_scenario(world or find_fitting_world(folder, name))
    parts = choose_kit(kit, where)
    library, name = _open_library(folder, name, where, parts)
    if _is_for_coordinators(library):
        problem = f"is for one robot, and {name!r} coordinates a squad"
        raise SettingError(where="--robot", setting=str(robot), problem=problem, remedy="leave it out")
    return library, name, describe_robot(file, path=robot, scenario=where if file.world is None else None)


def _open_library(folder: Path, name: str, where: Scenario | None, parts: Kit) -> tuple[Library, str]:
    listings = open_all_libraries(folder, where, parts, learn)
    listing, name = find_automaton(listings, name)
    report_left_out(listings)
    return listing.library, name


def _is_for_coordinators(library: Library) -> bool:
    return any(each.order is not None for each in library.kit.behaviors.values())


def export_behavior(options: ExportOptions) -> None:
    """Export an automaton with everything below it, so that it runs without Understudy and decides the same."""
    name = options.name
    check_export_folder(options.out)  # before a library is opened, which may have to be learned again
    body: BodyInterface | RobotInterface
    if options.robot is None:
        known, name, body = open_library_to_export(options.library, name, options.world, options.kit)
    else:
        known, name, body = open_library_for_robot(
            options.library, name, options.robot, options.world, options.kit
        )
    runs = [record for path in options.run or () for record in read_run(path)]
    for sentence in dict.fromkeys(each for record in runs for each in record.omissions):
        typer.echo(f"Note: {sentence}.", err=True)
    found = export_automaton(
        known,
        name,
        options.out,
        to=options.to,
        binding=parse_bindings(options.bind),
        body=body,
        single_precision=options.float32,
        runs=runs,
    )
    if options.as_json:
        print_json(_describe(name, found))
    else:
        _show(name, found)


def _describe(name: str, found: ExportResult) -> dict[str, Any]:
    """Describe an export: bytes by file, ticks of the conformance file, and what could not be exported and why."""
    parts = ("name", "readings", "problem")
    untranslated = [dict(zip(parts, each, strict=True)) for each in found.untranslated]
    names = ("target", "folder", "files", "ticks", "untranslated", "rounded_cuts", "notes")
    facts = select_facts(found, *names, untranslated=untranslated, rounded_cuts=found.rounded)
    return {"name": name, **facts}


def _show(name: str, found: ExportResult) -> None:
    out = make_console()
    size = sum(found.files.values()) / 1000
    files = format_count(len(found.files), "file")
    out.print(f"[bold]{escape(name)}[/] for {found.target}: {files}, {size:.0f} kB", soft_wrap=True)
    for what, readings, problem in found.untranslated:
        read = f" (reads {', '.join(readings)})" if readings else ""
        out.print(f"missing: {escape(what)}{escape(read)}, because {escape(problem)}", soft_wrap=True)
    for note in found.notes:
        out.print(f"note: {escape(note)}", soft_wrap=True)
    for cut in found.rounded:
        margin = "" if cut.margin != cut.margin else f", {cut.margin:.3g} from the nearest example"
        moved = f"{cut.cut!r} became {cut.exported!r}" if cut.is_separating else f"{cut.cut!r} is too close"
        where = f"{cut.automaton} in {cut.state}, {cut.feature}"
        out.print(f"single precision: {escape(where)}: {moved}{margin}", soft_wrap=True)
    out.print(
        f"[dim]make -C {escape(str(found.folder))} test runs it on {found.ticks} ticks[/]", soft_wrap=True
    )


@dataclass(frozen=True, kw_only=True)
class ExportedReason:
    """A decision of exported code, with its conditions and the numbers of the examples behind it."""

    time: float
    automaton: str
    before: str
    after: str
    why: str
    conditions: Sequence[str]
    shown: bool
    examples: Sequence[int]


def explain_exported(options: ExportWhyOptions) -> None:
    """Explain every switch in a trace of exported code, or all decisions of the tick at --time."""
    read = read_exported_trace(options.trace)
    library, name, body = open_library_to_export(options.library, read.name, options.world, options.kit)
    _, hierarchy = link_ground(library, name, read.binding, body)
    check_trace(read, hierarchy, combine_fingerprints(fingerprint_automata(library, name)))
    ticks = list(read.ticks)
    if options.time is not None:
        found = find_tick(ticks, options.time)
        if found is None:
            raise SettingError(
                where=str(options.trace),
                setting="--time",
                problem=f"is {options.time:.15g}, before the trace begins",
                remedy="give more",
            )
        ticks = [found]
    reasons = [
        _explain(tick, decision, hierarchy, library)
        for tick in ticks
        for decision in tick.decisions
        if options.time is not None or decision.before != decision.after
    ]
    if options.as_json:
        print_json({"automaton": name, "ticks": len(read.ticks), "decisions": reasons})
        return
    out = make_console()
    for reason in reasons:
        out.print(
            f"{reason.time:.15g} [cyan]{escape(reason.automaton)}[/] {escape(reason.why)}", soft_wrap=True
        )
    if not reasons:
        out.print(f"no automaton changed its state in {len(read.ticks)} ticks")


def _explain(
    tick: ExportedTick, decision: ExportedDecision, hierarchy: Hierarchy, library: Library
) -> ExportedReason:
    automaton = hierarchy.automata[decision.automaton]
    before, after = automaton.states[decision.before], automaton.states[decision.after]
    found = _find_explanation(decision, hierarchy, library)
    numbers = [each.number for each in found.examples if each.is_from_press] if found else []
    why = f"stays in {before.name}: it has no tree there" if found is None else describe_decision(found)
    if before.flag is not None:
        why = f"stays in {before.name}: a flag state is never left"
    if numbers:
        more = [f"{len(numbers) - MOST_EXAMPLES} more"] if len(numbers) > MOST_EXAMPLES else []
        why += f"; shown by {join_names([*map(str, numbers[:MOST_EXAMPLES]), *more])}"
    return ExportedReason(
        time=tick.time,
        automaton=automaton.name,
        before=before.name,
        after=after.name,
        why=why,
        conditions=() if found is None else found.conditions,
        shown=found is not None and found.shown,
        examples=numbers,
    )


def _find_explanation(
    decision: ExportedDecision, hierarchy: Hierarchy, library: Library
) -> Explanation | None:
    automaton = hierarchy.automata[decision.automaton]
    state = automaton.states[decision.before]
    if state.tree is None:
        return None
    taught = library.taught[automaton.automaton]
    lesson = taught.lesson or Lesson(replace(taught.automaton, transitions={}))
    return explain_leaf(lesson, state.name, state.tree, decision.leaf)
