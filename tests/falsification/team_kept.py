"""A failing world of a team in a folder, with the libraries in which it fails, for the trainers' tests."""

from __future__ import annotations

from pathlib import Path

import msgspec
from tests.falsification.test_team_failure import SEED, WRONG_S, make_failing
from tests.sim.patrollers import ROBOTS, SCENARIO

from understudy.addons.checks.falsification.failing_world import FACTS_FILE, SCENARIO_FILE
from understudy.judging.properties.property_file import HEAD
from understudy.model.library import TrainedAutomaton
from understudy.sim.scenario.files import format_scenario
from understudy.storage.library_folder import save_automaton

PROPERTY = f"""
[touches]
behavior = "lead"
world = "patrol"
seeds = [{SEED}]
always = "distance(robot, robot) is below 1 mm"
within_s = {WRONG_S}
"""
"""It fails in every world, at that time."""


def keep_team(folder: Path, lead: TrainedAutomaton) -> Path:
    """Write the libraries and the failing world patrol-1 to a folder; return the libraries' folder."""
    library, failure = folder / "library", folder / "failures" / "patrol-1"
    for taught in ROBOTS.taught.values():
        save_automaton(library, taught)
    save_automaton(library / "patrol", lead)
    (library / "properties.toml").write_text(HEAD + PROPERTY)
    failure.mkdir(parents=True)
    (failure / SCENARIO_FILE).write_text(format_scenario(SCENARIO))
    facts = msgspec.structs.replace(make_failing().facts, property="touches", why=("They never touch.",))
    (failure / FACTS_FILE).write_bytes(msgspec.json.encode(facts))
    return library
