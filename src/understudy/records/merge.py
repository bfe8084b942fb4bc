"""Merging of the recordings of a team's agents into one file with one clock.

Each agent recorded when it sent its messages and when those of others arrived, by its own clock. From messages that two
of them exchanged, each clock is fitted to that of one of them, the reference (`clock_fit.py`).
"""

from __future__ import annotations

import heapq
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from errno import EEXIST
from functools import cached_property
from hashlib import blake2b
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np

from understudy.errors import FileError, SettingError, UnderstudyError, UnknownName, join_names
from understudy.extras import ExtraMissing
from understudy.records.clock_fit import ClockFit, NoExchange, fit_clock
from understudy.records.header import (
    AGENT,
    METADATA,
    PART,
    RecordingHeader,
    decode_header,
    name_metadata,
)
from understudy.records.reader import iterate_records
from understudy.records.recorder import HEARD, SENT
from understudy.records.writer import LIBRARY, PROFILE
from understudy.storage.atomic_write import UNFINISHED, convert_os_errors, sync_folder
from understudy.storage.json_text import encode_json

FORMAT = "understudy-team-recording/1"
TEAM_METADATA = "understudy-team"
"""The name of the metadata record of a merged recording, which says how its clock was found."""
CLOCKS = "clocks"
"""The key in it that has the clocks of all members, as JSON."""
REMEDY = "name a file that `understudy team agent` wrote, with --record"
NS = 1e9
"""The number of nanoseconds in a second."""


class MemberClock(msgspec.Struct, frozen=True, kw_only=True):
    """The clock of one agent, as estimated from its messages.

    Attributes
    ----------
    agent
        The agent.
    recording
        The name of its recording.
    ahead_s
        How far its clock was ahead of that of the reference at the beginning of its recording, s.
    drift_ppm
        By how much its clock is faster, in parts per million.
    error_s
        The largest error of its times in the merged recording, s.
    uneven_s
        How far its clock, or that of the reference, deviates from running evenly, s; 0: messages show no deviation.
    by_way_of
        Other agents by whose clocks it was compared with that of the reference, if not directly.
    messages
        The number of messages from which it was found.
    whole
        Whether its recording was closed, not killed.
    """

    agent: str
    recording: str
    ahead_s: float
    drift_ppm: float
    error_s: float
    uneven_s: float = 0.0
    by_way_of: list[str] = []
    messages: int = 0
    whole: bool = True


class TeamClock(msgspec.Struct, frozen=True, kw_only=True):
    """The clock of a merged recording: the reference agent, the recording's start, and the clocks of all members."""

    reference: str
    start_ns: int
    members: list[MemberClock]


@dataclass
class _Survey:
    """The part of one recording that merging needs: when each message was sent or heard, by its digest."""

    path: Path
    agent: str = ""
    sent: dict[bytes, int] = field(default_factory=dict)
    heard: dict[bytes, int] = field(default_factory=dict)
    first_ns: int = 0
    last_ns: int = 0
    messages: int = 0
    whole: bool = True

    def count_seconds(self, time_ns: int) -> float:
        """Return a time as seconds since the first message."""
        return (time_ns - self.first_ns) / NS

    @cached_property
    def last_s(self) -> float:
        """The time of the last message since the first, s."""
        return self.count_seconds(self.last_ns)


class _Link(NamedTuple):
    """A fit of the clock of `to` to that of another recording, and the number of messages behind it."""

    to: str
    fit: ClockFit
    messages: int


class _Route(NamedTuple):
    """The links from a recording's clock to that of the reference, and the largest error of its times."""

    links: tuple[_Link, ...]
    error_s: float


