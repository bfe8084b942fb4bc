"""The ties between features that a scenario guarantees: ranges of its sensors, and readings that go together."""

from __future__ import annotations

from understudy.model.library import Library
from understudy.sim.scenario.schema import Scenario
from understudy.verification.ties import Tie


def list_scenario_ties(scenario: Scenario, library: Library) -> list[Tie]:
    """List the ties between the features that a library's automata use in a scenario."""
    return []
