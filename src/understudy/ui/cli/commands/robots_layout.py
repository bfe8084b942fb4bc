"""Command `understudy robots layout`: write a layout with which Foxglove shows robots and their recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from understudy.ui.cli.options import Json


def write_layout(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="File of a robot or a team.", show_default=False)
    ],
    as_json: Json = False,
) -> None:
    """Print a layout for Foxglove: the path, states, stops and diagnostics of a robot or of a team.

    Write it to a file and import that in Foxglove: Layouts > Import from file. It is JSON, with `--json` in one line.

    [dim]understudy robots layout rover.toml > rover.foxglove.json[/]
    """
    import msgspec

    from understudy.robots.recording.foxglove_layout import make_layout
    from understudy.robots.robot_file import list_robot_files, load_robot

    layout = make_layout([load_robot(each) for each in list_robot_files(file)])
    written = msgspec.json.encode(layout)
    typer.echo((written if as_json else msgspec.json.format(written, indent=2)).decode())
