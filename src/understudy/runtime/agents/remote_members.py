"""The members of a squad as their coordinator sees them: a body and a runner filled from their latest reports."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.model.features import Percept, ReadingKey
from understudy.runtime.agents.lateness import LatenessMeter
from understudy.runtime.agents.messages import MemberReport, OrderId, compute_layout
from understudy.runtime.body import Channel, Commands, Reading
from understudy.runtime.link import Program
from understudy.runtime.team.comms import SILENT_S


class TickClock(Protocol):
    """What the members of a team have in common with their coordinator: its clock, the tick, and the targets."""

    @property
    def time_s(self) -> float:
        """The time, s."""
        ...

    @property
    def tick_s(self) -> float:
        """The nominal length of a tick, s."""
        ...

    @property
    def targets(self) -> Sequence[str]:
        """The names of the targets."""
        ...


@dataclass
class ReportedMember:
    """The latest report of one member, and why it does not count.

    It counts as heard when its report would have arrived if nothing had held it up.
    """

    name: str
    report: MemberReport | None = None
    heard_s: float = field(default=-inf)
    problem: str = "was never heard"
    ended: set[int] = field(default_factory=set)
    """Former starts of the member's program."""

    def is_fresh(self, report: MemberReport) -> bool:
        """Return whether a report is newer than the last one, also if the member's program was started again."""
        last = self.report
        if last is None or report.start == last.start:
            return last is None or report.sequence > last.sequence
        return report.start not in self.ended


class RemoteMembers:
    """The members of one sort in one squad, as a body of N agents.

    Parameters
    ----------
    names
        The name of each member.
    readings
        The readings that members of this sort offer.
    keys
        The readings that they report.
    clock
        The coordinator's clock.
    library
        The fingerprint that their library must have; None: any.
    lease_clock
        The clock of silence, s; None: `clock`.
    """

    channels: Sequence[Channel] = ()

    def __init__(
        self,
        names: Sequence[str],
        readings: Sequence[Reading],
        keys: Sequence[ReadingKey],
        clock: TickClock,
        *,
        library: str | None = None,
        lease_clock: Callable[[], float] | None = None,
    ) -> None:
        self._lease_clock = lease_clock
        self.members = [ReportedMember(name) for name in names]
        self._by_name = {member.name: member for member in self.members}
        self.readings, self._keys, self._clock, self._library = tuple(readings), tuple(keys), clock, library
        self._layout = compute_layout(self._keys)
        self._lateness = LatenessMeter(len(names))
        self.order: OrderId | None = None
        """The present order: flags count only in reports that answer it."""

    @property
    def agents(self) -> int:
        """The number N of members."""
        return len(self.members)

    @property
    def targets(self) -> Sequence[str]:
        """The names of the targets."""
        return self._clock.targets

    @property
    def tick_s(self) -> float:
        """The nominal length of a tick, s."""
        return self._clock.tick_s

    @property
    def time_s(self) -> float:
        """The coordinator's time, s."""
        return self._clock.time_s

    @property
    def _now(self) -> float:
        return self._clock.time_s if self._lease_clock is None else self._lease_clock()

    def receive(self, report: MemberReport) -> float | None:
        """Take a report, unless it is not of one of these members, or older than the last one.

        Parameters
        ----------
        report
            The report.

        Returns
        -------
        float or None
            When it would have arrived if nothing had held it up, s; None if it was not taken, or is of a member with
            another library.
        """
        member = self._by_name.get(report.member)
        if member is None or not member.is_fresh(report):
            return None
        if member.report is not None and member.report.start != report.start:
            member.ended.add(member.report.start)
        now = self._now
        member.heard_s = now - self._lateness.measure(report.start, report.sent_s, now)
        member.report, member.problem = report, self._find_problem(report)
        return member.heard_s if self._library in (None, report.library) else None

    def _find_problem(self, report: MemberReport) -> str:
        if self._library is not None and report.library != self._library:
            return f"has another library ({report.library[:8]}, not {self._library[:8]})"
        if report.layout != self._layout or len(report.readings) != len(self._keys):
            return "reports other readings"
        return report.unfit

    def find_problem(self, member: ReportedMember) -> str:
        """Return why a member does not count now; empty if it counts."""
        if self._now - member.heard_s > SILENT_S:
            return "is silent" if member.report is not None else member.problem
        return member.problem

    @property
    def failed(self) -> NDArray[np.bool_]:
        """The members that do not count now [N]."""
        return np.array([self.find_problem(member) != "" for member in self.members], np.bool_)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return what members reported last, a column [N] for each key; NaN where absent."""
        reports = [member.report if self.find_problem(member) == "" else None for member in self.members]
        absent = [np.nan] * len(self._keys)
        table = np.array([absent if report is None else report.readings for report in reports])
        rows = {key: index for index, key in enumerate(self._keys)}
        return {key: table[:, rows[key]] if key in rows else np.full(self.agents, np.nan) for key in keys}

    def act(self, commands: Commands) -> None:
        """Refuse commands: members act by themselves."""
        raise SettingError(
            where="squad", setting="commands", problem="are for robots", remedy="give members orders"
        )


class RemoteRunner:
    """The runner of members that run on other computers: flags come from their reports; orders reach them by message.

    Parameters
    ----------
    body
        The members.
    """

    def __init__(self, body: RemoteMembers) -> None:
        self._body = body
        self.keys: tuple[ReadingKey, ...] = ()

    def begin(self, agents: NDArray[np.intp], program: Program) -> None:
        """Do nothing: the order that tells members what to begin is sent at every tick."""

    def find_raised(self, flag: str) -> NDArray[np.bool_]:
        """Find the members whose report answers the present order and has raised this flag [N]."""
        body = self._body
        return np.array(
            [
                member.report is not None
                and member.report.flag == flag
                and body.order is not None
                and member.report.order == body.order
                for member in body.members
            ],
            np.bool_,
        )

    def path(self, agent: int) -> tuple[str, ...]:
        """Return the states that a member reported last."""
        report = self._body.members[agent].report
        return () if report is None else tuple(report.path)

    def decide(self, percept: Percept) -> Mapping[str, NDArray[np.float64]]:
        """Return no commands: members decide by themselves."""
        return {}
