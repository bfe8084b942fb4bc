"""Merged recordings of a team: one clock, whatever the clocks of its computers were, and all that was recorded."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from errno import EPERM
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("mcap", reason="needs the extra ros2")

from mcap.reader import make_reader
from tests.ui.cli.commands import run

from understudy.errors import FileError, SettingError, UnderstudyError, UnknownName
from understudy.records import writer
from understudy.records.header import RecordingHeader, RunInfo, encode_header
from understudy.records.merge import TEAM_METADATA, merge_recordings, read_team_clock
from understudy.records.message_types import TEAM_MESSAGE, register_message_types
from understudy.records.messages import decode_message, encode_message, make_message
from understudy.records.reader import list_recorded_parts, read_recording
from understudy.records.recorder import HEARD, SENT
from understudy.records.writer import RecordingWriter

S = 10**9
BEGAN_NS = 1_800_000_000 * S
Delays = Mapping[tuple[str, str], float]


def make_data(agent: str, tick: int) -> bytes:
    """The message of an agent at a tick, as it is recorded."""
    register_message_types()
    content = np.frombuffer(str(tick).encode(), np.uint8)
    return encode_message(TEAM_MESSAGE, make_message(TEAM_MESSAGE, key=agent, data=content))


@dataclass
class Clocks:
    """Computers with clocks of their own, which send each other a message at each tick."""

    ahead_s: Mapping[str, float]
    drift: Mapping[str, float] = field(default_factory=dict)
    links: Delays = field(default_factory=dict)
    """The longest delay in s of the messages of each to each; those that are left out hear nothing."""
    sent_s: dict[bytes, float] = field(default_factory=dict)
    """When each message was sent in truth, s."""

    def show(self, name: str, true_s: float) -> int:
        """What a computer's clock shows, ns."""
        own_s = true_s * (1 + self.drift.get(name, 0.0)) + self.ahead_s[name]
        return BEGAN_NS + round(own_s * S)

    def record(self, folder: Path, seconds: float = 20.0, tick_s: float = 0.1) -> list[Path]:
        """Record a run of all."""
        dice = random.Random(1)
        written: dict[str, list[tuple[int, str, bytes]]] = {name: [] for name in self.ahead_s}
        for tick in range(round(seconds / tick_s)):
            for name in self.ahead_s:
                at_s = tick * tick_s + dice.random() * tick_s
                data = make_data(name, tick)
                self.sent_s[data] = at_s
                written[name].append((self.show(name, at_s), SENT, data))
                for (sender, receiver), longest_s in self.links.items():
                    if sender == name:
                        heard_s = at_s + dice.random() * longest_s
                        written[receiver].append((self.show(receiver, heard_s), HEARD, data))
        return [write(folder / f"{name}.mcap", name, messages) for name, messages in written.items()]


def write(path: Path, name: str, messages: list[tuple[int, str, bytes]], *, agent: bool = True) -> Path:
    """A recording with these messages, by their times."""
    made = RecordingWriter(path)
    head = RecordingHeader((name,), 0.1, 0.0, (), (), (), RunInfo(agent=name) if agent else RunInfo(), {})
    made.write_header(encode_header(head))
    for topic in (SENT, HEARD):
        made.add_topic(f"/{name}/{topic}", TEAM_MESSAGE)
    for at_ns, topic, data in sorted(messages):
        made.write_message((SENT, HEARD).index(topic), data, at_ns)
    made.close()
    assert not made.problem
    return path


def both_ways(*pairs: tuple[str, str, float]) -> Delays:
    return {way: delay for one, other, delay in pairs for way in ((one, other), (other, one))}


