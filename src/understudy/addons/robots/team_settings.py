"""The part of a team's file that says how its agents run, each in a process of its own (`understudy team agent`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from msgspec import field

from understudy.sim.scenario.squad_schema import StrictStruct


class NetworkSpec(StrictStruct, frozen=True, kw_only=True):
    """How agents reach each other over Zenoh.

    `connect` has the addresses of routers or agents, `listen` those at which an agent can be reached. `config` has
    further keys of Zenoh's configuration, such as those for TLS and access control.
    """

    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ()
    multicast: bool = True
    config: Mapping[str, Any] = field(default_factory=dict)


class AgentSettings(StrictStruct, frozen=True, kw_only=True):
    """What differs for one agent: where its library is, and how it is reached.

    `config` has keys of Zenoh's configuration in addition to those of all agents, or instead of them.
    """

    library: str | None = None
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ()
    config: Mapping[str, Any] = field(default_factory=dict)


class TeamSettings(StrictStruct, frozen=True, kw_only=True):
    """How the agents of a team run.

    `library` is the folder of the team's automata, relative to the team's file. `runs` says what agents of each sort
    run without an order. `deputies` lists, for each squad, the agents that may lead it besides the one of its own name;
    by default its members may, in a squad of more than four the first two. With `same_library`, agents whose library
    differs are not counted and not obeyed. `trainer` is the name under which a person's computer may train robots.
    """

    library: str = "library"
    runs: Mapping[str, str] = field(default_factory=dict)
    bind: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    deputies: Mapping[str, tuple[str, ...]] | None = None
    lease_s: float = 1.0
    same_library: bool = False
    trainer: str | None = None
    network: NetworkSpec = field(default_factory=NetworkSpec)
    each: Mapping[str, AgentSettings] = field(default_factory=dict)
