"""Options of the commands that show, test and change libraries."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from understudy.ui.cli.options import (
    LIBRARY,
    WORLD,
    Bind,
    CommandOptions,
    FoundWorld,
    KitName,
    LibraryOption,
    LibraryOptions,
)

AutomatonNames: TypeAlias = Annotated[
    list[str] | None, typer.Argument(metavar="[NAME]...", help="Names of automata; all if left out.")
]


class FailOn(StrEnum):
    """The least severity of a finding for which the exit code is 1."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"
    NEVER = "never"


class AdviseOptions(LibraryOptions):
    """Suggest what to show next in a lesson, most useful first.

    With --world, the automaton runs in new worlds, and what made it go wrong there comes first; situations are taken
    from that world, and features that the lesson left out are tried on contradictions. Without it, situations are made
    up from the examples.

    [dim]understudy advise goto --library demo/library --world forage[/]
    """

    name: Annotated[str, typer.Argument(help="Name of the automaton.")]
    bind: Bind = None
    most: Annotated[int, typer.Option("--most", min=1, help="Maximum number of suggestions.")] = 8


class ListOptions(LibraryOptions):
    """List the automata of a library; those of squads and robot types are named SORT/NAME.

    [dim]understudy list --library demo/library[/]
    """


class RebuildOptions(CommandOptions):
    """Relearn and save automata whose stored trees no longer match their examples.

    This is needed after a document was edited by hand, or with a new version of the learner. The former version is
    kept.
    """

    names: AutomatonNames = None
    library: LibraryOption = LIBRARY
    world: FoundWorld = None
    kit: KitName = None


class ShowOptions(LibraryOptions):
    """Show an automaton: its states, its features, the conditions it learned, and its examples.

    [dim]understudy show goto --library demo/library[/]
    """

    name: Annotated[
        str, typer.Argument(help="Name of the automaton; SORT/NAME for one of a squad or robot type.")
    ]
    everything: Annotated[bool, typer.Option("--all", help="List all examples, including watched ones.")] = (
        False
    )


class DrawOptions(LibraryOptions):
    """Draw an automaton: its states as a graph, and in words when it switches between them.

    [dim]understudy draw goto --library demo/library -o goto.svg[/]
    """

    name: Annotated[
        str, typer.Argument(help="Name of the automaton; SORT/NAME for one of a squad or robot type.")
    ]
    out: Annotated[
        Path,
        typer.Option(
            "--out", "-o", metavar="FILE", help="File to write: .svg, .pdf, .png or .dot (Graphviz)."
        ),
    ]
    children: Annotated[
        bool, typer.Option("--children", help="Draw the automata that its states run, too, level by level.")
    ] = False
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file if it exists.")] = False


class DiffOptions(LibraryOptions):
    """Show what changed between two versions of an automaton, and which examples caused it.

    [dim]understudy diff goto --from 1 --to 3 --library demo/library[/]
    """

    name: Annotated[str, typer.Argument(help="Name of the automaton.")]
    before: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="VERSION|FILE",
            help="Version to compare from; the last former version if left out.",
        ),
    ] = None
    after: Annotated[
        str | None,
        typer.Option(
            "--to", metavar="VERSION|FILE", help="Version to compare to; the current version if left out."
        ),
    ] = None
    everything: Annotated[bool, typer.Option("--all", help="List all examples that changed.")] = False


class SimplifyOptions(LibraryOptions):
    """Show an automaton with fewer questions: its conditions before and after, and the decisions that change.

    Nothing is saved without --keep. To undo a saved simplification, use --pruning 0 --keep.

    [dim]understudy simplify goto --library demo/library[/]
    """

    name: Annotated[str, typer.Argument(help="Name of the automaton.")]
    pruning: Annotated[
        float | None,
        typer.Option(
            "--pruning",
            "-p",
            min=0,
            help="Keep a question only if each of its leaves corrects more than this many examples; 0 undoes pruning.",
            show_default=False,
        ),
    ] = None
    keep: Annotated[
        bool,
        typer.Option(
            "--keep", help="Save the simplified automaton, with the pruning as an option of its lesson."
        ),
    ] = False


class ValidateOptions(CommandOptions):
    """Check a library: open every file, resolve every name, and examine every lesson.

    The exit code is 2 if there are problems. Notes do not change it.

    [dim]understudy validate --library demo/library[/]
    """

    names: AutomatonNames = None
    library: LibraryOption = LIBRARY
    world: Annotated[
        str,
        typer.Option("--world", "-w", metavar="SCENARIO", help="Scenario that defines the kit."),
    ] = WORLD
    kit: KitName = None


class LibraryTestOptions(CommandOptions):
    """Test a library: every recorded moment of its lessons, every property, and failing worlds.

    Each automaton is compared with its last former version. Properties are those stored in lessons, and those of the
    file properties.toml in the library's folder. Failing worlds are those that understudy falsify kept in a folder. The
    exit code is 1 if something that worked no longer does, or if a property fails, or if a failing world still does.

    [dim]understudy test demo/library[/]

    [dim]understudy test demo/library --failures failures[/]
    """

    library: LibraryOption = LIBRARY
    world: FoundWorld = None
    failures: Annotated[
        Path | None,
        typer.Option(
            "--failures",
            metavar="FOLDER",
            help="Folder of failing worlds, all of which are run again.",
            show_default=False,
        ),
    ] = None
    jobs: Annotated[
        int, typer.Option("--jobs", "-j", metavar="N", min=1, help="Processes to share the tests, at most.")
    ] = 1
    strict: Annotated[
        bool, typer.Option("--strict", help="Fail, too, if a property is undecided: its worlds are too few.")
    ] = False
    kit: KitName = None


class CheckOptions(CommandOptions):
    """Find what can go wrong with automata from their trees and examples.

    States never entered or left, dead ends, flags never raised, switches that undo each other, branches without
    examples, and more. With --world, errors and warnings are tried there, and say how often they happen. The exit code
    is 0 if there is no finding at or above --fail-on, 1 if there is one, and 2 if the library cannot be used.

    [dim]understudy check demo/library --world forage[/]
    """

    names: AutomatonNames = None
    library: LibraryOption = LIBRARY
    world: Annotated[
        str | None,
        typer.Option(
            "--world",
            "-w",
            metavar="SCENARIO",
            help="Scenario whose sensors, squads and tick length are assumed; nothing is assumed if left out.",
            show_default=False,
        ),
    ] = None
    worlds: Annotated[
        int,
        typer.Option(
            "--worlds",
            min=0,
            metavar="N",
            help="Number of new worlds of --world in which errors and warnings are tried; 0: none.",
        ),
    ] = 30
    kit: KitName = None
    fail_on: Annotated[
        FailOn, typer.Option("--fail-on", help="Exit with 1 at a finding of this severity or above.")
    ] = FailOn.ERROR
    everything: Annotated[
        bool,
        typer.Option(
            "--all",
            help="List every cell of one example, every assumption, and how to show what never happened.",
        ),
    ] = False
