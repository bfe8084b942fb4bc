"""Check of a command of another package."""

from __future__ import annotations

import json
import re
from pkgutil import resolve_name

import typer
from typer.testing import CliRunner

from understudy.testing.laws import require, require_call
from understudy.ui.cli.main import COMMANDS
from understudy.ui.cli.plugins import PANELS, CommandEntry

NAME = re.compile(r"[a-z][a-z0-9-]*( [a-z][a-z0-9-]*)*")


def check_command(entry: CommandEntry, *arguments: str) -> None:
    """Check that a command can be added to `understudy`, that it has help, and that it refuses an unknown option.

    Parameters
    ----------
    entry
        The command.
    *arguments
        Arguments with which it must succeed; what it prints with --json must be JSON. If left out, it is not run.

    Raises
    ------
    LawBroken
        If the command breaks a rule.
    """
    law = "it is a CommandEntry"
    require(isinstance(entry, CommandEntry), "command", law, f"it is a {type(entry).__name__}")
    part = f"command {entry.name!r}"
    require(bool(NAME.fullmatch(entry.name)), part, "its name is words of a-z, 0-9 and -", "it is not")
    builtin = [each.name for each in COMMANDS]
    require(entry.name not in builtin, part, "no built-in command has its name", "one has it")
    require(entry.panel in PANELS, part, f"its panel is one of {list(PANELS)}", f"it is {entry.panel!r}")
    law = "its function or typer application can be imported"
    run = require_call(
        part, law, lambda: resolve_name(entry.run) if isinstance(entry.run, str) else entry.run
    )
    require(callable(run), part, law, f"it is a {type(run).__name__}")
    app = run if isinstance(run, typer.Typer) else typer.Typer(add_completion=False)
    if app is not run:
        app.command()(run)
    helped = CliRunner().invoke(app, ["--help"])
    require(helped.exit_code == 0, part, "--help succeeds", f"it ended with {helped.exit_code}")
    require(bool(typer.main.get_command(app).help), part, "it has a docstring or a help text", "it has none")
    refused = CliRunner().invoke(app, ["--no-such-option"])
    law = "an unknown option is refused with exit code 2"
    require(refused.exit_code == 2, part, law, f"it ended with {refused.exit_code}")
    if arguments:
        done = CliRunner().invoke(app, list(arguments))
        law = f"it succeeds with {' '.join(arguments)}"
        require(done.exit_code == 0, part, law, f"it ended with {done.exit_code}: {done.exception!r:.60}")
        if "--json" in arguments:
            require_call(part, "with --json it prints JSON", lambda: json.loads(done.stdout))
