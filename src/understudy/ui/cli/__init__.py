"""Command line of Understudy: parses arguments, and connects sessions, libraries, worlds and pictures."""

from __future__ import annotations

import io
import sys

FAULT, INTERRUPTED = 70, 130
"""Exit codes for a fault in Understudy itself and for Ctrl-C; 2 means wrong input, 1 an unfavorable result."""


def run_command_line() -> None:
    """Run the command that the arguments name, and end the process with its exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that has no ✓ shows ?
    try:
        from understudy.ui.cli.main import make_command_line

        make_command_line()(prog_name="understudy")
    except KeyboardInterrupt:  # before a command began, or after it ended
        sys.exit(INTERRUPTED)


__all__ = ["run_command_line"]
