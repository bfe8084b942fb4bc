"""Reader of the recordings of a team's agents, merged or of one agent: their runs, and the messages between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from understudy.errors import FileError
from understudy.records.header import AGENT
from understudy.records.merge import MemberClock, TeamClock, read_team_clock
from understudy.records.message_types import decode_team_message
from understudy.records.messages import MessageRefused
from understudy.records.reader import Recording, iterate_records, list_recorded_parts, read_recording
from understudy.records.recorder import HEARD, SENT
from understudy.runtime.agents.agent import order_key, report_key
from understudy.runtime.agents.messages import (
    MemberReport,
    Orders,
    UnreadableMessage,
    decode_orders,
    decode_report,
)

NS = 1e9


@dataclass(frozen=True, slots=True)
class LoggedOrders:
    """A coordinator's message in the recording of an agent, which sent or received it, and when, ns since 1970."""

    agent: str
    is_sent: bool
    logged_ns: int
    orders: Orders


@dataclass(frozen=True, slots=True)
class LoggedReport:
    """A member's report as one agent heard it, and when, ns since 1970."""

    agent: str
    logged_ns: int
    report: MemberReport


@dataclass(frozen=True)
class TeamRecording:
    """The recordings of several agents of a team, or of one.

    Attributes
    ----------
    path
        The file.
    clock
        Its clock.
    parts
        The names of what was recorded: agents, and SQUAD/AGENT for the squads that an agent led; and those of these
        parts in the file.
    orders
        The messages of coordinators, in order of time.
    reports
        The reports that were heard, in order of time.
    """

    path: Path
    clock: TeamClock
    parts: Mapping[str, str]
    orders: Sequence[LoggedOrders]
    reports: Sequence[LoggedReport]

    def count_seconds(self, time_ns: int) -> float:
        """Return a time as seconds since the recording's beginning."""
        return (time_ns - self.clock.start_ns) / NS

    def read_part(self, part: str) -> Recording:
        """Read the last run of an agent or a coordinator."""
        return read_recording(self.path, part=self.parts[part])

    def find_error(self, agent: str) -> float:
        """Return the largest error of an agent's times, s."""
        return next((each.error_s for each in self.clock.members if each.agent == agent), 0.0)


def read_team_recording(path: Path | str) -> TeamRecording | None:
    """Read a merged recording, or that of one agent of a team; return None if the file is neither.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    TeamRecording or None
        The recording, up to where it is damaged.
    """
    path = Path(path)
    clock = read_team_clock(path)
    parts = {part: part for part in list_recorded_parts(path)}
    if clock is None:
        agent = _find_agent(path, list(parts))
        if agent is None:
            return None
        clock = TeamClock(reference=agent, start_ns=_find_start(path), members=[_make_own_clock(agent, path)])
        parts = {part or agent: part for part in parts}
    orders, reports = list[LoggedOrders](), list[LoggedReport]()
    with suppress(Exception):  # a reader can raise any error on incomplete or damaged bytes
        _read_messages(path, clock.reference, orders, reports)
    return TeamRecording(path, clock, parts, orders, reports)


def _find_agent(path: Path, parts: Sequence[str]) -> str | None:
    for part in parts:
        with suppress(FileError):
            agent = read_recording(path, part=part).head.ran.agent
            return agent if isinstance(agent, str) else None
    return None


def _find_start(path: Path) -> int:
    from mcap.records import Message

    first = next((each.log_time for each in iterate_records(path) if isinstance(each, Message)), 0)
    return int(first)


def _make_own_clock(agent: str, path: Path) -> MemberClock:
    return MemberClock(agent=agent, recording=path.name, ahead_s=0.0, drift_ppm=0.0, error_s=0.0)


def _read_messages(
    path: Path, reference: str, orders: list[LoggedOrders], reports: list[LoggedReport]
) -> None:
    from mcap.records import Channel, Message

    channels: dict[int, tuple[str, bool]] = {}
    for record in iterate_records(path):
        if isinstance(record, Channel) and record.topic.endswith((SENT, HEARD)):
            channels[record.id] = record.metadata.get(AGENT, reference), record.topic.endswith(SENT)
        if not isinstance(record, Message) or record.channel_id not in channels:
            continue
        agent, is_sent = channels[record.channel_id]
        with suppress(MessageRefused, UnreadableMessage):
            key, content = decode_team_message(record.data)
            if key.startswith(order_key("")):
                orders.append(LoggedOrders(agent, is_sent, record.log_time, decode_orders(content)))
            elif key.startswith(report_key("")) and not is_sent:
                reports.append(LoggedReport(agent, record.log_time, decode_report(content)))
