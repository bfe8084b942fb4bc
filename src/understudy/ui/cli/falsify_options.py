"""Options of the search for worlds in which a behavior fails."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from understudy.ui.cli.options import (
    FAILURES,
    LIBRARY,
    WORLD,
    Bind,
    CommandOptions,
    KitName,
    LibraryOption,
)

GoalName: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--goal",
        metavar="NAME",
        help="Flag or reading (yes or no) that counts as success on a body of your own.",
        show_default=False,
    ),
]
FalsifiedBehavior: TypeAlias = Annotated[str, typer.Argument(metavar="NAME", help="Name of the behavior.")]


class SearchOptions(CommandOptions):
    """Options of a search in scenarios or on a body of one's own."""

    limit_s: Annotated[
        float | None,
        typer.Option(
            "--limit",
            metavar="SECONDS",
            help="Time limit of each world, in simulated s; the scenario's if left out.",
            show_default=False,
        ),
    ] = None
    seconds: Annotated[
        float,
        typer.Option(
            "--seconds", metavar="S", help="Time to search, in s; half of it at random in scenarios."
        ),
    ] = 60.0
    worlds: Annotated[
        int | None,
        typer.Option(
            "--worlds",
            metavar="N",
            help="Number of worlds to run at random, instead of by time.",
            show_default=False,
        ),
    ] = None
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the search.")] = 0
    jobs: Annotated[
        int,
        typer.Option("--jobs", "-j", metavar="N", min=1, help="Processes for the search at random, at most."),
    ] = 1
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="FOLDER", help="Folder that keeps failing worlds.")
    ] = FAILURES
    bind: Bind = None
    kit: KitName = None


class FalsifyOptions(SearchOptions):
    """Look for worlds in which a behavior misses its goal, or a property fails; keep one, as simple as possible.

    First it runs fresh worlds at random, and gives an exact interval of the share that fails. If none fails, it
    varies places, sizes and disturbances from the worlds that came closest to failing. A failing world is made
    simpler as long as it fails, and kept as a scenario with its seed, a picture, and the decision that went wrong.
    Ctrl-C ends the search; what was found is kept.

    The exit code is 1 if a world failed, 0 if none did, and 2 if something given cannot be used.

    [dim]understudy falsify demo/library forage --seconds 60[/]

    [dim]understudy falsify mine goto --world arena --bind A=red_flag --limit 60[/]

    [dim]understudy falsify demo/library forage --property keeps_clear[/]

    On a body of your own: understudy falsify-body.
    """

    behavior: FalsifiedBehavior
    library: LibraryOption = LIBRARY
    world: Annotated[
        str | None,
        typer.Option(
            "--world",
            "-w",
            metavar="SCENARIO",
            help=f"Scenario to search; that of the property, or {WORLD}, if left out.",
            show_default=False,
        ),
    ] = None
    tested: Annotated[
        str | None,
        typer.Option(
            "--property",
            metavar="PROPERTY",
            help="Property of the library's file that is to fail, instead of the goal.",
            show_default=False,
        ),
    ] = None
    vary: Annotated[
        list[str] | None,
        typer.Option(
            "--vary",
            metavar="WHAT",
            help="What the directed search varies: places, sizes or disturbances; all if left out.",
            show_default=False,
        ),
    ] = None


class FalsifyBodyOptions(SearchOptions):
    """Look for seeds with which a behavior misses its goal on a body of your own, and record a run that fails.

    All the time goes to seeds at random. The exit code is 1 if a run failed, 0 if none did, and 2 if something given
    cannot be used.

    [dim]understudy falsify-body mine balance cart_pole:make --goal truncated --limit 11[/]
    """

    behavior: FalsifiedBehavior
    library: LibraryOption = LIBRARY
    world: Annotated[
        str,
        typer.Argument(
            metavar="MODULE:NAME", help="Function that makes the body, or a Gymnasium environment."
        ),
    ]
    goal: GoalName = None
