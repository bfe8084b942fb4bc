"""Check of a command of another package."""

from __future__ import annotations

import json
import re

from click.testing import CliRunner

from understudy.testing.laws import require, require_call
from understudy.ui.cli.command_group import CommandTable
from understudy.ui.cli.main import COMMANDS
from understudy.ui.cli.plugins import HEADINGS, RARE, CommandEntry

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
    law = f"its panel is one of {[*HEADINGS, RARE]}"
    require(entry.panel in (*HEADINGS, RARE), part, law, f"it is {entry.panel!r}")
    law = "its function or typer application can be imported"
    command = require_call(part, law, lambda: CommandTable([entry]).load(entry))
    require(bool(command.help), part, "it has a docstring or a help text", "it has none")
    helped = CliRunner().invoke(command, ["--help"])
    require(helped.exit_code == 0, part, "--help succeeds", f"it ended with {helped.exit_code}")
    refused = CliRunner().invoke(command, ["--no-such-option"])
    law = "an unknown option is refused with exit code 2"
    require(refused.exit_code == 2, part, law, f"it ended with {refused.exit_code}")
    if arguments:
        done = CliRunner().invoke(command, list(arguments))
        law = f"it succeeds with {' '.join(arguments)}"
        require(done.exit_code == 0, part, law, f"it ended with {done.exit_code}: {done.exception!r:.60}")
        if "--json" in arguments:
            require_call(part, "with --json it prints JSON", lambda: json.loads(done.stdout))
