"""Commands `understudy export`: write an automaton as code that runs without Understudy, or data."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from understudy.errors import SettingError, join_names
from understudy.export.targets import list_targets
from understudy.ui.cli.commands.export_data import LEROBOT, MINARI, export_data
from understudy.ui.cli.options import LIBRARY, Bind, FoundWorld, Json, KitName, LibraryOption

if TYPE_CHECKING:
    from understudy.export.body_interface import BodyInterface, RobotInterface
    from understudy.export.export_automaton import ExportResult
    from understudy.model.library import Kit, Library
    from understudy.sim.scenario.schema import Scenario

AUTOMATON, DATA = "automaton", "data"
HELP = ("--help", "-h")


class ExportGroup(TyperGroup):
    """The group of export commands, in which `export NAME --to TARGET` is short for `export automaton NAME ...`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments, with the command that is left out."""
        return super().parse_args(ctx, insert_command(args))


def insert_command(args: list[str]) -> list[str]:
    """Insert the command `automaton` before the arguments of `export` if they do not begin with a command.

    An automaton may have the name of a command: then the option `--to` tells what is meant.
    """
    if not args or args[0] in HELP:
        return args
    if args[0] == DATA:
        has_source = len(args) > 1 and args[1][:1] != "-"
        is_command = has_source or _find_target(args) in (None, LEROBOT, MINARI)
    else:
        is_command = args[0] == AUTOMATON and (len(args) < 2 or args[1][:1] != "-" or args[1] in HELP)
    return args if is_command else [AUTOMATON, *args]


def _find_target(args: Sequence[str]) -> str | None:
    """Return the value of `--to`, or None if the option is missing."""
    for place, each in enumerate(args):
        name, _, value = each.partition("=")
        if name == "--to":
            return value or "".join(args[place + 1 : place + 2])
    return None


app = typer.Typer(
    cls=ExportGroup,
    no_args_is_help=True,
    help="Export an automaton as code, or data. `export NAME` is short for `export automaton NAME`.",
)
app.command(DATA)(export_data)


@app.command(AUTOMATON)
def export_behavior(
    name: Annotated[
        str, typer.Argument(help="Name of the automaton; SORT/NAME for one of a squad or robot type.")
    ],
    to: Annotated[
        str,
        typer.Option("--to", metavar="TARGET", help=f"Target: {join_names(list_targets(), word='or')}."),
    ],
    out: Annotated[
        Path,
        typer.Option("--out", "-o", metavar="DIR", help="Folder to write: new, empty, or an earlier export."),
    ],
    library: LibraryOption = LIBRARY,
    bind: Bind = None,
    float32: Annotated[
        bool,
        typer.Option(
            "--float32", help="Single precision, and times in milliseconds, for small microcontrollers (c99)."
        ),
    ] = False,
    world: FoundWorld = None,
    kit: KitName = None,
    robot: Annotated[
        Path | None,
        typer.Option(
            "--robot",
            metavar="FILE",
            help="File of the robot to export for; ros2 needs it.",
            show_default=False,
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Export an automaton with everything below it, so that it runs without Understudy and decides the same.

    The folder gets the code, a manifest of what it reads and commands, and rows of readings with the decisions of
    Understudy, on which `make test` runs the exported code.

    [dim]understudy export forage --library demo/library --to c99 --out forage-c[/]

    [dim]understudy export goto --bind A=station --library demo/library --to python --out goto-python[/]

    [dim]understudy export servo --library library --to ros2 --robot rover.toml --out servo-ros2[/]
    """
    from understudy.export.export_automaton import export_automaton
    from understudy.ui.cli.options import parse_bindings
    from understudy.ui.cli.output import print_json

    body: BodyInterface | RobotInterface
    if robot is None:
        known, name, body = open_library_to_export(library, name, world, kit)
    else:
        known, name, body = open_library_for_robot(library, name, robot, world, kit)
    found = export_automaton(
        known, name, out, to=to, binding=parse_bindings(bind), body=body, single_precision=float32
    )
    if as_json:
        print_json(_describe(name, found))
    else:
        _show(name, found)


def open_library_to_export(
    folder: Path, name: str, world: str | None, kit: str | None
) -> tuple[Library, str, BodyInterface]:
    """Open the library of an automaton named NAME or SORT/NAME; also return its own name, and its body.

    Without a world, the first built-in scenario that fits is taken, or the kit alone if one is named. The same goes for
    a function that makes a body: it has no scenario.
    """
    from understudy.export.body_interface import BodyInterface, describe_kit
    from understudy.sim.kit import list_readings, make_channels
    from understudy.ui.cli.library_data import find_fitting_world
    from understudy.ui.cli.options import find_kit, find_optional_scenario

    named = world or (find_fitting_world(folder) if kit is None else None)
    where = find_optional_scenario(named)
    library, name = _open_library(folder, name, where, find_kit(kit, named or ""))
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
    from understudy.export.body_interface import describe_robot
    from understudy.robots.robot import find_robot_scenario
    from understudy.robots.robot_file import load_robot
    from understudy.sim.kit import make_scenario_kit
    from understudy.ui.cli.library_data import find_fitting_world
    from understudy.ui.cli.options import find_kit, open_scenario
    from understudy.ui.cli.robot_options import find_robots_file

    file = load_robot(robot)
    where, _ = find_robot_scenario(file, robot)
    if where is not None:
        find_robots_file(robot, None, world=world)
    else:
        where = open_scenario(world or find_fitting_world(folder))
    parts = make_scenario_kit(where) if kit is None else find_kit(kit, "")
    library, name = _open_library(folder, name, where, parts)
    if _is_for_coordinators(library):
        problem = f"is for one robot, and {name!r} coordinates a squad"
        raise SettingError(where="--robot", setting=str(robot), problem=problem, remedy="leave it out")
    return library, name, describe_robot(file, path=robot, scenario=where if file.world is None else None)


def _open_library(folder: Path, name: str, where: Scenario | None, parts: Kit) -> tuple[Library, str]:
    from understudy.ui.cli.library_data import find_listed, open_all_libraries
    from understudy.ui.cli.options import import_learner

    listings = open_all_libraries(folder, where, parts, import_learner())
    prefix, name = find_listed(listings, name)
    listing = listings[prefix]
    if name not in listing.opened:
        raise listing.problems[f"{name}.json"]
    return listing.library, name


def _is_for_coordinators(library: Library) -> bool:
    return any(each.order is not None for each in library.kit.behaviors.values())


def _describe(name: str, found: ExportResult) -> dict[str, Any]:
    """Describe an export: bytes by file, ticks of the conformance file, and what could not be exported and why."""
    parts = ("name", "readings", "problem")
    return {
        "name": name,
        "target": found.target,
        "folder": found.folder,
        "files": found.files,
        "ticks": found.ticks,
        "untranslated": [dict(zip(parts, each, strict=True)) for each in found.untranslated],
        "rounded_cuts": found.rounded,
        "notes": found.notes,
    }


def _show(name: str, found: ExportResult) -> None:
    from rich.markup import escape

    from understudy.ui.cli.output import format_count, make_console

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
