"""The head of a recording: which body it is of, and what ran on it, so that it can be decided again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import msgspec

from understudy.errors import UnderstudyError
from understudy.model.kinds import parse_kind
from understudy.runtime.body import Body, Channel, Reading
from understudy.storage.json_text import convert_decode_errors

FORMAT = "understudy-recording/1"
METADATA = "understudy"
"""The name of the record of metadata that holds the head."""
BODY, RUN, FILE = "body", "run", "file:"
"""Its keys: the body and what ran, as JSON; and files, as they were, each by its name."""
SCENARIO = "scenario"
"""The name of the scenario's file among them."""


class RunInfo(msgspec.Struct, frozen=True, kw_only=True):
    """What ran. `scenario` is a name or the path of a file, and `automata` has a fingerprint of each automaton that was
    used, by the sort of agents that it was taught to. Where a person taught, nothing ran: `behavior` is None. `world`
    is a fingerprint of the scenario, for a trace; a recording holds the scenario itself.
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
    """A body as the head has it: `names` are of its agents, the namespaces that their topics are in."""

    names: list[str]
    tick_s: float
    began_s: float
    readings: list[_HeadReading]
    targets: list[str]
    channels: list[_HeadChannel]


class RecordingHeader(msgspec.Struct, frozen=True):
    """All that a head says: the agents' names, what they sense and obey, when they began, what ran, and files."""

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
        """The head of a recording of a body that begins now."""
        return cls(
            tuple(names), body.tick_s, body.time_s, tuple(body.readings), tuple(body.targets),
            tuple(body.channels), ran, files,
        )  # fmt: skip


def encode_header(head: RecordingHeader) -> dict[str, str]:
    """A head as metadata."""
    readings = [_HeadReading(each.name, str(each.kind), each.unit, each.of_targets) for each in head.readings]
    channels = [_HeadChannel(each.name, each.rest, each.unit) for each in head.channels]
    body = _HeadBody(list(head.names), head.tick_s, head.began_s, readings, list(head.targets), channels)
    return {
        "format": FORMAT,
        BODY: msgspec.json.encode(body).decode(),
        RUN: msgspec.json.encode(head.ran).decode(),
        **{FILE + name: content for name, content in head.files.items()},
    }


def decode_header(entries: Mapping[str, str]) -> RecordingHeader | str:
    """The head that metadata holds, or what is wrong with it."""
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
