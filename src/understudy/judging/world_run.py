"""The run of a behavior in one world, which goals and metrics of one's own are functions of."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.judging.behavior_run import BehaviorRun, RunReading, TeamRun
from understudy.judging.outcomes import SuccessMonitor
from understudy.judging.rollout import Instant, Monitor
from understudy.model.value_kinds import Column
from understudy.runtime.body import Body
from understudy.runtime.team.team import Team
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World


class WorldRun:
    """The run of a behavior in one world.

    Goals are evaluated on it before the first tick and after each one, metrics at its end.

    Parameters
    ----------
    run
        The behavior, running in a single world.
    seed
        The seed of the world.
    limit_s
        The time limit, s.
    """

    def __init__(self, run: BehaviorRun, seed: int, limit_s: float) -> None:
        self.seed, self.limit_s = seed, limit_s
        self.body: Body = run.body
        """The body of the robots: a `World`, or what the function given to `evaluate` made."""
        self.team: Team | None = run.team
        """The team, if not all robots run the behavior by themselves."""
        self.finished = False
        """Whether the goal was reached in time; known at the end."""
        self.recorded: Mapping[str, NDArray[Any]] = {}
        """What was recorded, by name: [T + 1, ...] for T ticks; known at the end."""
        self._run, self._began_s = run, run.body.time_s
        self._readings: dict[str, RunReading] = {}
        if isinstance(run, TeamRun):
            run.sense_all()

    def __repr__(self) -> str:
        return f"<WorldRun of seed {self.seed}, {self.seconds:.1f} s>"

    @property
    def seconds(self) -> float:
        """The time since the run began, s."""
        return self.body.time_s - self._began_s

    @property
    def positions(self) -> NDArray[np.float64]:
        """The places of the robots of a scenario [N, 2], m."""
        if not isinstance(self.body, World):
            raise AttributeError("a body of one's own has no positions that are known here")
        robots = self.body.state.robots
        return np.stack([robots["x"], robots["y"]], axis=1)

    def read(self, name: str) -> Column:
        """Read a feature of the kit or a reading of the body.

        Parameters
        ----------
        name
            Its name, with targets in parentheses where it needs them: "distance_to(station)".

        Returns
        -------
        array, shape [N]
            The present value of each agent that has it, in the reading's unit; NaN where absent.

        Raises
        ------
        UnknownName
            If neither the kit nor the body has it.
        """
        if name not in self._readings:
            self._readings[name] = self._run.find_reading(name)
        values: Column = self._readings[name].read()[0]
        return values

    def has_raised(self, flag: str) -> bool:
        """Return whether all agents that run the behavior have raised a flag.

        Parameters
        ----------
        flag
            Name of the flag.

        Returns
        -------
        bool
            True if they have.
        """
        return bool(self._run.find_raised(flag)[0])


class SuccessRule(ABC):
    """What success means in the worlds of a scenario, where it is more than a flag or a reading."""

    @property
    @abstractmethod
    def name(self) -> str:
        """What has to be, in words."""

    @abstractmethod
    def find_limit(self, scenario: Scenario) -> float:
        """Return the time limit in a scenario, s."""

    @abstractmethod
    def make_monitor(self, run: BehaviorRun, flags: Collection[str]) -> SuccessMonitor:
        """Make what decides about the worlds of a run, given the flags that its behavior can raise.

        UnknownName or SettingError is raised if the scenario or the behavior lacks something that it names.
        """


Goal: TypeAlias = str | Callable[[WorldRun], Any] | SuccessRule
"""The name of a flag, or of a reading that is yes or no, a function that returns whether a run has succeeded, or a rule
for worlds of a scenario."""

Metric: TypeAlias = str | Callable[[WorldRun], Any]
"""The name of a feature or reading, or a function that computes a number from a run."""


def name_value(value: str | Callable[..., Any] | SuccessRule) -> str:
    """Return the name of a goal or metric: a text itself, or the name of a function or rule."""
    if isinstance(value, SuccessRule):
        return value.name
    return value if isinstance(value, str) else str(getattr(value, "__name__", type(value).__name__))


class TickRecorder(Monitor):
    """Recorder of the run of one world, before its first tick and after each one."""

    def __init__(self, run: WorldRun, values: Mapping[str, Metric]) -> None:
        super().__init__(1)
        self._run, self._values = run, values
        self._rows: dict[str, list[NDArray[Any]]] = {name: [] for name in values}

    def look(self, now: Instant) -> None:
        """Record the present values."""
        for name, value in self._values.items():
            recorded = self._run.read(value) if isinstance(value, str) else value(self._run)
            self._rows[name].append(np.array(recorded))

    @property
    def rows(self) -> dict[str, NDArray[Any]]:
        """What was recorded, by name [T + 1, ...]."""
        return {name: np.array(rows) for name, rows in self._rows.items()}


def compute_metric(run: WorldRun, metric: Callable[[WorldRun], Any]) -> tuple[float, str | None]:
    """Compute a metric at the end of a run; if that is not possible, return NaN and what the matter is."""
    try:
        result = metric(run)
    except Exception as error:  # a function of a user's own
        return np.nan, f"raised {format_exception(error)}"
    try:
        value = float(np.asarray(result, np.float64).item())
    except (TypeError, ValueError):
        return np.nan, f"gave {result!r:.60}, which is not one number"
    return value, ABSENT if np.isnan(value) else None


ABSENT = "is absent (NaN)"


def describe_problem(seed: int, metric: str, problem: str) -> str:
    """Return the sentence about a metric that is absent in a world."""
    return f"in the world of seed {seed}, metric {metric!r} {problem}"


def format_exception(error: BaseException, *, last: int | None = None) -> str:
    """Return the type and message of an exception, or only its `last` lines, in one line of at most 300 characters."""
    lines = str(error).strip().splitlines()
    message = " ".join(line.strip() for line in lines[-last if last else None :])
    return f"{type(error).__name__}: {message}".removesuffix(": ")[:300]


def average(values: Iterable[float] | Column) -> float:
    """Return the mean of the values that are not NaN; NaN if all are."""
    present = np.asarray(values, np.float64)
    present = present[~np.isnan(present)]
    return float(present.mean()) if present.size else float("nan")
