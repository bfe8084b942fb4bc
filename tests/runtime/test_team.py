"""What a tick of a team means, as tables to check by hand; and engines do in teams as interpreters do."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.bodies import Scripted
from tests.bodies import kit as scripted_kit
from tests.make.programs import make_automaton
from tests.runtime.random_libraries import Played, draw_library, play_random_body

from understudy.errors import UnderstudyError, UnknownName
from understudy.jit.plain import make_plain
from understudy.model.binding import Binding
from understudy.model.library import Library
from understudy.model.squad import Assignment, Order, Role, Squad, Statistic
from understudy.runtime.body import Body, FusedPlan
from understudy.runtime.engine import _pulse_kernels
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import Program
from understudy.runtime.team import _squad_kernels
from understudy.runtime.team.members import Member, Runner
from understudy.runtime.team.squad_kit import make_squad_kit
from understudy.runtime.team.team import Team, TeamTree, make_interpreter_runner

CASES = st.builds(Random, st.integers(0, 2**32))
NEAR = 97.5
"""Agent i of the scripted body is 100 + i m from the ball, and comes a meter nearer with every tick."""


def make_engines(body: Body, programs: Sequence[Program], others: Sequence[Program]) -> Runner:
    """Engines."""
    return Engine(body, programs, others)


def goer() -> Library:
    """Forward until near the ball, then done."""
    to = lambda distance: "done" if distance < NEAR else "forward"  # noqa: E731
    go = make_automaton(
        "go", ["forward"], {"start": to, "forward": to}, flags=["done"], features=["range_of(ball)"]
    )
    return Library.from_automata(scripted_kit, go)


SQUAD = Squad(
    "pair",
    (Role("both", "robot"),),
    (
        Statistic("all_done", "all", flag="done"),
        Statistic("any_done", "any", flag="done"),
        Statistic("none_done", "none", flag="done"),
        Statistic("done_lately", "any", flag="done", within_s=0.25),
        Statistic("left", "count"),
    ),
)


def there_and_back(kit_library: Library) -> Library:
    """All go; when all are done, all turn, and for good: the tick after says that nobody is done any more."""
    leader = make_automaton(
        "lead",
        ["go", "left"],
        {
            "start": lambda all_done: "go",
            "go": lambda all_done: "left" if all_done else "go",
            "left": lambda all_done: "go" if all_done else "left",
        },
        features=["all_done"],
        library=kit_library,
    )
    return Library.from_automata(kit_library.kit, *map(kit_library.automaton, kit_library.taught), leader)


def pair_of(body: Scripted, makes: object = make_interpreter_runner, *, root: str = "lead") -> Team:
    """Two robots under one coordinator."""
    robots = goer()
    kit = make_squad_kit(SQUAD, body.readings, {"robot": robots})
    tree = TeamTree(("robot",), (0, 0), ((SQUAD, ((Member(0, 0, 0), Member(0, 1, 0)),)),))
    libraries = {"robot": robots, "pair": there_and_back(Library(kit))}
    return Team(body, tree, libraries, {"pair": (root, {})})


def paths(team: Team) -> list[str]:
    """Where everybody is: the coordinators first."""
    found = []
    for layer in reversed(team.layers):
        runner, agents = layer.runner, layer.body.agents
        path = [runner.path(agent) for agent in range(agents)]
        found += ["/".join(each) for each in path]
    return found


TICKS = [  # coordinator, first robot, second robot, channel drive of both
    (["go", "forward", "forward"], [1, 1]),  # the order and what it starts, in one tick
    (["go", "forward", "forward"], [1, 1]),
    (["go", "forward", "forward"], [1, 1]),
    (["go", "done", "forward"], [0, 1]),  # 97 m: the first is near; 98 m
    (["go", "done", "done"], [0, 0]),
    (["left", "", ""], [0, 0]),  # the coordinator sees a flag a tick after it was raised
    (["left", "", ""], [0, 0]),  # nobody is done any more: those who were ordered are robots that turn
]


def test_a_tick_by_hand() -> None:
    body = Scripted(2)
    team = pair_of(body)
    for expected, drive in TICKS:
        team.tick()
        assert paths(team) == expected
        assert body.commanded[-1]["drive"] == drive
    assert body.commanded[-1]["turn"] == [1.0, 1.0]


def outer(inner: Library) -> Library:
    """Leads; a while after somebody was done it starts leading anew."""
    again = make_automaton(
        "outer",
        ["lead", "again=lead"],
        {"start": lambda any_done: "lead", "lead": lambda any_done: "again" if any_done else None},
        features=["any_done"],
        library=inner,
    )
    return Library.from_automata(inner.kit, *map(inner.automaton, inner.taught), again)


def test_a_switch_resets_the_flags_for_every_query_below() -> None:
    """Where the outer automaton starts the inner one anew, that one sees nobody done in the same tick."""
    body = Scripted(2)
    robots = goer()
    seen: list[tuple[float, ...]] = []
    kit = make_squad_kit(SQUAD, body.readings, {"robot": robots})

    def start(*values: float) -> str:
        seen.append(values)
        return "go"

    features = ["all_done", "any_done", "none_done", "done_lately", "left"]
    inner = make_automaton("lead", ["go"], {"start": start}, features=features, library=Library(kit))
    library = outer(Library.from_automata(kit, inner))
    tree = TeamTree(("robot",), (0, 0), ((SQUAD, ((Member(0, 0, 0), Member(0, 1, 0)),)),))
    team = Team(body, tree, {"robot": robots, "pair": library}, {"pair": ("outer", {})})
    team.run(6)
    assert paths(team) == ["again/go", "done", "done"]
    assert seen == [(0, 0, 1, 0, 2), (0, 0, 1, 1, 2)]  # what looks back is reset only with the run


def test_pulsing_restarts_nobody_and_starting_does() -> None:
    """A coordinator that goes from one state to another with the same order restarts its members."""
    body = Scripted(2)
    robots = goer()
    kit = make_squad_kit(SQUAD, body.readings, {"robot": robots})
    leader = make_automaton(
        "lead",
        ["go", "once_more=go"],
        {"start": lambda any_done: "go", "go": lambda any_done: "once_more" if any_done else None},
        features=["any_done"],
        library=Library(kit),
    )
    tree = TeamTree(("robot",), (0, 0), ((SQUAD, ((Member(0, 0, 0), Member(0, 1, 0)),)),))
    team = Team(
        body, tree, {"robot": robots, "pair": Library.from_automata(kit, leader)}, {"pair": ("lead", {})}
    )
    began = []
    team.layers[0].runner.begin = lambda agents, program: began.append(list(agents))  # type: ignore[method-assign]
    team.run(3)
    assert began == [[0, 1]]
    team.layers[0].runner.find_raised = lambda flag: (  # type: ignore[method-assign]
        team.layers[0].body.sense([("seen", None)])["seen", None] >= 0
    )
    team.run(3)
    assert began == [[0, 1], [0, 1]]


def test_an_order_that_members_do_not_know_is_refused_before_anything_runs() -> None:
    body = Scripted(2)
    kit = make_squad_kit(SQUAD, body.readings, {"robot": goer()})
    tree = TeamTree(("robot",), (0, 0), ((SQUAD, ((Member(0, 0, 0), Member(0, 1, 0)),)),))
    libraries = {"robot": Library(scripted_kit), "pair": there_and_back(Library(kit))}
    with pytest.raises(UnderstudyError, match="go"):
        Team(body, tree, libraries, {"pair": ("lead", {})})
    with pytest.raises(UnknownName):
        pair_of(body, root="nothing")


SHARES = [  # duties as (behavior, role, share), then what each of five members (roles c, c, s, s, s) does
    ([("go", None, None)], ["go"] * 5),
    ([("go", "c", None), ("left", "s", None)], ["go", "go", "left", "left", "left"]),
    ([("go", None, "1/3"), ("left", None, None)], ["go", "go", "left", "left", "left"]),
    ([("go", "s", "2"), ("left", None, None)], ["left", "left", "go", "go", "left"]),
    ([("go", "c", None)], ["go", "go", None, None, None]),
]


@pytest.mark.parametrize(("duties", "expected"), SHARES)
def test_an_order_says_who_does_what(
    duties: list[tuple[str, str | None, str | None]], expected: list[str | None]
) -> None:
    body = Scripted(5)
    squad = Squad(
        "crew",
        (Role("c", "robot"), Role("s", "robot")),
        orders={
            "both": Order(
                tuple(
                    Assignment(name, Binding(), role, Fraction(share) if share else None)
                    for name, role, share in duties
                )
            )
        },
    )
    robots = goer()
    kit = make_squad_kit(squad, body.readings, {"robot": robots})
    members = tuple(Member(0, row, int(row > 1)) for row in range(5))
    tree = TeamTree(("robot",), (0,) * 5, ((squad, (members,)),))
    team = Team(body, tree, {"robot": robots, "crew": Library(kit)}, {"crew": ("both", {})})
    team.tick()
    ordering = team.layers[1].body.ordering  # type: ignore[attr-defined]
    assert [None if duty is None else duty.behavior for duty in ordering.duty] == expected


# Engines and interpreters


def statistics(random: Random, *, angles: bool = True) -> tuple[Statistic, ...]:
    """Some of every sort."""
    flags = [
        Statistic(f"{how}_{flag}", how, flag=flag)
        for how in ("any", "all", "none", "count", "fraction")
        for flag in ("done", "failed")
    ]
    timed = [
        Statistic("lately", "any", flag="done", within_s=0.3),
        Statistic("since", "all", flag="done", since=True),
        Statistic("held", "none", flag="failed", for_s=0.2),
        Statistic("saw", "any", reading="seen", within_s=0.5),
    ]
    measured = [
        Statistic(f"{how}_{name}", how, reading=name)
        for how in ("mean", "minimum", "maximum", "spread", "any")
        for name in (("load", "bearing") if angles else ("load",))
    ]
    return tuple(random.sample([*flags, *timed, *measured], 8))


def random_tree(
    random: Random, robots: int, *, angles: bool = True
) -> tuple[TeamTree, dict[str, Library], str]:
    """A team of one or two levels of squads, what each level knows, and the name of the top."""
    libraries = {"robot": draw_library(random, automata=2, depth=2)}
    readings = list(Played.readings)
    names, below, squads = ["robot"], robots, []
    for level in range(random.randint(1, 2)):
        squad = Squad(
            f"level{level}", (Role("all", names[-1]),), _over(statistics(random, angles=angles), level)
        )
        kit = make_squad_kit(squad, readings, {names[-1]: libraries[names[-1]]})
        libraries[squad.name] = draw_library(random, automata=2, depth=2, kit=kit, name=f"b{level}_")
        cuts = (
            sorted(random.sample(range(1, below), random.randint(0, min(2, below - 1)))) if below > 1 else []
        )
        groups = [range(low, high) for low, high in zip([0, *cuts], [*cuts, below], strict=True)]
        squads.append((squad, tuple(tuple(Member(level, row, 0) for row in group) for group in groups)))
        below = len(groups)
        names.append(squad.name)
    return TeamTree(("robot",), (0,) * robots, tuple(squads)), libraries, names[-1]


def _over(statistics: tuple[Statistic, ...], level: int) -> tuple[Statistic, ...]:
    """Squads above squads have only flags to look at."""
    return statistics if level == 0 else tuple(each for each in statistics if each.reading is None)


@settings(max_examples=60)
@given(CASES, st.integers(1, 5), st.integers(1, 3))
def test_engines_equal_interpreters_in_teams(random: Random, robots: int, worlds: int) -> None:
    body = play_random_body(random, agents=robots * worlds, ticks=20)
    other = Played(body.percepts, body.ticks_s, body.time_s)
    tree, libraries, top = random_tree(random, robots)
    name = list(libraries[top].taught)[-1]
    bound = {each: random.choice(Played.targets) for each in libraries[top].parameters(name)}
    teams = [
        Team(each, tree, libraries, {top: (name, bound)}, worlds=worlds, makes=makes)
        for each, makes in ((body, make_interpreter_runner), (other, make_engines))
    ]
    for _ in range(25):
        for team in teams:
            team.tick()
        assert paths(teams[0]) == paths(teams[1])
        assert body.commanded[-1] == other.commanded[-1]
    for team in teams:
        team.clear()
        team.tick()
    assert paths(teams[0]) == paths(teams[1])


@settings(max_examples=30)
@given(CASES, st.integers(1, 4))
def test_side_by_side_is_as_alone(random: Random, robots: int) -> None:
    """Two worlds with the same percepts go as one of them alone."""
    alone = play_random_body(random, agents=robots, ticks=20)
    twice = Played(
        [{key: np.tile(column, 2) for key, column in percept.items()} for percept in alone.percepts],
        alone.ticks_s,
        alone.time_s,
    )
    tree, libraries, top = random_tree(random, robots)
    name = list(libraries[top].taught)[-1]
    bound = {each: random.choice(Played.targets) for each in libraries[top].parameters(name)}
    one = Team(alone, tree, libraries, {top: (name, bound)}, makes=make_engines)
    two = Team(twice, tree, libraries, {top: (name, bound)}, worlds=2, makes=make_engines)
    for _ in range(20):
        one.tick()
        two.tick()
        assert {key: column * 2 for key, column in alone.commanded[-1].items()} == twice.commanded[-1]


class Led(Played):
    """A body that goes on by itself, with the kernels of coordinators and robots."""

    worlds = 1

    def advance(self, plan: FusedPlan, ticks: int, threads: int | None) -> None:
        """As a world does."""
        assert plan.lead is not None
        bands, leads = plan.lead
        for _ in range(ticks):
            percept, now = self.sense(plan.keys), float(self.time_s)
            for column, key in enumerate(plan.keys):
                bands[0][2][:, column] = percept[key]
            for world in range(self.worlds):
                _squad_kernels.run_world_coordinators(world, now, *make_plain((bands, leads)))
            columns = np.ascontiguousarray(bands[0][2].T)
            _pulse_kernels.pulse_agents(columns, now, bands[0][0], bands[0][1], plan.running, 0, self.agents)
            commands = plan.commands[plan.running]
            self.act({channel.name: commands[:, at] for at, channel in enumerate(self.channels)})


@pytest.mark.long
@settings(max_examples=80)
@given(CASES, st.integers(1, 6), st.integers(1, 3))
def test_kernels_lead_as_coordinators_do(random: Random, robots: int, worlds: int) -> None:
    body = play_random_body(random, agents=robots * worlds, ticks=20)
    other = Led(body.percepts, body.ticks_s, body.time_s)
    other.worlds = worlds
    tree, libraries, top = random_tree(random, robots, angles=False)
    name = list(libraries[top].taught)[-1]
    bound = {each: random.choice(Played.targets) for each in libraries[top].parameters(name)}
    teams = [
        Team(each, tree, libraries, {top: (name, bound)}, worlds=worlds, makes=make_engines)
        for each in (body, other)
    ]
    for ticks in (1, 4, 2, 9):
        for _ in range(ticks):
            teams[0].tick()
        teams[1].run(ticks)
        assert paths(teams[0]) == paths(teams[1])
        assert body.commanded == other.commanded
    for team in teams:  # and tick by tick from there
        team.tick()
    assert paths(teams[0]) == paths(teams[1])
    kept = [repr(layer.body.capture_state()) for team in teams for layer in team.layers[1:]]  # type: ignore[attr-defined]
    assert kept[: len(kept) // 2] == kept[len(kept) // 2 :]
