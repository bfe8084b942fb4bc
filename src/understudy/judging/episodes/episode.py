"""Episodes: what one agent sensed, decided and did in each tick of a run, read from any kind of file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from understudy.model.lesson import ExampleKind
from understudy.model.value_kinds import Column, Kind


@dataclass(frozen=True, slots=True)
class EpisodePress:
    """A press of the demonstrator during an episode.

    Attributes
    ----------
    tick
        The tick at which it took effect, counted from 0.
    state
        The state that it directed to; None for a confirmation of the current state.
    correction
        Whether it corrected a decision of the learned automaton.
    kind
        The kind of example that it recorded; None if it recorded none, or the file does not say.
    """

    tick: int
    state: str | None
    correction: bool = False
    kind: ExampleKind | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Episode:
    """What one agent sensed, decided and did, tick by tick, from the start of a run to its end.

    Attributes
    ----------
    agent
        Name of the agent: "robot 0", a robot's name, or a coordinator's name.
    tick_s
        Nominal length of a tick, s.
    times
        Time of each tick as its file has it, s. Shape [T]. In recordings it is the body's time at which the tick
        sensed, in journals the demonstrator's, and in traces the simulated time after the tick.
    states
        States of all levels after each tick, outermost first; T tuples, of any length.
    readings
        Readings that the decisions of each tick were made on, by label such as "distance(station)". Each has shape
        [T] and the unit of the reading, NaN where it was absent. Empty if they were not recorded.
    kinds
        Kind of each of the readings; old journals do not have them.
    units
        Unit of each of the readings, where the file has it.
    commands
        Commands of each tick, by channel. Each has shape [T] and the unit of the channel. Empty if they were not
        recorded.
    channel_units
        Unit of each channel, where the file has it.
    pose
        Place of the robot after each tick, as "x" and "y", m, and "heading", rad. Each has shape [T]. Only traces have
        it; it is empty otherwise.
    presses
        Presses and corrections that took effect, in order of time.
    source
        The file from which the episode was read, or the name of the world.
    seed
        Seed of the simulated world; None if unknown.
    behavior
        Name of the automaton that ran or was taught; empty if unknown.
    """

    agent: str
    tick_s: float
    times: Column
    states: tuple[tuple[str, ...], ...]
    readings: Mapping[str, Column] = field(default_factory=dict)
    kinds: Mapping[str, Kind] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    commands: Mapping[str, Column] = field(default_factory=dict)
    channel_units: Mapping[str, str] = field(default_factory=dict)
    pose: Mapping[str, Column] = field(default_factory=dict)
    presses: tuple[EpisodePress, ...] = ()
    source: str = ""
    seed: int | None = None
    behavior: str = ""

    @property
    def ticks(self) -> int:
        """The number of ticks, T."""
        return len(self.times)
