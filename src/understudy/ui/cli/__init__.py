"""Command line of Understudy: parses arguments, and connects sessions, libraries, worlds and pictures."""

from __future__ import annotations

import io
import sys

INTERRUPTED = 130


def run_command_line() -> None:
    """Run the command that the arguments name, and end the process with its exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that has no ✓ shows ?
    try:
        from understudy.ui.cli.main import make_command_line

        make_command_line(sys.argv[1:])(prog_name="understudy")
    except KeyboardInterrupt:  # before a command began, or after it ended
        sys.exit(INTERRUPTED)


__all__ = ["run_command_line"]
