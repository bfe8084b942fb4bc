"""What teams of any size send in a tick, as the page on teams shows it: python -m tests.docs.traffic brings it there.

Squads of four, squads of four of these, and so on: as many levels as it takes until one coordinator is above all.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

from msgspec.structs import replace
from tests.docs.pages import ROOT
from tests.docs.renew import replace_between

from understudy.model.library import Library
from understudy.runtime.team.comms import Traffic
from understudy.runtime.team.squad_body import SquadBody
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import RobotGroup, Scenario
from understudy.sim.scenario.squad_schema import RoleSpec, SquadSpec, StatisticSpec
from understudy.sim.team.libraries import collect_libraries, make_team

PAGE = ROOT / "docs" / "teams.md"
TRAFFIC = "<!-- traffic: python -m tests.docs.traffic puts here what is sent -->\n", "<!-- end of traffic -->"
SIZE, LEVELS = 4, 4
STATISTICS: Mapping[str, StatisticSpec] = {
    "someone_sees": StatisticSpec(how="any", reading="blob_size"),
    "all_done": StatisticSpec(how="all", flag="done"),
}
ABOVE = {**STATISTICS, "someone_sees": StatisticSpec(how="any", reading="someone_sees")}


def tree(levels: int, size: int = SIZE) -> Scenario:
    """So many levels of squads of the patrol's robots, each asking one reading and one flag of its members."""
    patrol = load_scenario("patrol")
    sorts = ["pioneer", *(f"level_{level}" for level in range(1, levels + 1))]
    squads = {
        name: SquadSpec(
            members={"all": RoleSpec(of=below, preferred=size)},
            statistics=STATISTICS if below == "pioneer" else ABOVE,
        )
        for below, name in pairwise(sorts)
    }
    robots = RobotGroup(type="pioneer", count=size**levels)
    return replace(patrol, size=(40, 40), squads=squads, robots=(robots,))


def measure_traffic(levels: int, size: int = SIZE) -> list[Traffic]:
    """What each level sends in a tick, from the robots up."""
    scenario = tree(levels, size)
    known = collect_libraries(scenario, Library(make_scenario_kit(scenario)))
    team = make_team(scenario, [0], known, {f"level_{levels}": ("forwards", {})})
    return [layer.body.traffic for layer in team.layers if isinstance(layer.body, SquadBody)]


def table() -> str:
    """Rows of 4, 16, 64 and 256 robots."""
    names = (*(f"level {level}" for level in range(1, LEVELS + 1)), "all", "each coordinator", "one for all")
    lines = [f"| robots | {' | '.join(names)} |", f"|---:|{'---:|' * len(names)}"]
    for levels in range(1, LEVELS + 1):
        found = measure_traffic(levels)
        whole = Traffic(sum(each.messages for each in found), sum(each.bytes for each in found))
        cells = [
            *map(format_traffic, found),
            *[""] * (LEVELS - levels),
            *map(format_traffic, (whole, found[-1], found[0])),
        ]
        lines.append(f"| {SIZE**levels} | {' | '.join(cells)} |")
    return "\n" + "\n".join(lines) + "\n\n"


def format_traffic(traffic: Traffic) -> str:
    return f"{traffic.messages:,} / {traffic.bytes:,}"


if __name__ == "__main__":
    replace_between(PAGE, TRAFFIC, table())
