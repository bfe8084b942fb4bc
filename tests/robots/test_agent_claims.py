"""Names of agents: one that is held is refused, that of a dead agent is not, and of several at once one remains."""

from __future__ import annotations

from pathlib import Path
from threading import Thread

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.memory_network import MemoryNetwork, MemoryTeam
from tests.robots.test_load_plan import write_team
from tests.simulated_clock import SimulatedClock

from understudy.addons.robots.team_network.agent_claim import HEARD_S, claim_name
from understudy.addons.robots.team_network.load_plan import load_team_plan
from understudy.errors import SettingError

NAME = "patrol_0"
RUNNING = f"{NAME} is running already; stop the other one first"
TWICE = f"{NAME} was started twice at the same moment; let the other one run"


@pytest.fixture
def team(tmp_path: Path) -> MemoryTeam:
    return MemoryTeam(load_team_plan(write_team(tmp_path)))


@pytest.mark.parametrize("number", ["0" * 16, "f" * 16])
def test_an_agent_that_was_killed_does_not_keep_its_name(team: MemoryTeam, number: str) -> None:
    """Others believe for some seconds that it is there; it answers nothing."""
    killed = team.network.join()
    killed.announce(NAME)
    killed.declare_token(f"claim/{NAME}/{number}")
    killed.declare_token(f"held/{NAME}")
    assert team.visitor.is_present(NAME)
    assert team.visitor.list_tokens("held/*") == [f"held/{NAME}"]
    process = team.make(NAME)
    assert process.name == NAME
    process.close()


def test_a_second_agent_of_one_name_is_refused(team: MemoryTeam) -> None:
    claim_name(team.visitor, NAME, team=team.team.name, clock=team.clock)
    with pytest.raises(SettingError, match=RUNNING):
        team.make(NAME)


STARTS = [  # after so long the others are started, after so long a token is seen; what is said of those refused
    (0.0, 0.1, TWICE),
    (HEARD_S / 2, 0.0, RUNNING),
    (HEARD_S / 3, HEARD_S / 2, TWICE),
]


@pytest.mark.parametrize(("after_s", "token_s", "said"), STARTS)
def test_of_several_that_are_started_at_the_same_moment_one_remains(
    after_s: float, token_s: float, said: str
) -> None:
    clock = SimulatedClock()
    network = MemoryNetwork(clock, token_s=token_s)
    running, refused = list[int](), list[str]()

    def start(number: int) -> None:
        clock.sleep(after_s if number else 0.0)
        try:
            claim_name(network.join(), NAME, team="patrol", clock=clock)
        except SettingError as error:
            refused.append(str(error))
        else:
            running.append(number)

    starting = [Thread(target=start, args=(number,), daemon=True) for number in range(4)]
    for thread in starting:
        thread.start()
    clock.expect(len(starting))
    clock.advance(1.0)
    for thread in starting:
        thread.join()
    assert len(running) == 1
    assert len(refused) == 3
    assert all(said in each for each in refused), refused
    assert network.join().list_tokens("held/*") == [f"held/{NAME}"]


def test_a_coordinator_without_members_says_whom_it_never_heard(team: MemoryTeam) -> None:
    process = team.make(NAME)
    until_s = team.clock() + 0.8
    process.run(until=lambda: team.clock() >= until_s)
    said = process.describe()
    assert said.leads == {}  # there is nobody to lead
    assert said.missing == dict.fromkeys(("pioneer_1", "pioneer_2", "pioneer_3"), "was never heard")
    assert said.unfit == ""
    assert (said.ticks, said.late) == (8, 0)
    process.close()


def test_a_late_tick_is_counted_and_the_next_one_follows_at_once(
    team: MemoryTeam, monkeypatch: pytest.MonkeyPatch
) -> None:
    process, began_s, ticked_s = team.make(NAME), team.clock(), list[float]()
    takes_s = {1: 0.25, 3: 0.1}

    def tick() -> None:
        ticked_s.append(round(team.clock() - began_s, 6))
        team.clock.sleep(takes_s.get(len(ticked_s), 0.0))

    began_s = team.clock()
    monkeypatch.setattr(process, "tick", tick)
    process.run(until=lambda: len(ticked_s) == 5)
    assert ticked_s == [0.0, 0.25, 0.35, 0.45, 0.55]
    assert process.late == 2
