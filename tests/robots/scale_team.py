"""A team of three levels as large as asked: robots, squads of up to nine, and a coordinator over all squads."""

from __future__ import annotations

from math import pi, sin
from time import monotonic

from tests.bodies import Scripted
from tests.bodies import kit as scripted_kit
from tests.make.programs import make_automaton

from understudy.addons.robots.team_network.load_plan import choose_deputies
from understudy.model.library import Library
from understudy.model.squad import Role, Squad, Statistic
from understudy.runtime.agents.team_plan import TeamPlan
from understudy.runtime.team.members import Member
from understudy.runtime.team.squad_body import list_squad_readings
from understudy.runtime.team.squad_kit import make_squad_kit
from understudy.runtime.team.team import TeamTree

SPAN = 9
"""The number of robots in a squad."""
TOP = "company_0"
NEAR_M, LOADED = 20.0, 2.5
SQUAD = Squad(
    "squad",
    (Role("robots", "robot"),),
    (
        Statistic("all_done", "all", flag="done"),
        Statistic("any_done", "any", flag="done"),
        Statistic("nearest", "minimum", reading="range"),
        Statistic("direction", "mean", reading="bearing"),
        Statistic("load_carried", "mean", reading="load"),
        Statistic("seen_lately", "any", reading="seen", within_s=3.0),
        Statistic("present", "count"),
    ),
)
COMPANY = Squad(
    "company",
    (Role("squads", "squad"),),
    (
        Statistic("all_done", "all", flag="done"),
        Statistic("nearest", "minimum", reading="nearest"),
        Statistic("load_carried", "mean", reading="load_carried"),
        Statistic("someone_sees", "any", reading="seen_lately"),
        Statistic("squads_present", "count"),
    ),
)


class Wanderer(Scripted):
    """One robot whose readings are functions of the time since it was made."""

    def __init__(self, number: int) -> None:
        phase = number % 7

        def wave() -> float:
            return sin(2 * pi * (self.time_s + phase) / 12.0)

        super().__init__(
            1,
            {
                ("range", "ball"): lambda tick: 25.0 + 20.0 * wave(),
                ("range", "goal"): lambda tick: 50.0 - 20.0 * wave(),
                ("bearing", "ball"): lambda tick: (3.0 + wave()) % (2 * pi),
                ("bearing", "goal"): lambda tick: (5.0 + wave()) % (2 * pi),
                ("load", None): lambda tick: float(int(self.time_s) % 5),
                ("seen", None): lambda tick: float(wave() > 0),
            },
        )
        self._began = monotonic()
        self._now = 0.0

    @property
    def time_s(self) -> float:
        return self._now

    def advance(self) -> None:
        """Take the present time as that of this tick, and forget what was commanded."""
        self._now = monotonic() - self._began
        self.commanded.clear()


def make_plan(agents: int) -> TeamPlan:
    """Make the plan of a team with so many agents, coordinators included."""
    squads = -(-(agents - 1) // (SPAN + 1))
    robots = agents - 1 - squads
    to = lambda distance: "done" if distance < NEAR_M else "forward"  # noqa: E731
    go = make_automaton(
        "go_to_ball", ["forward"], {"start": to, "forward": to}, flags=["done"], features=["range_of(ball)"]
    )
    crews = Library.from_automata(scripted_kit, go)
    low = Library(make_squad_kit(SQUAD, Scripted.readings, {"robot": crews}))
    lead = make_automaton(
        "fetch_and_return",
        ["go_to_ball", "left"],
        {
            "start": lambda all_done, present: "go_to_ball",
            "go_to_ball": lambda all_done, present: "left" if all_done else "go_to_ball",
            "left": lambda all_done, present: "left" if all_done else "go_to_ball",
        },
        features=["all_done", "present"],
        library=low,
    )
    low = Library.from_automata(low.kit, *map(low.automaton, low.taught), lead)
    high = Library(make_squad_kit(COMPANY, list_squad_readings(SQUAD, Scripted.readings), {"squad": low}))
    direct = make_automaton(
        "direct",
        ["fetch_and_return", "right"],
        {
            "start": lambda load, present: "fetch_and_return",
            "fetch_and_return": lambda load, present: "fetch_and_return" if load < LOADED else "right",
            "right": lambda load, present: "fetch_and_return" if load < LOADED else "right",
        },
        features=["load_carried", "squads_present"],
        library=high,
    )
    high = Library.from_automata(high.kit, *map(high.automaton, high.taught), direct)
    rows = [range(squad, robots, squads) for squad in range(squads)]
    tree = TeamTree(
        ("robot",),
        (0,) * robots,
        (
            (SQUAD, tuple(tuple(Member(0, row, 0) for row in each) for each in rows)),
            (COMPANY, (tuple(Member(1, row, 0) for row in range(squads)),)),
        ),
    )
    return TeamPlan(
        tree,
        {"robot": crews, "squad": low, "company": high},
        {"company": ("direct", {}), "robot": ("right", {})},
        readings={"robot": Scripted.readings},
        targets=Scripted.targets,
        robots=[f"robot_{row}" for row in range(robots)],
        deputies=choose_deputies,
        fingerprints=dict.fromkeys(("robot", "squad", "company"), "0123456789abcdef"),
    )


def list_processes(plan: TeamPlan, processes: int) -> list[list[str]]:
    """Deal the agents to processes, so that those of one squad are in different ones."""
    found: list[list[str]] = [[] for _ in range(processes)]
    for number, squad in enumerate(plan.squads):
        own = [] if squad == TOP else plan.list_members(squad)
        first = number * (SPAN + 1) + number // 2  # so that coordinators are in different ones, too
        for place, name in enumerate([squad, *own]):
            found[(first + place) % processes].append(name)
    return found
