"""`understudy prepare`: kernels are compiled ahead of time."""

from __future__ import annotations

import json

from tests.ui.cli.commands import run

from understudy.jit.cache import find_cache_folder


def test_scenarios_are_prepared() -> None:
    result = run("prepare", "arena", "--json")
    assert result.exit_code == 0
    found = json.loads(result.stdout)
    assert found["worlds"] == ["arena"]
    assert found["folder"] == str(find_cache_folder())
    assert "Prepared 1 scenario in" in run("prepare", "arena").stdout


def test_an_unknown_scenario_is_named_before_anything_is_compiled() -> None:
    result = run("prepare", "arena", "moon")
    assert result.exit_code == 2
    assert "moon" in result.stderr
