"""Whether a scenario can be: whatever is impossible or senseless in it is one error that names the key.

`check_scenario` looks at types first, then numbers, names, places, boxes and signals, squads. A world that passes may
still turn out too crowded while it is laid out, which depends on its seed.
"""

from __future__ import annotations

import msgspec

from understudy.sim.scenario import (
    validate_boxes,
    validate_names,
    validate_numbers,
    validate_places,
    validate_squads,
)
from understudy.sim.scenario.scenario_errors import ScenarioErrors
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario.toml_decode import DecodeProblem, decode_toml_values


def check_scenario(scenario: Scenario) -> None:
    """SettingError where a scenario is impossible or makes no sense."""
    checker = ScenarioErrors(scenario)
    _check_types(checker)
    validate_numbers.check_numbers(checker)
    validate_names.check_scenario_names(checker)
    validate_places.check_places(checker)
    validate_boxes.check_boxes_and_signals(checker)
    validate_squads.check_squad_sorts(checker)


def _check_types(checker: ScenarioErrors) -> None:
    """A scenario built in Python may hold anything: it is held to what a file may hold."""
    try:
        plain = msgspec.to_builtins(checker.scenario)
    except (TypeError, ValueError, OverflowError) as error:
        checker.fail("scenario", f"cannot be: {error}", "give plain numbers, texts, tuples and mappings")
    found = decode_toml_values(plain, Scenario)
    if isinstance(found, DecodeProblem):
        checker.fail(*found)
