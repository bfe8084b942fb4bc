"""The commands put together: a file each, all of which import what they use only when called."""

from __future__ import annotations

from typing import Annotated

import typer

from understudy.cli import (
    advise,
    bench,
    check,
    demo,
    diff,
    evaluate,
    experiment,
    learn,
    libraries,
    robots,
    run,
    show,
    simplify,
    studio,
    teach,
    validate,
    why,
    worlds,
)
from understudy.cli.failing import Group

TEACHING, RUNNING, LIBRARY, LAB = "Teach", "Run", "Look into a library", "Measure"

app = typer.Typer(
    cls=Group,
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Begin with [bold]understudy demo[/]. Every command has --help, and --json for programs to read.",
)


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import PackageNotFoundError, version

        try:
            typer.echo(f"understudy {version('understudy')}")
        except PackageNotFoundError:
            typer.echo("understudy, from a folder where it is not installed")
        raise typer.Exit


@app.callback()
def understudy(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and end.")
    ] = False,
    debug: Annotated[
        bool, typer.Option("--debug", help="On an error, show where in the program it arose.")
    ] = False,
) -> None:
    """Train robots, and teams of robots, by being shown."""


app.command("demo", rich_help_panel=TEACHING)(demo.demo)
app.command("studio", rich_help_panel=TEACHING)(studio.studio)
app.command("teach", rich_help_panel=TEACHING)(teach.teach)
app.command("learn", rich_help_panel=TEACHING)(learn.learn)
app.command("advise", rich_help_panel=TEACHING)(advise.advise)
app.command("run", rich_help_panel=RUNNING)(run.run)
app.command("why", rich_help_panel=RUNNING)(why.why)
app.command("eval", rich_help_panel=RUNNING)(evaluate.evaluate)
app.command("worlds", rich_help_panel=RUNNING)(worlds.worlds)
app.add_typer(robots.app, name="robots", rich_help_panel=RUNNING)
app.command("list", rich_help_panel=LIBRARY)(libraries.list_)
app.command("show", rich_help_panel=LIBRARY)(show.show)
app.command("diff", rich_help_panel=LIBRARY)(diff.diff)
app.command("validate", rich_help_panel=LIBRARY)(validate.validate)
app.command("test", rich_help_panel=LIBRARY)(check.check)
app.command("simplify", rich_help_panel=LIBRARY)(simplify.simplify)
app.command("rebuild", rich_help_panel=LIBRARY)(libraries.rebuild)
app.command("experiment", rich_help_panel=LAB)(experiment.experiment)
app.add_typer(bench.app, name="bench", rich_help_panel=LAB)
