"""A member that is trained from another computer: whom it obeys, for how long, and what it does afterwards."""

from __future__ import annotations

from math import nan

import msgspec
import pytest
from tests.bodies import TICK_S, Scripted
from tests.bodies import kit as scripted_kit

from understudy.model.binding import Binding
from understudy.model.library import Library
from understudy.runtime.agents.agent import Agent, AgentSpec
from understudy.runtime.agents.messages import UnreadableMessage
from understudy.runtime.agents.network import LocalNetwork
from understudy.runtime.agents.training_link import (
    TrainerCommand,
    TrainerFollower,
    decode_member_view,
    decode_trainer_command,
    trainer_command_key,
)
from understudy.runtime.team.team_programs import make_finder


def message(
    sequence: int, *, trainer: str = "laptop", start: int = 7, lease_s: float = 0.5, drive: float = 1.0
) -> TrainerCommand:
    return TrainerCommand(
        trainer=trainer, start=start, sequence=sequence, sent_s=sequence * TICK_S, lease_s=lease_s,
        commands={"drive": drive},
    )  # fmt: skip


HEARD = [  # messages before, the message, whether it is obeyed
    ([], message(1), True),
    ([message(1)], message(2), True),
    ([message(2)], message(2), False),  # doubled
    ([message(2)], message(1), False),  # overtaken
    ([message(5)], message(1, start=8), True),  # the trainer was started again
    ([message(5), message(1, start=8)], message(6), False),  # a late one of the former program
    ([], message(1, trainer="stranger"), False),
]


@pytest.mark.parametrize(("before", "heard", "obeyed"), HEARD)
def test_whom_a_member_obeys(before: list[TrainerCommand], heard: TrainerCommand, obeyed: bool) -> None:
    follower = TrainerFollower("laptop")
    for each in before:
        assert follower.receive(each, 0.9)
    assert follower.receive(heard, 1.0) is obeyed
    assert follower.holds(1.4) is obeyed
    assert not follower.holds(1.5)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xc1",
        msgspec.msgpack.encode(message(1, drive=nan)),
        msgspec.msgpack.encode(message(1, lease_s=60.0)),
        msgspec.msgpack.encode(message(1, lease_s=0.0)),
    ],
)
def test_what_is_no_drive_message_is_refused(data: bytes) -> None:
    with pytest.raises(UnreadableMessage):
        decode_trainer_command(data)
    with pytest.raises(UnreadableMessage):
        decode_member_view(data)


def make_agent(network: LocalNetwork, trainer: str | None = "laptop") -> tuple[Agent, Scripted]:
    """An agent that alone drives forward."""
    find = make_finder(Library(scripted_kit), "robot")
    body = Scripted()
    spec = AgentSpec("scout_1", find, [], find("forward", Binding({})), trainer=trainer)
    return Agent(spec, body, network.join("scout_1")), body


def tick(agent: Agent) -> None:
    agent.sense()
    agent.obey()
    agent.act()


def test_a_trainer_that_dies_leaves_the_member_to_itself() -> None:
    """It is driven while messages come; when they cease, it begins what it does alone, after half a second."""
    network = LocalNetwork()
    agent, body = make_agent(network)
    laptop = network.join("laptop")
    driven = []
    for number in range(20):
        if 3 <= number < 8:
            laptop.publish(
                trainer_command_key("scout_1"), msgspec.msgpack.encode(message(number, drive=-0.25))
            )
        tick(agent)
        driven.append(agent.is_driven)
    drives = [commands["drive"][0] for commands in body.commanded]
    assert drives == [1.0] * 3 + [-0.25] * 9 + [1.0] * 8  # the last message was heard in tick 7
    assert driven == [False] * 3 + [True] * 8 + [False] * 9  # after the tick, when a tenth more has passed
    assert agent.beginnings == 2  # nothing while it was driven, and what it does alone afterwards
    assert agent.begun_s == pytest.approx(12 * TICK_S)


def test_a_command_that_the_network_held_up_moves_nothing() -> None:
    """It was sent in tick 4, and arrives in tick 14."""
    network = LocalNetwork()
    agent, body = make_agent(network)
    laptop = network.join("laptop")
    arrivals = {3: 3, 14: 4, 15: 5, 16: 13}  # tick -> the tick in which what arrives then was sent
    for number in range(20):
        if number in arrivals:
            sent = message(arrivals[number], drive=-0.25)
            laptop.publish(trainer_command_key("scout_1"), msgspec.msgpack.encode(sent))
        tick(agent)
    drives = [commands["drive"][0] for commands in body.commanded]
    assert drives == [1.0] * 3 + [-0.25] * 5 + [1.0] * 8 + [-0.25] * 2 + [1.0] * 2  # 0.3 of 0.5 s late: 0.2 s


def test_a_member_without_a_trainer_in_its_team_file_obeys_none() -> None:
    network = LocalNetwork()
    agent, body = make_agent(network, trainer=None)
    network.join("laptop").publish(
        trainer_command_key("scout_1"), msgspec.msgpack.encode(message(1, drive=-0.25))
    )
    tick(agent)
    assert body.commanded[0]["drive"] == [1.0]
