"""The world of four regions: who is in which patrol, which home is whose, and that lessons of `patrol` are at home."""

from __future__ import annotations

from understudy.model.library import Kit, Library
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import collect_libraries

REGIONS, PATROL = load_scenario("regions"), load_scenario("patrol")
REGION_NAMES = ("north", "east", "south", "west")


def test_four_patrols_of_four_under_one_garrison() -> None:
    (patrol, patrols), (garrison, garrisons) = assign_team_members(REGIONS).squads
    assert [[member.row for member in one] for one in patrols] == [
        [0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11], [12, 13, 14, 15],
    ]  # fmt: skip
    assert [[(member.row, member.role) for member in one] for one in garrisons] == [
        [(0, 0), (1, 1), (2, 2), (3, 3)]
    ]
    assert tuple(role.name for role in garrison.roles) == REGION_NAMES
    assert patrol == assign_team_members(PATROL).squads[0][0]


def test_each_patrol_gathers_at_its_own_home() -> None:
    garrison, _ = assign_team_members(REGIONS).squads[1]
    duties = garrison.orders["gather_all"].duties
    assert [(each.role, each.behavior, dict(each.binding)) for each in duties] == [
        (name, "gather", {"A": f"home_{name}"}) for name in REGION_NAMES
    ]
    things = {each.name: each for each in REGIONS.objects}
    for name in REGION_NAMES:
        assert REGIONS.targets[f"home_{name}"].color == things[f"home_{name}"].color
    assert len({things[f"home_{name}"].color for name in REGION_NAMES}) == 4


def test_what_was_taught_in_one_world_can_be_used_in_the_other() -> None:
    """All is the same, but that there are more targets in the one."""

    def kits(scenario: Scenario) -> tuple[Kit, Kit]:
        robots = make_scenario_kit(scenario)
        return robots, collect_libraries(scenario, Library(robots))["patrol"].kit

    for ours, theirs in zip(kits(REGIONS), kits(PATROL), strict=True):
        assert ours.features == theirs.features
        assert ours.behaviors == theirs.behaviors
        assert set(theirs.targets) <= set(ours.targets)
