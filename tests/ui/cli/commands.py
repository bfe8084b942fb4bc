"""What the tests of the commands share: running one, here and now, and what it said."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from understudy.ui.cli.main import make_command_line

ROOT = Path(__file__).parents[3]


def run(*arguments: object, monkeypatch: pytest.MonkeyPatch | None = None) -> Result:
    given = [str(argument) for argument in arguments]
    if monkeypatch is not None:
        monkeypatch.setattr(sys, "argv", ["understudy", *given])
    return CliRunner(env={"COLUMNS": "80", "NO_COLOR": "1", "TERM": "dumb"}).invoke(
        make_command_line(), given
    )


def run_json(*arguments: object) -> Any:
    result = run(*arguments, "--json")
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)
