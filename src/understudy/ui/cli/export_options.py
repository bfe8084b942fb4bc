"""Options of the commands that export automata, lessons and runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from understudy.addons.export.targets.target_table import list_targets
from understudy.errors import join_names
from understudy.ui.cli.options import LIBRARY, Bind, CommandOptions, FoundWorld, KitName, LibraryOption

TableName: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--table",
        metavar="TABLE",
        help="Table: examples, ticks, presses or episodes. By default the examples of a lesson, otherwise ticks.",
        show_default=False,
    ),
]


class ExportOptions(CommandOptions):
    """Export an automaton with everything below it, so that it runs without Understudy and decides the same.

    The folder gets the code, a manifest of what it reads and commands, and rows of readings with the decisions of
    Understudy, on which `make test` runs the exported code.

    [dim]understudy export automaton forage --library demo/library --to c99 --out forage-c[/]

    [dim]understudy export automaton goto --bind A=station --library demo/library --to python --out goto-python[/]

    [dim]understudy export automaton servo --library library --to ros2 --robot rover.toml --out servo-ros2[/]
    """

    name: Annotated[
        str, typer.Argument(help="Name of the automaton; SORT/NAME for one of a squad or robot type.")
    ]
    to: Annotated[
        str,
        typer.Option("--to", metavar="TARGET", help=f"Target: {join_names(list_targets(), word='or')}."),
    ]
    out: Annotated[
        Path,
        typer.Option("--out", "-o", metavar="DIR", help="Folder to write: new, empty, or an earlier export."),
    ]
    library: LibraryOption = LIBRARY
    bind: Bind = None
    float32: Annotated[
        bool,
        typer.Option(
            "--float32", help="Single precision, and times in milliseconds, for small microcontrollers (c99)."
        ),
    ] = False
    world: FoundWorld = None
    kit: KitName = None
    robot: Annotated[
        Path | None,
        typer.Option(
            "--robot",
            metavar="FILE",
            help="File of the robot to export for; ros2 needs it.",
            show_default=False,
        ),
    ] = None
    run: Annotated[
        list[Path] | None,
        typer.Option(
            "--run",
            metavar="FILE",
            help="Recorded run on whose readings the code is tried, too; may be given several times.",
            show_default=False,
        ),
    ] = None


class ExportTableOptions(CommandOptions):
    """Export the data of a lesson, a session or a run as a table.

    Lessons and journals have examples; journals, recordings and traces have ticks (states, readings and commands),
    presses and episodes. Parquet needs the extra parquet.

    [dim]understudy export table library/goto.json --out goto.csv[/]

    [dim]understudy export table run.jsonl --out ticks.parquet[/]

    [dim]understudy export table drive.mcap --table presses --out presses.csv[/]
    """

    source: Annotated[
        Path,
        typer.Argument(
            metavar="SOURCE",
            help="Automaton's document, table of examples, journal, recording or trace.",
            show_default=False,
        ),
    ]
    out: Annotated[
        Path,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE",
            help="File to write, ending in .csv, .jsonl or .parquet; a new one.",
        ),
    ]
    table: TableName = None


class ExportDatasetOptions(CommandOptions):
    """Export runs as a data set of demonstrations.

    LeRobot needs the extra parquet, Minari the extra minari.

    [dim]understudy export dataset one.mcap two.mcap --to lerobot --out drives[/]
    """

    sources: Annotated[
        list[Path],
        typer.Argument(metavar="SOURCE...", help="Journals, recordings or traces.", show_default=False),
    ]
    to: Annotated[str, typer.Option("--to", metavar="FORMAT", help="Format: lerobot or minari.")]
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FOLDER", help="Folder to write; a new one.")]


class ExportWhyOptions(CommandOptions):
    """Explain every switch in a trace of exported code, or all decisions of the tick at --time.

    [dim]understudy export why trace.csv --library demo/library[/]
    """

    trace: Annotated[
        Path, typer.Argument(metavar="TRACE", help="Trace that exported code wrote.", show_default=False)
    ]
    time: Annotated[
        float | None,
        typer.Option(
            "--time", "-t", min=0, help="Time of a tick, in the unit of the trace.", show_default=False
        ),
    ] = None
    library: LibraryOption = LIBRARY
    world: Annotated[
        str | None, typer.Option("--world", "-w", metavar="SCENARIO", help="Scenario of the library.")
    ] = None
    exported: Annotated[bool, typer.Option("--exported", hidden=True)] = True
    agent: Annotated[str, typer.Option("--agent", "-a", hidden=True)] = ""
    kit: KitName = None
