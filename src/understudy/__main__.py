"""Run the command line with `python -m understudy`."""

from understudy.ui.cli import run_command_line

run_command_line()
