"""Options of the commands that learn from recordings of driven robots."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

DriverNames: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--driver",
        metavar="NAME",
        help="Name of the driver of each recording, in their order; those of their files if left out.",
    ),
]
TrustedDriver: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--trust",
        metavar="NAME",
        help="Driver who is right where drivers contradict each other: such examples of others are left out.",
    ),
]
MapFile: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--map",
        metavar="MAP.toml",
        help="Which columns, or fields of messages, of a recording are readings and commands.",
    ),
]
DrivenBehaviors: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--behaviors",
        metavar="A,B(C)",
        help="Behaviors and automata that may explain the commands of a recording without presses.",
    ),
]
DrivenFeatures: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--features",
        metavar="A,B(C)",
        help="Features that decisions depend on; those of a drive also help to find when its driver switched.",
    ),
]
RecordedTargets: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--targets",
        metavar="A=TARGET",
        help="Targets of the parameters during the recording; a drive to them teaches to drive to any.",
    ),
]
RecordedAgent: TypeAlias = Annotated[
    int, typer.Option("--agent", "-a", min=0, help="Index of the robot in the recording, from 0.")
]
