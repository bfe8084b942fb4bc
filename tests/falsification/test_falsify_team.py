"""A team with a coordinator is falsified from the command line: found, made simpler, replayed, and explained."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.falsification.team_kept import keep_team
from tests.falsification.test_team_failure import teach_lead
from tests.ui.cli.commands import run

from understudy.addons.checks.falsification.failing_world import FailingWorld, read_failing_world
from understudy.addons.checks.falsification.failure_replay import compute_end_hash
from understudy.addons.checks.falsification.property_measure import PropertyMeasure
from understudy.addons.checks.falsification.rerun_failures import rerun_failing_worlds
from understudy.judging.properties.property_file import HEAD, load_properties
from understudy.judging.properties.run_property import make_property_task
from understudy.sim.team.libraries import make_scenario_team
from understudy.sim.world import World
from understudy.ui.cli.named_inputs import open_team_libraries

NEAR_M = 0.7
PROPERTY = f"""
[keeps_away]
behavior = "lead"
world = "patrol"
seeds = 20
never = "distance(robot, home) is below {NEAR_M} m"
limit_s = 60.0
"""


@pytest.fixture(scope="module")
def falsification(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """The library, and what the command says: the team is sent home, and so comes near it."""
    folder = tmp_path_factory.mktemp("team")
    library = keep_team(folder, teach_lead())
    (library / "properties.toml").write_text(HEAD + PROPERTY)
    out = folder / "found"
    options = ("--property", "keeps_away", "--worlds", 6, "--limit", 60, "-o", out, "--json")
    result = run("falsify", library, "lead", *options)
    assert result.exit_code == 1, result.output
    return library, json.loads(result.stdout)


def measure_distances(library: Path, kept: FailingWorld, time_s: float) -> list[float]:
    """How far each robot is from home at a time, in a run of the team without the search, m."""
    scenario = kept.trial.scenario
    world = World(scenario, [kept.trial.seed])
    libraries = open_team_libraries(scenario, "lead", library, world.kit)
    team = make_scenario_team(world, scenario, libraries, {"patrol": ("lead", {})}, seeds=[kept.trial.seed])
    for _ in range(round(time_s / scenario.tick_s)):
        team.tick()
    view = world.view()
    home = view.objects.kind == view.names.classes.index("home")
    (x,), (y,) = view.objects.x[home], view.objects.y[home]
    return [float(each) for each in np.hypot(view.robots.x - x, view.robots.y - y)]


def test_the_robot_that_made_it_fail_is_explained(falsification: tuple[Path, dict[str, Any]]) -> None:
    """A tick before the moment none is near; at the moment only the explained robot is, where the record says."""
    library, told = falsification
    kept = read_failing_world(told["failure"]["folder"])
    assert (kept.facts.behavior, kept.facts.property) == ("lead", "keeps_away")
    tick_s = kept.trial.scenario.tick_s
    before = measure_distances(library, kept, kept.facts.wrong_s - tick_s)
    after = measure_distances(library, kept, kept.facts.wrong_s)
    assert min(before) >= NEAR_M
    assert [number for number, each in enumerate(after) if each < NEAR_M] == [kept.facts.robot]
    assert any("lead" in sentence for sentence in kept.facts.why)


def test_it_replays_bit_for_bit(falsification: tuple[Path, dict[str, Any]]) -> None:
    library, told = falsification
    kept = read_failing_world(told["failure"]["folder"])
    scenario = kept.trial.scenario
    libraries = open_team_libraries(scenario, "lead", library, World(scenario).kit)
    (subject,) = load_properties(library / "properties.toml")
    measure = PropertyMeasure(
        make_property_task(subject, libraries, scenario), kept.facts.limit_s, subject=subject
    )
    assert measure([kept.trial]).failed[0]
    assert compute_end_hash(measure, kept.trial) == kept.facts.end_hash
    (again,) = rerun_failing_worlds([kept], libraries, properties=[subject])
    assert again.has_failed
    assert again.robustness == pytest.approx(kept.facts.robustness)


def test_it_is_made_simpler(falsification: tuple[Path, dict[str, Any]]) -> None:
    """Obstacles have no part in it, and all robots stay, since a coordinator counts them."""
    _, told = falsification
    kept = read_failing_world(told["failure"]["folder"])
    assert "all obstacles left out" in told["failure"]["steps"]
    assert not kept.trial.scenario.obstacles
    assert sum(len(group.at) for group in kept.trial.scenario.robots if isinstance(group.at, tuple)) == 4
