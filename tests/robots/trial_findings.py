"""What the recordings of all agents and of the simulated world say about trials with agents."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from statistics import median
from typing import Any

from understudy.runtime.agents.coordinator import LEASE_S
from understudy_lab.lossy_networks.distributed_patrol import MEMBERS, ROBOTS, read_lines
from understudy_lab.lossy_networks.simulated_robots import WORLD

FRESH_S = 0.25
"""An agent leads until so long after the tick in which it recorded that, s."""
HANDOVER_S = 0.3
"""When a deputy takes over, members hear of it one after the other, within this time, s."""
TOO_OLD_S = LEASE_S + 0.2


@dataclass(frozen=True, slots=True)
class Trial:
    """The kind of trouble, whom it befell, from when to when, and until when the team was watched."""

    kind: str
    name: str
    began_s: float
    ended_s: float
    watched_s: float


@dataclass(frozen=True, slots=True)
class Finding:
    """What was found in one trial.

    Attributes
    ----------
    oldest_s
        The age of the oldest order on which a robot moved.
    leaderless_s
        How long it took until another agent led; None if the one in trouble did not lead.
    healed_s
        How long after the trouble it took until one agent led, and it alone, from then on; None if it never did.
    two_s
        The longest time for which robots that could hear each other obeyed two coordinators.
    moving
        How many of the other robots moved during the trouble.
    """

    oldest_s: float
    leaderless_s: float | None
    healed_s: float | None
    two_s: float
    moving: int


class Recordings:
    """The recordings of all agents, and of the world, in a folder."""

    def __init__(self, folder: Path) -> None:
        self._lines = {name: read_lines(folder / f"{name}.jsonl") for name in MEMBERS}
        self._times = {name: [line["ended_s"] for line in lines] for name, lines in self._lines.items()}
        self._world = read_lines(folder / WORLD)
        self._world_times = [line["at_s"] for line in self._world]

    @cached_property
    def sent_s(self) -> dict[tuple[int, int], float]:
        """When each message was sent, by term and number."""
        return {
            tuple(line["leads"]): line["began_s"]
            for lines in self._lines.values()
            for line in lines
            if "leads" in line
        }

    def find_line(self, name: str, at_s: float) -> Any:
        """Return what an agent recorded last before a time; {} if nothing."""
        index = bisect_right(self._times[name], at_s) - 1
        return self._lines[name][index] if index >= 0 else {}

    def find_leaders(self, at_s: float) -> set[str]:
        """Return the agents that led at a time."""
        found = {name: self.find_line(name, at_s) for name in MEMBERS}
        return {name for name, line in found.items() if "leads" in line and at_s - line["ended_s"] < FRESH_S}

    def judge(self, trial: Trial) -> Finding:
        """Find out what happened in a trial."""
        first, last = (bisect_right(self._world_times, at_s) for at_s in (trial.began_s, trial.watched_s))
        ages, moving = [0.0], set[str]()
        two_s = longest_two_s = 0.0
        before_s = trial.began_s
        for line in self._world[first:last]:
            at_s = line["at_s"]
            obeyed: set[str] = set()
            leaders = self.find_leaders(at_s)
            for name, command in zip(ROBOTS, line["commands"], strict=True):
                did = self.find_line(name, at_s)
                if "obeys" not in did:
                    continue
                if any(command):
                    ages.append(at_s - self.sent_s[tuple(did["obeys"])])
                    if name != trial.name and at_s < trial.ended_s:
                        moving.add(name)
                if did["leader"] in leaders and not (name == trial.name and at_s < trial.ended_s + 1.0):
                    obeyed.add(did["leader"])
            two_s = two_s + at_s - before_s if len(obeyed) > 1 else 0.0
            longest_two_s, before_s = max(longest_two_s, two_s), at_s
        return Finding(
            max(ages), self._measure_takeover(trial), self._measure_healing(trial), longest_two_s, len(moving)
        )

    def _measure_takeover(self, trial: Trial) -> float | None:
        if trial.name not in self.find_leaders(trial.began_s):
            return None
        for step in range(round((trial.ended_s - trial.began_s) / 0.01)):
            if self.find_leaders(trial.began_s + step * 0.01) - {trial.name}:
                return step * 0.01
        return float("inf")

    def _measure_healing(self, trial: Trial) -> float | None:
        alone_s = None
        for step in range(round((trial.watched_s - trial.ended_s) / 0.01)):
            if len(self.find_leaders(trial.ended_s + step * 0.01)) != 1:
                alone_s = None
            elif alone_s is None:
                alone_s = step * 0.01
        return alone_s


def format_findings(recordings: Recordings, trials: list[Trial]) -> str:
    """Say in a few lines what was found in all trials so far, by kind."""
    lines = []
    for kind in dict.fromkeys(trial.kind for trial in trials):
        found = [recordings.judge(trial) for trial in trials if trial.kind == kind]
        without = [each.leaderless_s for each in found if each.leaderless_s is not None]
        healed = [float("inf") if each.healed_s is None else each.healed_s for each in found]
        oldest = [each.oldest_s for each in found]
        lines.append(
            f"{kind}, {len(found)} times: robots moved on orders up to {max(oldest):.2f} s old "
            f"({sum(each > TOO_OLD_S for each in oldest)} times over {TOO_OLD_S:g} s); "
            f"{_format(without, 'a deputy led after')}; {_format(healed, 'one led after the trouble within')} "
            f"({sum(each > 1.0 for each in healed)} times over 1 s); two coordinators obeyed for at most "
            f"{max(each.two_s for each in found):.2f} s ({sum(each.two_s > HANDOVER_S for each in found)} times over "
            f"{HANDOVER_S:g} s); {min(each.moving for each in found)} to {max(each.moving for each in found)} "
            "of the others moved"
        )
    return "\n".join(lines)


def _format(values: list[float], said: str) -> str:
    if not values:
        return f"{said}: no trial"
    return f"{said} {median(values):.2f} s in the middle, {max(values):.2f} s at worst, of {len(values)}"