def merge_recordings(
    out: Path | str, paths: Sequence[Path | str], *, reference: str | None = None
) -> TeamClock:
    """Merge recordings of a team's agents into a new file with the clock of one of them.

    Parameters
    ----------
    out
        The new file.
    paths
        The recordings, each of another agent.
    reference
        The agent whose clock it gets; by default that of the first recording.

    Returns
    -------
    TeamClock
        The clock of the new file, with the error of each member's times.

    Raises
    ------
    FileError
        If a file is no recording of an agent, or the new file is there already or cannot be written.
    SettingError
        If two recordings are of one agent, or exchanged no messages.
    UnknownName
        If no recording is of the reference.
    """
    out = Path(out)
    if out.exists():
        remedy = "name another file, or move that one away"
        raise FileError(path=out, place="", problem="is there already", remedy=remedy)
    surveys: dict[str, _Survey] = {}
    for path in paths:
        survey = _survey_recording(Path(path))
        if survey.agent in surveys:
            problem = f"is a recording of {survey.agent}, as is {surveys[survey.agent].path}"
            raise SettingError(
                where="team merge", setting=str(path), problem=problem, remedy="name one of them"
            )
        surveys[survey.agent] = survey
    reference = next(iter(surveys)) if reference is None else reference
    if reference not in surveys:
        raise UnknownName(what="agent", name=reference, where="these recordings", known=list(surveys))
    routes = _find_routes(surveys, reference)
    clock = _describe_clock(surveys, routes, reference)
    _write(out, surveys, routes, clock)
    return clock


def read_team_clock(path: Path | str) -> TeamClock | None:
    """Read the clock of a merged recording; None if it is none."""
    from mcap.records import Message, Metadata

    with suppress(Exception):  # a reader can raise any error on incomplete or damaged bytes
        for record in iterate_records(Path(path)):
            if isinstance(record, Metadata) and record.name == TEAM_METADATA:
                return msgspec.json.decode(record.metadata[CLOCKS], type=TeamClock)
            if isinstance(record, Message):
                return None
    return None


def _survey_recording(path: Path) -> _Survey:
    """Read a recording: of which agent it is, and when it sent and heard messages."""
    from mcap.records import Channel, Message, Metadata

    survey, topics = _Survey(path), dict[int, str]()
    try:
        for record in iterate_records(path):
            if isinstance(record, Message):
                _note_message(survey, topics.get(record.channel_id, ""), record)
            elif isinstance(record, Channel):
                topics[record.id] = record.topic
            elif isinstance(record, Metadata):
                _note_header(survey, record)
    except UnderstudyError:
        raise
    except OSError as error:
        raise FileError(path=path, place="", problem=str(error.strerror or error), remedy=REMEDY) from None
    except Exception as error:  # a reader can raise any error on incomplete or damaged bytes
        if not survey.agent:
            raise FileError(
                path=path, place="", problem=f"is no recording ({error})", remedy=REMEDY
            ) from None
        survey.whole = False
    if not survey.agent or not survey.messages:
        problem = "has no message" if survey.agent else "is not a recording of an agent of a team"
        raise FileError(path=path, place="", problem=problem, remedy=REMEDY)
    return survey


def _note_header(survey: _Survey, record: Any) -> None:
    if record.name == TEAM_METADATA:
        remedy = "name the recordings that it was merged from"
        raise FileError(path=survey.path, place="", problem="is a merged recording", remedy=remedy)
    if record.name == METADATA or record.name.startswith(METADATA + PART):
        head = decode_header(record.metadata)
        if isinstance(head, RecordingHeader) and isinstance(head.ran.agent, str):
            survey.agent = head.ran.agent


def _note_message(survey: _Survey, topic: str, record: Any) -> None:
    survey.first_ns = min(survey.first_ns, record.log_time) if survey.messages else record.log_time
    survey.last_ns = max(survey.last_ns, record.log_time)
    survey.messages += 1
    if topic.endswith(SENT):  # random numbers of programs and sequences make each message another one
        survey.sent.setdefault(_digest(record.data), record.log_time)
    elif topic.endswith(HEARD):
        survey.heard.setdefault(_digest(record.data), record.log_time)


def _digest(data: bytes) -> bytes:
    return blake2b(data, digest_size=12).digest()


# Clocks


