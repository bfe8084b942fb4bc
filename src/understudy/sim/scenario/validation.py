"""Check scenarios: anything impossible or contradictory in one raises an error that names the key.

`check_scenario` checks types first, then numbers, names, places, boxes and signals, and squads. A scenario that
passes can still be too crowded for some seeds, which is found when a world is laid out.
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
    """Raise SettingError, naming the key, if a scenario is impossible or contradicts itself."""
    checker = ScenarioErrors(scenario)
    _check_types(checker)
    validate_numbers.check_numbers(checker)
    validate_names.check_scenario_names(checker)
    validate_places.check_places(checker)
    validate_boxes.check_boxes_and_signals(checker)
    validate_squads.check_squad_sorts(checker)


def _check_types(checker: ScenarioErrors) -> None:
    """Raise SettingError if a scenario made in Python contains a value of a type that a file could not contain."""
    try:
        plain = msgspec.to_builtins(checker.scenario)
    except (TypeError, ValueError, OverflowError) as error:
        checker.fail("scenario", f"cannot be: {error}", "give plain numbers, texts, tuples and mappings")
    decoded = decode_toml_values(plain, Scenario)
    if isinstance(decoded, DecodeProblem):
        checker.fail(*decoded)
