"""Command `understudy robots layout`: write a layout with which Foxglove shows robots and their recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def write_layout(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="File of a robot or a team.", show_default=False)
    ],
) -> None:
    """Print a layout for Foxglove: the path, states, stops and diagnostics of a robot or of a team.

    Write it to a file and import that in Foxglove: Layouts > Import from file.

    [dim]understudy robots layout rover.toml > rover.foxglove.json[/]
    """
    import msgspec

    from understudy.robots.recording.foxglove_layout import make_layout
    from understudy.robots.robot_file import list_robot_files, load_robot

    layout = make_layout([load_robot(each) for each in list_robot_files(file)])
    typer.echo(msgspec.json.format(msgspec.json.encode(layout), indent=2).decode())