def _find_routes(surveys: Mapping[str, _Survey], reference: str) -> dict[str, _Route]:
    """Find the most exact way from each recording's clock to that of the reference."""
    links = {name: _find_links(name, surveys) for name in surveys}
    routes = {name: _find_route(name, links, surveys[name].last_s, reference) for name in surveys}
    apart = [name for name, route in routes.items() if route is None]
    if apart:
        raise SettingError(
            where="team merge",
            setting=join_names(apart),
            problem=f"exchanged no messages in both directions with {reference}, directly or by way of others",
            remedy="merge recordings of agents that ran at the same time",
        )
    return {name: route for name, route in routes.items() if route is not None}


def _find_links(name: str, surveys: Mapping[str, _Survey]) -> list[_Link]:
    """Fit the clock of each other recording to that of this one, where they exchanged messages."""
    own, links = surveys[name], list[_Link]()
    for other in surveys.values():
        if other is own:
            continue
        received = _pair(own, own.heard, other, other.sent)
        sent = _pair(own, own.sent, other, other.heard)
        with suppress(NoExchange):
            fit = fit_clock(received, sent, 0.0, own.last_s)
            links.append(_Link(other.agent, fit, len(received) + len(sent)))
    return links


def _pair(own: _Survey, mine: Mapping[bytes, int], other: _Survey, theirs: Mapping[bytes, int]) -> Any:
    """Return the times of common messages by both clocks [N, 2], s."""
    pairs = [
        (own.count_seconds(at_ns), other.count_seconds(theirs[digest]))
        for digest, at_ns in mine.items()
        if digest in theirs
    ]
    return np.array(pairs, np.float64).reshape(-1, 2)


def _find_route(
    name: str, links: Mapping[str, Sequence[_Link]], last_s: float, reference: str
) -> _Route | None:
    """Find the route with the smallest error (Dijkstra's algorithm); None if there is none."""
    waiting: list[tuple[float, int, str, tuple[_Link, ...], float, float]] = [(0.0, 0, name, (), 0.0, last_s)]
    reached, count = set[str](), 0
    while waiting:
        error_s, _, at, route, first, last = heapq.heappop(waiting)
        if at == reference:
            return _Route(route, error_s)
        if at in reached:
            continue
        reached.add(at)
        for link in links[at]:
            count += 1
            fit = link.fit
            further_s = error_s * fit.rate + fit.find_largest_error(first - error_s, last + error_s)
            step = (*route, link), fit.convert(first), fit.convert(last)
            heapq.heappush(waiting, (further_s, count, link.to, *step))
    return None


def _convert_time(survey: _Survey, route: _Route, surveys: Mapping[str, _Survey], time_ns: int) -> int:
    """Return the time of the reference's clock (ns) at a time of a recording's clock."""
    if not route.links:
        return time_ns
    time_s = survey.count_seconds(time_ns)
    for link in route.links:
        time_s = link.fit.convert(time_s)
    return surveys[route.links[-1].to].first_ns + round(time_s * NS)


def _describe_clock(
    surveys: Mapping[str, _Survey], routes: Mapping[str, _Route], reference: str
) -> TeamClock:
    members, starts = [], []
    for name, survey in surveys.items():
        route = routes[name]
        start_ns = _convert_time(survey, route, surveys, survey.first_ns)
        starts.append(start_ns)
        rate = float(np.prod([link.fit.rate for link in route.links]))
        members.append(
            MemberClock(
                agent=name,
                recording=survey.path.name,
                ahead_s=(survey.first_ns - start_ns) / NS,
                drift_ppm=round((1 / rate - 1) * 1e6, 3),
                error_s=route.error_s,
                uneven_s=sum(link.fit.uneven_s for link in route.links),
                by_way_of=[link.to for link in route.links[:-1]],
                messages=sum(link.messages for link in route.links),
                whole=survey.whole,
            )
        )
    return TeamClock(reference=reference, start_ns=min(starts), members=members)


# Writing


