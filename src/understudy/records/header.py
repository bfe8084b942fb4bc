"""Headers of recordings: the body, and what ran on it, so that its decisions can be made again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import msgspec

from understudy.errors import UnderstudyError
from understudy.model.value_kinds import parse_kind
from understudy.runtime.body import Body, Channel, Reading
from understudy.storage.json_text import convert_decode_errors, encode_json

FORMAT = "understudy-recording/1"
METADATA = "understudy"
"""The name of the metadata record that has the header."""
BODY, RUN, FILE = "body", "run", "file:"
"""The keys in the header: the body and what ran, as JSON, and the prefix of the names of files stored with it."""
AGENT = "agent"
"""The key of the agent whose message it is, in the metadata of a topic of a merged recording."""
PART = ":"
"""The sign between `METADATA` and the name of a part, in the name of its metadata record."""
SCENARIO = "scenario"
"""The name under which the scenario's file is stored."""


class RunInfo(msgspec.Struct, frozen=True, kw_only=True):
    """A description of what ran on a body.

    `scenario` is a name or the path of a file. `automata` has the fingerprint of each automaton that was used, by
    sort of agent and name. `behavior` is None if a person taught. `world` is the fingerprint of the scenario, in
    traces only, because a recording stores the scenario itself. `agent` is the name of the agent of a team that made
    the recording, and `squad` the squad that it leads in this part of it.
    """

    scenario: str | None = None
    world: str | msgspec.UnsetType = msgspec.UNSET
    seed: int = 0
    kit: str | None = None
    library: str = "library"
    sorts: list[str] = []
    behavior: str | None = None
    binding: dict[str, str] = {}
    automata: dict[str, dict[str, str]] = {}
    agent: str | msgspec.UnsetType = msgspec.UNSET
    squad: str | msgspec.UnsetType = msgspec.UNSET


def name_metadata(part: str) -> str:
    """Return the name of the metadata record that has the header of a part; "" is the recording as a whole."""
    return METADATA + PART + part if part else METADATA


def format_part(squad: str, host: str) -> str:
    """Return the name of the part of a recording with the decisions for a squad that an agent, its host, made."""
    return f"{squad}/{host}"


class _HeadReading(msgspec.Struct, frozen=True, omit_defaults=True):
    name: str
    kind: str
    unit: str = ""
    of_targets: bool = False


class _HeadChannel(msgspec.Struct, frozen=True, omit_defaults=True):
    name: str
    rest: float = 0.0
    unit: str = ""


class _HeadBody(msgspec.Struct, frozen=True):
    """The body in a header; `names` are the namespaces of its agents' topics."""

    names: list[str]
    tick_s: float
    began_s: float
    readings: list[_HeadReading]
    targets: list[str]
    channels: list[_HeadChannel]


class ReadingInfo(msgspec.Struct, frozen=True):
    """The kind of a reading, as files write it, and its unit."""

    kind: str
    unit: str = ""


class RecordingHeader(msgspec.Struct, frozen=True):
    """The header of a recording.

    `names` are the namespaces of the agents' topics, `began_s` is the body's time at the start, `ran` is what ran,
    and `files` has the stored files by name.
    """

    names: Sequence[str]
    tick_s: float
    began_s: float
    readings: Sequence[Reading]
    targets: Sequence[str]
    channels: Sequence[Channel]
    ran: RunInfo
    files: Mapping[str, str]

    @classmethod
    def from_body(
        cls, body: Body, names: Sequence[str], ran: RunInfo, files: Mapping[str, str]
    ) -> RecordingHeader:
        """Make the header of a recording of a body that begins now."""
        return cls(
            tuple(names), body.tick_s, body.time_s, tuple(body.readings), tuple(body.targets),
            tuple(body.channels), ran, files,
        )  # fmt: skip


def encode_header(head: RecordingHeader) -> dict[str, str]:
    """Encode a header as metadata."""
    readings = [_HeadReading(each.name, str(each.kind), each.unit, each.of_targets) for each in head.readings]
    channels = [_HeadChannel(each.name, each.rest, each.unit) for each in head.channels]
    body = _HeadBody(list(head.names), head.tick_s, head.began_s, readings, list(head.targets), channels)
    return {
        "format": FORMAT,
        BODY: encode_json(body).decode(),
        RUN: encode_json(head.ran).decode(),
        **{FILE + name: content for name, content in head.files.items()},
    }


def decode_header(entries: Mapping[str, str]) -> RecordingHeader | str:
    """Decode a header from metadata; return a text about what is wrong if that fails."""
    if entries.get("format") != FORMAT:
        return f"its format is {entries.get('format')!r:.60}, not {FORMAT!r}"
    try:
        with convert_decode_errors():
            body = msgspec.json.decode(entries[BODY], type=_HeadBody)
            ran = msgspec.json.decode(entries[RUN], type=RunInfo)
        readings = [
            Reading(each.name, parse_kind(each.kind, where=each.name), each.unit, each.of_targets)
            for each in body.readings
        ]
    except (KeyError, msgspec.MsgspecError, UnderstudyError) as error:
        return f"its header cannot be read ({error})"
    channels = [Channel(each.name, each.rest, each.unit) for each in body.channels]
    files = {key.removeprefix(FILE): text for key, text in entries.items() if key.startswith(FILE)}
    return RecordingHeader(
        tuple(body.names), body.tick_s, body.began_s, tuple(readings), tuple(body.targets), tuple(channels), ran, files
    )  # fmt: skip