CLOCKS = {
    "equal clocks": Clocks({"a": 0.0, "b": 0.0}, links=both_ways(("a", "b", 0.005))),
    "an hour ahead": Clocks({"a": 0.0, "b": 3600.0}, links=both_ways(("a", "b", 0.005))),
    "fifty years behind": Clocks({"a": 0.0, "b": -1_577_880_000.0}, links=both_ways(("a", "b", 0.005))),
    "asymmetric": Clocks({"a": 0.0, "b": 0.3}, links={("a", "b"): 0.2, ("b", "a"): 0.001}),
    "drift": Clocks({"a": 0.0, "b": 5.0}, {"b": 3e-4, "a": -1e-4}, both_ways(("a", "b", 0.02))),
    "by way of b": Clocks(
        {"a": 0.0, "b": -70.0, "c": 9.0}, {"c": 1e-4}, both_ways(("a", "b", 0.01), ("b", "c", 0.01))
    ),
    "the nearer way": Clocks(
        {"a": 0.0, "b": 1.0, "c": 2.0}, links=both_ways(("a", "c", 5.0), ("a", "b", 0.01), ("b", "c", 0.01))
    ),
}


@pytest.mark.parametrize("name", CLOCKS)
def test_all_times_are_within_the_error(name: str, tmp_path: Path) -> None:
    """What happened at one true time stands at one time in the merged file, to within the stated error."""
    clocks = CLOCKS[name]
    found = merge_recordings(tmp_path / "team.mcap", clocks.record(tmp_path))
    errors = {each.agent: each.error_s for each in found.members}
    assert errors["a"] == 0.0
    assert all(0.0 < error < 0.3 for agent, error in errors.items() if agent != "a")
    sent_ns: dict[bytes, int] = {}
    with (tmp_path / "team.mcap").open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages(log_time_order=False):
            if channel.topic.endswith(SENT):
                sent_ns[message.data] = message.log_time
    assert len(sent_ns) == len(clocks.sent_s)
    for data, at_s in clocks.sent_s.items():
        sender = decode_message(TEAM_MESSAGE, data).key
        assert abs(sent_ns[data] - clocks.show("a", at_s)) / S <= errors[sender] + 1e-6


def test_the_most_exact_way_is_taken(tmp_path: Path) -> None:
    found = merge_recordings(tmp_path / "team.mcap", CLOCKS["the nearer way"].record(tmp_path))
    assert [each.by_way_of for each in found.members] == [[], [], ["b"]]


