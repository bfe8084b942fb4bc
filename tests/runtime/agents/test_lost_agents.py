"""Agents that die, messages that are lost, and a network that splits: what robots do meanwhile."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from random import Random
from typing import TypeAlias

import pytest
from tests.bodies import TICK_S, Scripted
from tests.bodies import kit as scripted_kit
from tests.make.programs import make_automaton
from tests.runtime.test_team import SQUAD, there_and_back

from understudy.model.library import Library
from understudy.model.squad import Assignment, Order, Squad
from understudy.runtime.agents.local_team import LocalTeam
from understudy.runtime.agents.messages import Duty, Orders, pack_message
from understudy.runtime.agents.network import LocalNetwork
from understudy.runtime.agents.team_plan import TeamPlan
from understudy.runtime.interpreter import StackFrame
from understudy.runtime.team.members import Member
from understudy.runtime.team.squad_kit import make_squad_kit
from understudy.runtime.team.team import TeamTree

ROBOTS = 4
NAMES = tuple(f"scout_{number}" for number in range(1, ROBOTS + 1))
LEASE_TICKS, SILENT_TICKS = 10, 4


def make_team(
    network: LocalNetwork,
    *,
    deputies: Sequence[str] = NAMES,
    near: float = 60.0,
    library: str | None = None,
    squad: Squad = SQUAD,
    lead: Callable[[Library], Library] = there_and_back,
) -> LocalTeam:
    """Four robots that go until they are within `near` m, and alone turn; all turn when all are there."""
    to = lambda distance: "done" if distance < near else "forward"  # noqa: E731
    go = make_automaton(
        "go", ["forward"], {"start": to, "forward": to}, flags=["done"], features=["range_of(ball)"]
    )
    robots = Library.from_automata(scripted_kit, go)
    kit = make_squad_kit(squad, Scripted.readings, {"robot": robots})
    tree = TeamTree(
        ("robot",), (0,) * ROBOTS, ((squad, (tuple(Member(0, row, 0) for row in range(ROBOTS)),)),)
    )
    plan = TeamPlan(
        tree,
        {"robot": robots, "pair": lead(Library(kit))},
        {"pair": ("lead", {}), "robot": ("right", {})},
        readings={"robot": Scripted.readings},
        targets=Scripted.targets,
        robots=NAMES,
        deputies={"pair_0": deputies},
        fingerprints=None if library is None else {"robot": library, "pair": library},
        requires_same_library=library is not None,
    )
    return LocalTeam(Scripted(ROBOTS), plan, network)


def leaders(team: LocalTeam) -> list[str]:
    return sorted(team.find_leaders("pair_0"))


def test_a_dead_coordinator_is_replaced_and_nobody_is_restarted() -> None:
    team = make_team(LocalNetwork())
    team.run(5)
    assert leaders(team) == ["pair_0"]
    before = {name: robot.interpreter.root for name, robot in team.robots.items()}
    started = [robot.interpreter.behavior_start_s for robot in team.robots.values()]
    team.stop("pair_0")
    team.run(SILENT_TICKS)
    assert leaders(team) == ["scout_1"]
    assert {name: robot.interpreter.root for name, robot in team.robots.items()} == before
    assert [robot.interpreter.behavior_start_s for robot in team.robots.values()] == started
    assert team.paths == [("go", "forward")] * ROBOTS
    team.run(60)
    assert team.paths == [("left",)] * ROBOTS  # the deputy went on where it was


def test_a_coordinator_that_comes_back_follows() -> None:
    team = make_team(LocalNetwork())
    team.run(5)
    team.stop("pair_0")
    team.run(10)
    team.start("pair_0")
    for _ in range(20):
        team.tick()
        assert leaders(team) == ["scout_1"]
        assert team.paths == [("go", "forward")] * ROBOTS


def test_deputies_count_no_flags_of_an_order_that_is_over() -> None:
    """Reports take 3 ticks; those on the first order still arrive when the deputy has heard the second one."""
    team = make_team(LocalNetwork(lambda sender, receiver, step: [3]), near=80.0)
    counted = set()
    for _ in range(60):
        team.tick()
        receiver = team.robots["scout_1"].follower
        assert receiver is not None
        percept = team.coordinators["pair_0"]["scout_1"].squads.sense([("all_done", None)])
        counted.add((receiver.order, float(percept["all_done", None][0])))
    assert {((1, 1), 1.0), ((1, 2), 0.0)} < counted
    assert ((1, 2), 1.0) not in counted


@pytest.mark.parametrize("seed", range(20))
def test_no_robot_executes_an_order_that_is_older_than_its_lease(seed: int) -> None:
    """Messages are held up for longer and longer, and then arrive all at once; some arrive at once before."""
    draws = Random(seed)
    network = LocalNetwork(
        lambda sender, receiver, step: [0] if step < 5 else [draws.choice((0, 30, 60 - step % 50))]
    )
    team = make_team(network, deputies=(), near=-1e9)
    alone = 0
    for _ in range(120):
        team.tick()
        leader = team.coordinators["pair_0"]["pair_0"]
        for robot in team.robots.values():
            follower = robot.follower
            assert follower is not None
            if follower.order is not None:
                assert leader.sent - follower.heard < LEASE_TICKS
            alone += follower.order is None
        if 40 <= network.step_number < 70:
            network.fate = lambda sender, receiver, step: [70 - step]
    assert alone


def test_a_deputy_that_does_not_hear_the_leader_knows_from_others_that_it_leads() -> None:
    def fate(sender: str, receiver: str, step: int) -> list[int]:
        return [] if (sender, receiver) == ("pair_0", "scout_1") else [0]

    team = make_team(LocalNetwork(fate), near=-1e9)
    team.run(60)
    assert leaders(team) == ["pair_0"]
    assert team.commands["turn"][0] == -1.0  # it has no order, and is alone
    team.stop("pair_0")
    team.run(SILENT_TICKS + 2)
    assert leaders(team) == ["scout_1"]


def test_a_deputy_with_another_library_does_not_keep_the_others_from_leading() -> None:
    network = LocalNetwork()
    team = make_team(network, near=-1e9, library="new")
    team.plan, plan = make_team(LocalNetwork(), near=-1e9, library="old").plan, team.plan
    team.start("scout_1")
    team.plan = plan
    team.run(10)
    team.stop("pair_0")
    for _ in range(40):
        team.run(1)
        assert team.paths[1:] == [("go", "forward")] * 3
    assert "scout_2" in leaders(team)


def test_without_a_deputy_robots_do_what_they_were_taught_for_being_alone() -> None:
    team = make_team(LocalNetwork(), deputies=())
    team.run(5)
    team.stop("pair_0")
    team.run(LEASE_TICKS - 2)
    assert team.paths == [("go", "forward")] * ROBOTS
    team.run(2)
    assert team.paths == [()] * ROBOTS
    assert team.commands["turn"][0] == -1.0  # right
    team.start("pair_0")
    team.run(SILENT_TICKS + 2)
    assert team.paths == [("go", "forward")] * ROBOTS


def test_a_robot_that_was_frozen_does_not_begin_an_old_order() -> None:
    """Orders still wait in its program; the coordinator has died since."""
    team = make_team(LocalNetwork(), deputies=(), near=-1e9)
    team.run(10)
    frozen = team.robots.pop("scout_1")
    team.run(5)
    team.stop("pair_0")
    team.run(300)
    team.robots["scout_1"] = frozen
    for _ in range(2 * LEASE_TICKS):
        team.tick()
        assert team.paths[0] == ()  # it turns, alone


def test_a_dead_robot_is_not_waited_for() -> None:
    team = make_team(LocalNetwork())
    team.run(5)
    team.stop("scout_4")
    team.run(60)
    assert team.paths[:3] == [("left",)] * 3
    problems = [
        members.find_problem(member)
        for members in team.coordinators["pair_0"]["pair_0"].members
        for member in members.members
    ]
    assert problems == ["", "", "", "is silent"]


def test_a_coordinator_that_starts_again_where_it_hears_nobody_is_obeyed_afterwards() -> None:
    """It leads in term 1 again, as before, and its messages begin at number 1 again."""
    network = LocalNetwork()
    team = make_team(network, deputies=(), near=-1e9)
    team.run(100)
    team.start("pair_0")
    split(network, ("pair_0",), NAMES)
    team.run(SILENT_TICKS + 2)
    split(network, ("pair_0", *NAMES))
    team.run(2 * LEASE_TICKS)
    assert leaders(team) == ["pair_0"]
    assert team.paths == [("go", "forward")] * ROBOTS


def split(network: LocalNetwork, *groups: tuple[str, ...]) -> None:
    """Only agents of one group hear each other."""
    of = {name: number for number, group in enumerate(groups) for name in group}
    network.fate = lambda sender, receiver, step: [0] if of[sender] == of[receiver] else []


def test_a_split_network_has_a_leader_on_each_side_and_one_after_it_heals() -> None:
    network = LocalNetwork()
    team = make_team(network)
    team.run(5)
    split(network, ("pair_0", "scout_1"), ("scout_2", "scout_3", "scout_4"))
    team.run(SILENT_TICKS + 4)
    assert leaders(team) == ["pair_0", "scout_2"]
    split(network, ("pair_0", *NAMES))
    team.run(2)
    assert leaders(team) == ["scout_2"]
    obeyed = {robot.follower.leader for robot in team.robots.values() if robot.follower is not None}
    assert obeyed == {"scout_2"}
    assert team.paths == [("go", "forward")] * ROBOTS


@pytest.mark.parametrize("seed", range(5))
def test_lost_late_and_doubled_messages_change_nothing_but_the_time(seed: int) -> None:
    draws = Random(seed)

    def fate(sender: str, receiver: str, step: int) -> list[int]:
        return [draws.randint(1, 3) for _ in range(draws.choice([0, 1, 1, 1, 2]))]

    team = make_team(LocalNetwork(fate), near=80.0)
    seen: set[tuple[str, ...]] = set()
    for _ in range(60):
        team.tick()
        assert len(leaders(team)) <= 2
        seen |= set(team.paths)
    assert team.paths == [("left",)] * ROBOTS
    assert {path[0] for path in seen if path} == {"go", "left"}


def test_no_robot_obeys_two_coordinators_in_one_term() -> None:
    """With a random third of the messages lost and agents killed, a term has one leader for each robot."""
    draws = Random(7)
    network = LocalNetwork(
        lambda sender, receiver, step: [] if draws.random() < 0.33 else [draws.randint(0, 2)]
    )
    team = make_team(network, near=-1e9)
    obeyed: dict[tuple[str, int], set[str]] = {}
    for tick in range(1200):
        if tick % 23 == 0:
            name = draws.choice(["pair_0", *NAMES])
            (team.start if name in team.stopped else team.stop)(name)
        team.tick()
        for name, robot in team.robots.items():
            if robot.follower is not None and robot.follower.leader is not None:
                obeyed.setdefault((name, robot.follower.term), set()).add(robot.follower.leader)
    assert all(len(leaders) == 1 for leaders in obeyed.values())
    assert len({leader for leaders in obeyed.values() for leader in leaders}) > 2


def test_ticks_are_a_tenth_of_a_second() -> None:
    assert TICK_S * LEASE_TICKS == 1.0


UNKNOWN_DUTIES = [  # what a coordinator with another library might order
    ("dance", {}),
    ("go", {"partner": "ball"}),
    ("forward", {}),  # which the robot's library has, but no order of its own names
]


@pytest.mark.parametrize("duty", UNKNOWN_DUTIES)
def test_who_is_ordered_what_its_library_does_not_have_stands_still_and_says_so(duty: Duty) -> None:
    network = LocalNetwork()
    team = make_team(network, near=-1e9)
    team.run(5)
    message = Orders(
        squad="pair_0", leader="scout_1", term=2, start=1, sequence=1, sent_s=0.0, order=(2, 1), lease_s=1.0,
        library="", duties={"scout_4": duty}, frames=[],
    )  # fmt: skip
    network.send("scout_1", "order/pair_0", pack_message(message))
    team.run(2)
    assert team.robots["scout_4"].path == ()
    assert team.commands["drive"][3] == 0.0
    scouts = team.coordinators["pair_0"]["scout_2"].members[0]
    assert scouts.members[3].problem == f"cannot run {duty[0]}, which it was ordered to"


Unusable: TypeAlias = tuple[list[StackFrame], dict[str, Duty | None]]
"""The run state and the duties of a leader."""

UNUSABLE: list[Unusable] = [  # of a leader with another library
    ([StackFrame("lead", "dance", 1.0)], {"scout_1": ("go", {})}),
    ([StackFrame("conduct", "go", 1.0)], {"scout_1": ("go", {})}),
    ([StackFrame("lead", "go", 1.0)], {"scout_1": ("dance", {})}),
]


@pytest.mark.parametrize(("frames", "duties"), UNUSABLE)
def test_a_deputy_that_cannot_go_on_begins_afresh(
    frames: list[StackFrame], duties: dict[str, Duty | None]
) -> None:
    network = LocalNetwork()
    team = make_team(network, near=-1e9)
    team.run(5)
    message = Orders(
        squad="pair_0", leader="pair_0", term=6, start=1, sequence=1, sent_s=0.0, order=(6, 1), lease_s=1.0,
        library="", duties=duties, frames=frames,
    )  # fmt: skip
    network.send("scout_4", "order/pair_0", pack_message(message))
    team.tick()
    team.stop("pair_0")
    team.run(SILENT_TICKS + 2)
    assert leaders(team) == ["scout_1"]
    assert team.coordinators["pair_0"]["scout_1"].agent.path == ("go",)
    assert team.paths == [("go", "forward")] * ROBOTS
    assert {robot.follower.order for robot in team.robots.values() if robot.follower} == {(7, 1)}


def lead_half(library: Library) -> Library:
    """Order `half` for good."""
    answers = {"start": lambda all_done: "half", "half": lambda all_done: "half"}
    leader = make_automaton("lead", ["half"], answers, features=["all_done"], library=library)
    return Library.from_automata(library.kit, leader)


def test_shares_are_dealt_again_when_members_begin_to_count() -> None:
    """Half of the squad goes: of two robots one, of four two; who goes already is not restarted."""
    half = Order((Assignment("go", share=Fraction(1, 2)), Assignment("right")))
    team = make_team(LocalNetwork(), near=-1e9, squad=replace(SQUAD, orders={"half": half}), lead=lead_half)
    team.stop("scout_3")
    team.stop("scout_4")
    team.run(SILENT_TICKS + LEASE_TICKS)
    assert [path[0] for path in team.paths[:2]] == ["go", "right"]
    started = team.robots["scout_1"].interpreter.behavior_start_s
    team.start("scout_3")
    team.start("scout_4")
    team.run(4)
    assert sorted(path[0] for path in team.paths) == ["go", "go", "right", "right"]
    assert team.paths[0] == ("go", "forward")
    assert team.robots["scout_1"].interpreter.behavior_start_s == started


RESTARTED = [  # deputies, who is started anew when the coordinator has died, and leads then: members tell it
    (NAMES, "scout_1"),
    (NAMES[:1], "scout_1"),
    ((), "pair_0"),
]


@pytest.mark.parametrize("turns", [False, True])
@pytest.mark.parametrize(("deputies", "new"), RESTARTED)
def test_a_leader_without_memory_goes_on_and_restarts_no_member(
    deputies: tuple[str, ...], new: str, turns: bool
) -> None:
    """Its program was started after the last message of the former leader, in whatever state that was."""
    team = make_team(LocalNetwork(), deputies=deputies, near=60.0 if turns else -1e9)
    team.run(60)
    others = [robot for name, robot in team.robots.items() if name != new]
    begun = [robot.beginnings for robot in others]
    host = team.coordinators["pair_0"]["pair_0"]
    state, order = host.agent.path, host.order
    assert state == (("left",) if turns else ("go",))
    team.stop("pair_0")
    team.start(new)
    for _ in range(30):
        team.tick()
        assert [robot.beginnings for robot in others] == begun
    assert leaders(team) == [new]
    now = team.coordinators["pair_0"][new]
    assert (now.agent.path, now.order) == (state, order)
    assert team.paths == [("left",) if turns else ("go", "forward")] * ROBOTS
