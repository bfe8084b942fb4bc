"""So that `python -m understudy.ui.cli` is the command line too."""

from understudy.ui.cli import run_command_line

run_command_line()
