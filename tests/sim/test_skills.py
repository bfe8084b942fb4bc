"""Stand-ins for skills in simulated worlds: they take their time, and end as the scenario says."""

from __future__ import annotations

from copy import deepcopy
from math import isnan
from pathlib import Path

import msgspec
import numpy as np
import pytest

from understudy.errors import SettingError, UnknownName
from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.runtime.run_loop import Run
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario.skill_schema import SkillStandIn
from understudy.sim.scenario.validation import check_scenario
from understudy.sim.world import World
from understudy.testing import check_body, check_world

SCENARIO_FILE = Path(__file__).with_name("skilled.toml")
SCENARIO = load_scenario(SCENARIO_FILE)
OUTCOMES = ("succeeded", "aborted", "rejected", "timed_out")


def change_skill(skill: str, **changes: object) -> Scenario:
    """The scenario with another skill."""
    kind = SCENARIO.types["rover"]
    skills = {**kind.skills, skill: msgspec.structs.replace(kind.skills[skill], **changes)}
    return msgspec.structs.replace(SCENARIO, types={"rover": msgspec.structs.replace(kind, skills=skills)})


def tick(world: World, skill: str = "", issued: float = 0.0, **binding: str) -> None:
    number = world.index_skill(skill, binding) if skill else 0
    world.act({"skill": np.full(world.agents, float(number)), "issued": np.full(world.agents, issued)})


def read(world: World, name: str) -> float:
    return float(world.sense([(name, None)])[name, None][0])


def outcomes(world: World, skill: str = "go_to") -> list[str]:
    return [each for each in OUTCOMES if read(world, f"{skill}_{each}") > 0]


def test_a_scenario_with_skills_keeps_the_laws_of_bodies_and_worlds() -> None:
    check_body(World(SCENARIO))
    check_world(lambda seeds: World(SCENARIO, seeds))


def test_its_kit_has_a_behavior_and_features_for_each_skill() -> None:
    kit = make_scenario_kit(SCENARIO)
    assert kit.behaviors["go_to"].parameters == ("A",)
    assert [dict(kit.behaviors[name].command) for name in ("go_to", "beep")] == [
        {"skill": 1.0},
        {"skill": 2.0},
    ]
    assert {"go_to_succeeded", "go_to_distance_remaining", "beep_aborted"} <= set(kit.features)


def test_it_drives_to_its_target_and_succeeds_once() -> None:
    """3 s of 0.1 s ticks from x = 2 to 0.5 m before the dock at x = 7."""
    world = World(SCENARIO)
    assert isnan(read(world, "go_to_distance_remaining"))
    for done in range(1, 31):
        assert outcomes(world) == []
        tick(world, "go_to", A="dock")
        assert world.state.robots["x"][0] == pytest.approx(2 + 4.5 * done / 30)
        assert read(world, "go_to_distance_remaining") == pytest.approx(5 - 4.5 * done / 30)
        assert isnan(read(world, "go_to_number_of_recoveries"))
    for _ in range(5):
        assert outcomes(world) == ["succeeded"]
        tick(world, "go_to", A="dock")
    tick(world, "go_to", issued=3.5, A="home")
    assert outcomes(world) == []
    assert world.state.robots["x"][0] == pytest.approx(6.5 - 5 / 30)


def test_a_state_that_is_left_ends_it_where_it_is() -> None:
    world = World(SCENARIO)
    for _ in range(15):
        tick(world, "go_to", A="dock")
    for _ in range(5):
        tick(world)
    assert world.state.robots["x"][0] == pytest.approx(2 + 4.5 / 2)
    assert outcomes(world) == []


@pytest.mark.parametrize(
    ("changes", "outcome"),
    [({"success": 0.0}, "aborted"), ({"timeout_s": 1.0}, "timed_out"), ({"ends": "dock"}, "succeeded")],
)
def test_it_ends_as_the_scenario_says(changes: dict[str, object], outcome: str) -> None:
    world = World(change_skill("go_to", **changes))
    for _ in range(40):
        tick(world, "go_to", A="home")
    assert outcomes(world) == [outcome]


def test_a_target_that_is_not_there_rejects_the_goal() -> None:
    world = World(SCENARIO)
    world.remove_object(0)
    tick(world, "go_to", A="dock")
    assert (outcomes(world), world.state.robots["x"][0]) == (["rejected"], 2.0)


def test_it_succeeds_as_often_as_declared_and_takes_as_long() -> None:
    world = World(SCENARIO, range(400))
    ends = np.full(400, -1)
    for now in range(1, 12):
        tick(world, "beep")
        read_now = world.sense([("beep_succeeded", None)])["beep_succeeded", None]
        ends[(read_now > 0) & (ends < 0)] = now
    assert np.mean(ends > 0) == pytest.approx(0.5, abs=0.08)
    assert (ends[ends > 0].min(), ends.max()) == (2, 10)


def test_a_world_that_is_restored_or_copied_goes_on_the_same() -> None:
    world = World(SCENARIO, [5])
    for _ in range(7):
        tick(world, "go_to", A="dock")
    kept, other = world.snapshot(), deepcopy(world)
    for each in (world, other):
        for _ in range(7):
            tick(each, "go_to", A="dock")
    after = world.snapshot()
    assert other.snapshot() == after
    world.restore(kept)
    for _ in range(7):
        tick(world, "go_to", A="dock")
    assert world.snapshot() == after


def test_a_robot_that_failed_reads_nothing_and_stands() -> None:
    world = World(SCENARIO)
    world.freeze(0)
    tick(world, "go_to", A="dock")
    assert isnan(read(world, "go_to_succeeded"))
    assert world.state.robots["x"][0] == 2.0


def test_engine_and_interpreter_run_it_alike() -> None:
    """Both start the skill in the first tick, and go on with it: 20 of 30 ticks of 4.5 m."""
    program = link(Library(make_scenario_kit(SCENARIO)), "go_to", {"A": "dock"})
    fast, slow = World(SCENARIO), World(SCENARIO)
    Engine.from_program(fast, program).run(20)
    run = Run.from_program(slow, program)
    for _ in range(20):
        run.tick()
    assert fast.state.robots["x"][0] == slow.state.robots["x"][0] == pytest.approx(5.0)


WRONG = [
    ({"success": 2.0}, "types.rover.skills.go_to.success"),
    ({"duration_s": (3.0, 1.0)}, "give the least first"),
    ({"ends": "ball"}, "types.rover.skills.go_to.ends"),
    ({"parameters": ("dock",)}, "types.rover.skills.go_to.parameters"),
]


@pytest.mark.parametrize(("changes", "said"), WRONG)
def test_a_skill_that_cannot_be_is_one_error(changes: dict[str, object], said: str) -> None:
    with pytest.raises(SettingError, match=said):
        check_scenario(change_skill("go_to", **changes))


def test_a_name_is_for_a_skill_or_a_behavior() -> None:
    kind = SCENARIO.types["rover"]
    kind = msgspec.structs.replace(kind, skills={"forward": SkillStandIn()})
    with pytest.raises(SettingError, match=r"skills\.forward"):
        check_scenario(msgspec.structs.replace(SCENARIO, types={"rover": kind}))
    with pytest.raises(UnknownName, match="no skill 'dance'"):
        World(SCENARIO).index_skill("dance", {})