def test_the_file_says_how_its_clock_was_found(tmp_path: Path) -> None:
    """On stdout, and in its metadata; messages are as they were, in order of time."""
    paths = CLOCKS["an hour ahead"].record(tmp_path)
    said = run("team", "merge", tmp_path / "team.mcap", *paths, "--reference", "b")
    assert said.exit_code == 0
    assert said.stdout.startswith("a: clock 3600.0")
    assert "behind that of b" in said.stdout
    assert "error at most" in said.stdout
    clock = read_team_clock(tmp_path / "team.mcap")
    assert clock is not None
    assert (clock.reference, [each.agent for each in clock.members]) == ("b", ["a", "b"])
    assert list_recorded_parts(tmp_path / "team.mcap") == ["a", "b"]
    times, topics = [], dict[str, int]()
    with (tmp_path / "team.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        names = [each.name for each in reader.iter_metadata()]
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            assert getattr(schema, "name", None) == TEAM_MESSAGE
            times.append(message.log_time)
            topics[channel.topic] = topics.get(channel.topic, 0) + 1
    assert names[0] == TEAM_METADATA
    assert times == sorted(times)
    assert topics == {f"/{agent}/{topic}": 200 for agent in "ab" for topic in (SENT, HEARD)}
    assert read_team_clock(paths[0]) is None


def check_refusal(
    kind: type[UnderstudyError], says: str, folder: Path, *paths: Path, out: str = "team.mcap"
) -> None:
    before = sorted(folder.iterdir())
    with pytest.raises(kind, match=says):
        merge_recordings(folder / out, paths)
    assert sorted(folder.iterdir()) == before


def test_what_cannot_be_merged_is_refused(tmp_path: Path) -> None:
    a, b = CLOCKS["equal clocks"].record(tmp_path)
    apart = Clocks({"c": 0.0, "d": 0.0}, links={("c", "d"): 0.1}).record(tmp_path)
    text = tmp_path / "text.mcap"
    text.write_text("no recording")
    empty = tmp_path / "empty.mcap"
    empty.touch()
    alone = write(tmp_path / "alone.mcap", "alone", [(BEGAN_NS, SENT, make_data("alone", 0))], agent=False)
    silent = write(tmp_path / "silent.mcap", "silent", [])
    check_refusal(SettingError, "is a recording of a, as is", tmp_path, a, b, a)
    check_refusal(FileError, "no recording", tmp_path, a, text)
    check_refusal(FileError, "is not a recording of an agent|no recording", tmp_path, a, empty)
    check_refusal(FileError, "is not a recording of an agent", tmp_path, a, alone)
    check_refusal(FileError, "has no message", tmp_path, a, silent)
    check_refusal(FileError, "No such file", tmp_path, a, tmp_path / "none.mcap")
    check_refusal(SettingError, "c exchanged no messages in both directions", tmp_path, a, apart[0])
    check_refusal(SettingError, "d exchanged no messages in both directions", tmp_path, *apart)
    check_refusal(FileError, "is there already", tmp_path, a, b, out="a.mcap")
    check_refusal(FileError, "writing failed", tmp_path, a, b, out="none/team.mcap")
    with pytest.raises(UnknownName, match="no agent 'e'"):
        merge_recordings(tmp_path / "team.mcap", [a, b], reference="e")
    merge_recordings(tmp_path / "team.mcap", [a, b])
    with pytest.raises(FileError, match="is of several agents of a team"):
        read_recording(tmp_path / "team.mcap")
    check_refusal(FileError, "is a merged recording", tmp_path, tmp_path / "team.mcap", b, out="again.mcap")


def test_what_a_killed_agent_recorded_is_merged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that ends in the middle is merged up to there, and the result says so."""
    monkeypatch.setattr(writer, "CHUNK_S", 0.0)  # a chunk for each message
    a, b = CLOCKS["equal clocks"].record(tmp_path)
    content = b.read_bytes()
    b.write_bytes(content[: len(content) // 3])
    found = merge_recordings(tmp_path / "team.mcap", [a, b])
    assert [each.whole for each in found.members] == [True, False]
    with (tmp_path / "team.mcap").open("rb") as file:
        agents = [channel.topic[1] for _, channel, _ in make_reader(file).iter_messages()]
    assert agents.count("a") == 400
    assert 0 < agents.count("b") < 400


KILLED = """
import os, sys
from understudy.records import merge
write = merge._Channels.find
def find(self, agent, number):
    global left
    left -= 1
    if not left:
        os.kill(os.getpid(), 9)
    return write(self, agent, number)
left = 300
merge._Channels.find = find
merge.merge_recordings(sys.argv[1], sys.argv[2:])
"""


def test_a_killed_merge_leaves_no_file(tmp_path: Path) -> None:
    """Neither the new file nor, after the next merge, anything else."""
    paths = CLOCKS["equal clocks"].record(tmp_path)
    ended = subprocess.run([sys.executable, "-c", KILLED, tmp_path / "team.mcap", *paths], check=False)
    assert ended.returncode == -signal.SIGKILL
    assert not (tmp_path / "team.mcap").exists()
    merge_recordings(tmp_path / "team.mcap", paths)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.mcap", "b.mcap", "team.mcap"]


def test_recordings_are_merged_where_the_file_system_has_no_links(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on a memory stick; a file that has come meanwhile stays there, too."""

    def refuse(source: Path, target: Path) -> None:
        if comes:
            out.write_text("another one")
        raise PermissionError(EPERM, "Operation not permitted", str(source))

    monkeypatch.setattr(os, "link", refuse)
    paths, out = CLOCKS["equal clocks"].record(tmp_path), tmp_path / "team.mcap"
    comes = False
    merge_recordings(out, paths)
    assert list_recorded_parts(out) == ["a", "b"]
    out.unlink()
    comes = True
    with pytest.raises(FileError):
        merge_recordings(out, paths)
    assert out.read_text() == "another one"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.mcap", "b.mcap", "team.mcap"]
