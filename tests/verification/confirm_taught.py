"""Confirm every finding on taught foragers, patrol teams and a swarm, and print how many there are of each kind.

python -m tests.verification.confirm_taught
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from itertools import product

from tests.verification.confirm_findings import confirm_all

from understudy.addons.checks.verification.check_library import check_library
from understudy.addons.checks.verification.coordinators import SquadMembers
from understudy.model.library import Library
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import Libraries
from understudy_lab.forage.teach import teach as teach_forager
from understudy_lab.patrol.practice import scenario as patrol_scenario
from understudy_lab.patrol.practice import teach as teach_patrol
from understudy_lab.swarm.practice import teach as teach_swarm
from understudy_lab.tasks.swarm_world import scenario as swarm_scenario

METHODS = ("live", "watched")


def list_team(scenario: Scenario, libraries: Libraries) -> Iterator[tuple[Library, SquadMembers | None]]:
    """The library of each type of robots, and that of each squad's coordinator, with its members' libraries."""
    for name in scenario.types:
        yield libraries[name], None
    for squad, _ in assign_team_members(scenario).squads:
        members = {role.name: libraries[role.of] for role in squad.roles}
        yield libraries[squad.name], SquadMembers(squad, members)


def teach_all() -> Iterator[tuple[Library, SquadMembers | None]]:
    """Teach all libraries, each with the squad that it coordinates."""
    for method, seed in product(METHODS, range(20)):
        yield teach_forager(seed, method=method).library, None
    for method, seed in product(METHODS, range(3)):
        yield from list_team(patrol_scenario(), teach_patrol(seed, method=method).libraries)
    yield from list_team(swarm_scenario(), teach_swarm(0, method="live").libraries)


def main() -> None:
    """Print the number of findings by kind, certainty and means of confirmation."""
    counts: Counter[tuple[str, str, str]] = Counter()
    for library, members in teach_all():
        findings = check_library(library, kit_known=True, members=members).findings
        for finding, means in confirm_all(library, findings, members):
            certain = "certain" if finding.is_certain else "assumed"
            counts[finding.kind, certain, means or "NOT CONFIRMED"] += 1
    for key, count in sorted(counts.items()):
        sys.stdout.write(f"{count:5} {', '.join(key)}\n")


if __name__ == "__main__":
    main()
