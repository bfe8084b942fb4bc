"""Assembly of all commands; each module imports its dependencies only when its command is called."""

from __future__ import annotations

from typing import Annotated

import typer

from understudy import __version__
from understudy.ui.cli.commands import (
    advise,
    diff,
    eval,
    learn,
    list,
    prepare,
    robots,
    run,
    show,
    simplify,
    studio,
    teach,
    test,
    validate,
    why,
    worlds,
)
from understudy.ui.cli.error_reporting import ErrorReportingGroup
from understudy.ui.cli.plugins import LIBRARY, RUNNING, TEACHING, CommandEntry, load_plugins, order_commands

app = typer.Typer(
    cls=ErrorReportingGroup,
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Start with [bold]understudy demo[/]. Every command has --help, and --json for output to programs.",
)


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"understudy {__version__}")
        raise typer.Exit


@app.callback()
def understudy(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    """Train robots, and teams of robots, by being shown."""


COMMANDS = (
    CommandEntry("studio", studio.start_studio, TEACHING),
    CommandEntry("teach", teach.teach, TEACHING),
    CommandEntry("learn", learn.learn_lesson, TEACHING),
    CommandEntry("advise", advise.advise, TEACHING),
    CommandEntry("run", run.run_behavior, RUNNING),
    CommandEntry("why", why.show_explanation, RUNNING),
    CommandEntry("eval", eval.evaluate_behavior, RUNNING),
    CommandEntry("worlds", worlds.list_worlds, RUNNING),
    CommandEntry("prepare", prepare.prepare, RUNNING),
    CommandEntry("robots", robots.app, RUNNING),
    CommandEntry("list", list.list_automata, LIBRARY),
    CommandEntry("show", show.show_automaton, LIBRARY),
    CommandEntry("diff", diff.show_diff, LIBRARY),
    CommandEntry("validate", validate.validate, LIBRARY),
    CommandEntry("test", test.run_library_tests, LIBRARY),
    CommandEntry("simplify", simplify.simplify, LIBRARY),
    CommandEntry("rebuild", list.rebuild, LIBRARY),
)

for command in order_commands(COMMANDS, load_plugins()):
    command.add_to(app)