def _write(out: Path, surveys: Mapping[str, _Survey], routes: Mapping[str, _Route], clock: TeamClock) -> None:
    """Write the merged file under another name, and give it its own once it is complete."""
    unfinished = out.with_name(f".{out.name}.{os.getpid()}{UNFINISHED}")
    remedy = "name a file in a folder you may write to"
    with convert_os_errors(out, "writing", remedy=remedy):
        for left in out.parent.glob(f".{out.name}.*{UNFINISHED}"):  # of a merge that was killed
            left.unlink(missing_ok=True)
        try:
            with unfinished.open("xb") as file:
                _write_records(file, surveys, routes, clock)
                file.flush()
                os.fsync(file.fileno())
            _give_name(unfinished, out)
        finally:
            unfinished.unlink(missing_ok=True)
        sync_folder(out.parent)


def _give_name(unfinished: Path, out: Path) -> None:
    """Give a file its name, unless another one has it by now."""
    try:
        os.link(unfinished, out)
    except FileExistsError:
        raise
    except OSError:  # no links there, as on memory sticks
        if out.exists():
            raise FileExistsError(EEXIST, os.strerror(EEXIST), str(out)) from None
        unfinished.rename(out)


def _write_records(
    file: Any, surveys: Mapping[str, _Survey], routes: Mapping[str, _Route], clock: TeamClock
) -> None:
    try:
        from mcap.writer import Writer
    except ImportError:
        raise ExtraMissing(what="a recording", extra="ros2") from None
    from mcap.records import Message, Metadata

    writer: Any = Writer(file)
    writer.start(profile=PROFILE, library=LIBRARY)
    writer.add_metadata(
        TEAM_METADATA,
        {"format": FORMAT, "reference": clock.reference, CLOCKS: encode_json(clock).decode()},
    )
    channels = _Channels(writer)
    streams = [
        _iterate_converted(number, survey, routes[survey.agent], surveys)
        for number, survey in enumerate(surveys.values())
    ]
    for _, _, agent, time_ns, record in heapq.merge(*streams, key=lambda each: each[:2]):
        if isinstance(record, Message):
            channel = channels.find(agent, record.channel_id)
            writer.add_message(channel, time_ns, record.data, time_ns, record.sequence)
        elif isinstance(record, Metadata):
            part = record.name.partition(PART)[2] or agent
            writer.flush()  # so that it stands before what follows it
            writer.add_metadata(name_metadata(part), record.metadata)
        else:
            channels.add(agent, record)
    writer.finish()


def _iterate_converted(
    number: int, survey: _Survey, route: _Route, surveys: Mapping[str, _Survey]
) -> Iterator[tuple[int, int, str, int, Any]]:
    """Yield a recording's records in its order: the place in the merged file, the agent, the converted time."""
    from mcap.records import Channel, Message, Metadata, Schema

    place_ns, left = _convert_time(survey, route, surveys, survey.first_ns), survey.messages
    for record in iterate_records(survey.path):
        if not isinstance(record, (Channel, Message, Metadata, Schema)):
            continue
        time_ns = place_ns
        if isinstance(record, Message):
            left -= 1
            time_ns = _convert_time(survey, route, surveys, record.log_time)
            place_ns = max(place_ns, time_ns)
        yield place_ns, number, survey.agent, time_ns, record
        if not left:  # the rest of a file that was not closed is damaged
            return


class _Channels:
    """The topics of the merged file, by agent and by number in its recording."""

    def __init__(self, writer: Any) -> None:
        self._writer = writer
        self._schemas: dict[tuple[str, str, bytes], int] = {}
        self._of_agents: dict[tuple[str, int], int] = {}
        self._channels: dict[tuple[str, int], int] = {}

    def add(self, agent: str, record: Any) -> None:
        """Take over the schema or the channel of a recording."""
        if hasattr(record, "topic"):
            schema = self._of_agents.get((agent, record.schema_id), 0)
            metadata = {**record.metadata, AGENT: agent}
            channel = self._writer.register_channel(record.topic, record.message_encoding, schema, metadata)
            self._channels[agent, record.id] = channel
            return
        key = record.name, record.encoding, record.data
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(*key)
        self._of_agents[agent, record.id] = self._schemas[key]

    def find(self, agent: str, number: int) -> int:
        """Return the number of a topic in the merged file."""
        return self._channels[agent, number]
