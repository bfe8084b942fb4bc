"""`understudy robots`: real robots, looked at before they move."""

from __future__ import annotations

import typer

from understudy.cli import robot_color

app = typer.Typer(no_args_is_help=True, help="Look at real robots and at what their cameras see.")


@app.callback()
def robots() -> None:
    """Look at real robots and at what their cameras see."""


app.command("color")(robot_color.color)
