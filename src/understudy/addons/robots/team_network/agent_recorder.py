"""Recordings of agents: a robot's run as any recording has it, the decisions for squads, and all messages of the team.

Every message is stamped when it is sent and when it arrives, so that recordings of several computers can be merged.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from understudy.addons.robots.team_network.load_plan import LoadedTeam
from understudy.records.header import SCENARIO, RunInfo, format_part
from understudy.records.message_types import DUTY, TEAM_MESSAGE, encode_team_message, resolve_topic_name
from understudy.records.messages import encode_message, make_message
from understudy.records.recorder import DUTIES, HEARD, SENT, AgentChannels, RunRecorder
from understudy.runtime.agents.agent import Agent
from understudy.runtime.agents.coordinator import SquadCoordinator
from understudy.runtime.agents.network import Inbox, Network, Observe
from understudy.sim.scenario.files import format_scenario
from understudy.storage.document import fingerprint_automaton
from understudy.storage.json_text import encode_json


class RecordedNetwork:
    """An agent's access to the network, whose messages are recorded.

    Parameters
    ----------
    network
        The access to the network.
    recorder
        The recorder.
    name
        The name of the agent.
    """

    def __init__(self, network: Network, recorder: RunRecorder, name: str) -> None:
        self._network = network
        self._sent = recorder.open_topic(resolve_topic_name(name, SENT), TEAM_MESSAGE)
        self._heard = recorder.open_topic(resolve_topic_name(name, HEARD), TEAM_MESSAGE)
        self._observed: set[str] = set()

    def publish(self, key: str, message: bytes) -> None:
        """Record a message and send it."""
        self._sent(encode_team_message(key, message), None)
        self._network.publish(key, message)

    def listen(self, key: str, observe: Observe | None = None) -> Inbox:
        """Receive the messages of a key from now on, and record each once, however many inboxes there are."""
        if observe is not None or key in self._observed:
            return self._network.listen(key, observe)
        self._observed.add(key)
        return self._network.listen(key, lambda message: self._heard(encode_team_message(key, message), None))

    def announce(self, name: str) -> None:
        """Let others see that this agent is there."""
        self._network.announce(name)

    @property
    def present(self) -> frozenset[str]:
        """The names of the agents that are there, as far as is known."""
        return self._network.present

    def close(self) -> None:
        """Leave the network."""
        self._network.close()


class AgentRecorder:
    """A recorder of what one agent decides, as a robot and for the squads that it may lead.

    Parameters
    ----------
    recorder
        The recorder of the file.
    name
        The name of the agent.
    team
        The team.
    """

    def __init__(self, recorder: RunRecorder, name: str, team: LoadedTeam) -> None:
        self.recorder, self._name, self._team = recorder, name, team
        self._scenario = format_scenario(team.scenario)
        self._robot: _Beginnings | None = None
        self._squads: dict[str, _SquadRecord] = {}

    @property
    def path(self) -> Path:
        """The file."""
        return self.recorder.path

    def describe_run(self, name: str) -> RunInfo:
        """Describe what the robot of this name, or the coordinator of a squad of this name, runs."""
        team = self._team
        sort = team.plan.find_sort(name)
        taught = team.libraries[sort].taught
        return RunInfo(
            library=str(team.library.resolve()),
            sorts=[sort],
            behavior=team.settings.runs.get(sort),
            binding=dict(team.settings.bind.get(sort, {})),
            automata={sort: {each: fingerprint_automaton(taught[each]) for each in sorted(taught)}},
            agent=self._name,
            squad=msgspec.UNSET if name == self._name and name in team.robots else name,
        )

    def follow_robot(self, agent: Agent, namespace: str) -> None:
        """Record what the agent of this robot begins; its ticks are recorded by the robot's twin."""
        self._robot = _Beginnings(self.recorder, agent, namespace)

    def note_beginning(self) -> None:
        """Record what the robot has begun since the last call; call it before it decides."""
        if self._robot is not None:
            self._robot.note()

    def note_squad(self, coordinator: SquadCoordinator) -> None:
        """Record what a coordinator has begun or taken over; call it after it has sensed, and before it decides."""
        squad = coordinator.spec.name
        if squad not in self._squads:
            if not coordinator.leads:
                return
            self._squads[squad] = self._open_squad(coordinator)
        self._squads[squad].note()

    def write_squad_tick(self, coordinator: SquadCoordinator) -> None:
        """Record a tick of a coordinator that leads, after it has decided."""
        self.recorder.check()
        if coordinator.leads:
            self._squads[coordinator.spec.name].write_tick()

    def _open_squad(self, coordinator: SquadCoordinator) -> _SquadRecord:
        part = format_part(coordinator.spec.name, self._name)
        channels = self.recorder.open_part(
            part,
            coordinator.squads,
            ran=self.describe_run(coordinator.spec.name),
            files={SCENARIO: self._scenario},
        )
        return _SquadRecord(coordinator, channels, _Beginnings(self.recorder, coordinator.agent, part))


class _SquadRecord:
    """The record of one coordinator, of the ticks in which it leads."""

    def __init__(
        self, coordinator: SquadCoordinator, channels: AgentChannels, beginnings: _Beginnings
    ) -> None:
        self._coordinator, self._channels, self._beginnings = coordinator, channels, beginnings
        self._keys = tuple(coordinator.agent.percept)
        self._led = False

    def note(self) -> None:
        leads = self._coordinator.leads
        taken_over = leads and not self._led
        if not self._beginnings.note() and taken_over:
            self._beginnings.note_restored()
        self._led = leads

    def write_tick(self) -> None:
        percept, agent = self._coordinator.agent.percept, self._coordinator.agent
        values = np.array([float(percept[key][0]) for key in self._keys])
        self._channels.write_tick(agent.body.time_s, self._keys, values, agent.path)


class _Beginnings:
    """The record of what one agent begins."""

    def __init__(self, recorder: RunRecorder, agent: Agent, namespace: str) -> None:
        self._agent, self._count = agent, 0
        self._write = recorder.open_topic(resolve_topic_name(namespace, DUTIES), DUTY)

    def note(self) -> bool:
        """Record what the agent began, if anything; return whether it did."""
        if self._agent.beginnings == self._count:
            return False
        self._count = self._agent.beginnings
        self._write_duty()
        return True

    def note_restored(self) -> None:
        """Record that the agent goes on in the state that it is in."""
        frames = self._agent.interpreter.snapshot(self._agent.body.time_s)
        self._write_duty(frames=encode_json(list(frames)).decode())

    def _write_duty(self, **more: Any) -> None:
        self._write(encode_message(DUTY, make_message(DUTY, **_describe_duty(self._agent), **more)), None)


def _describe_duty(agent: Agent) -> dict[str, Any]:
    """Return the fields of a message on what an agent begins."""
    follower = agent.follower
    fields: dict[str, Any] = {"time_s": agent.body.time_s}
    if agent.driver is not None and agent.is_driven:
        return {**fields, "leader": agent.driver.trainer}
    if follower is None or follower.order is None:
        return {**fields, "alone": True}
    term, number = follower.order
    behavior, binding = follower.duty or ("", dict[str, str]())
    return {
        **fields, "leader": follower.leader or "", "term": term, "number": number, "behavior": behavior,
        "parameters": list(binding), "targets": list(binding.values()),
    }  # fmt: skip
