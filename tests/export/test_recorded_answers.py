"""Recorded answers stand for peers only where these are given the same, and the peers that are here answer so."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from tests.export import recorded_answers
from tests.export.peers import MICROPYTHON, list_peers
from tests.export.record_conformance import HEADING
from tests.export.recorded_answers import (
    RECORD,
    Answer,
    Answers,
    Ask,
    UnrecordedAnswer,
    hash_question,
    read_record,
    write_record,
)
from tests.export.ros2.packages import STRICT, write_stand_ins
from tests.export.test_odd_names import export
from tests.export.test_ros2 import FORAGER, run_node
from tests.export.test_ros2 import export as export_for_ros2
from tests.export.test_targets import IN_MICROPYTHON

LARGEST_RECORD = 200_000
"""In bytes."""
TARGETS = {
    "gcc": "c99", "clang": "c99", "sanitizers": "c99", "cortex-m3": "c99", "node": "json", "micropython": "python",
    "scion": "scxml", "xstate": "xstate", "qt": "scxml", "behaviortreepy": "btcpp", "behaviortree-cpp": "btcpp",
}  # fmt: skip
"""What peers run of the small export that every peer is tried with."""


def ask_small(ask: Ask, peer: str, folder: Path) -> Answer:
    """Ask a peer about a small export."""
    if peer == "ros2-node":
        export_for_ros2(folder, FORAGER, "goto", A="nearest_food")
        write_stand_ins(folder / "out", folder)
        return run_node(ask, folder, (), "limits.speed_m_s:=nan", flags=STRICT)
    if peer == "avr":
        return ask(peer, export(folder, "c99", single=True))
    if peer == "sizes":
        return ask(peer, export(folder, "c99", single=True), finds=r"a-\w+\.o")
    if peer == "g++":
        command = (
            "g++",
            "-std=c++17",
            "-Werror",
            "-fsyntax-only",
            "-include",
            "a.h",
            "-x",
            "c++",
            "/dev/null",
        )
        return ask(peer, export(folder, "c99"), command=command, finds="")
    if peer == "micropython":
        export(folder, "python")
        (folder / "run.mjs").write_text(IN_MICROPYTHON.replace("forage.py", "a.py") % MICROPYTHON)
        return ask(peer, folder, command=("node", "run.mjs"))
    return ask(peer, export(folder, TARGETS[peer]))


@pytest.mark.parametrize("peer", list_peers())
def test_a_small_export_runs(peer: str, ask: Ask, tmp_path: Path) -> None:
    """So that each peer has an answer that is quickly asked for; the node of ROS 2 refuses its limit."""
    answer = ask_small(ask, peer, tmp_path)
    assert answer.succeeded == (peer != "ros2-node")
    assert "mismatches" not in answer.said or answer.counts[1] == 0


SLOW = ("behaviortree-cpp", "qt", "ros2-node")
"""Peers that take seconds to compile what they are given."""


@pytest.mark.parametrize(
    "peer", [pytest.param(peer, marks=[pytest.mark.long] if peer in SLOW else []) for peer in list_peers()]
)
def test_a_peer_that_is_here_answers_as_recorded(peer: str, answers: Answers, tmp_path: Path) -> None:
    """It is always asked, about a small export; the record has all else."""
    if missing := list_peers()[peer].find_missing():
        pytest.skip(missing)
    asking = Ask(replace(answers, asked={}, asks_all=True), "a small export")
    assert ask_small(asking, peer, tmp_path) == next(answer for *_, answer in asking.answers.asked.values())


def test_the_record_is_small_sorted_and_complete() -> None:
    text = RECORD.read_text(encoding="utf-8")
    heading, *lines = text.splitlines()
    assert heading == HEADING
    assert lines == sorted(lines)
    assert len(text.encode()) < LARGEST_RECORD
    assert len(read_record(text)) == len(lines)
    assert {line.split("\t")[1] for line in lines} == set(list_peers())


def test_a_record_is_read_as_it_is_written() -> None:
    answers = {"k1": Answer(True, "7 ticks, 0 mismatches"), "k2": Answer(False, 'line\nwith\ttab "ä"')}
    written = write_record({key: ("gcc", "test", each) for key, each in answers.items()}, HEADING)
    assert read_record(written) == answers
    assert len(written.splitlines()) == 3


def test_any_change_is_another_question(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = export(tmp_path, "c99")

    def key(peer: str = "gcc", *words: str) -> str:
        return hash_question(peer, folder, *(words or ("make", "test")))

    keys = [key(), key("clang"), key("gcc", "make", "sanitize"), key("xstate")]
    for name in ("a.c", "a.h", "conformance.c", "conformance.csv", "Makefile"):
        before = (folder / name).read_bytes()
        (folder / name).write_bytes(before.replace(b"0", b"1", 1) + b"\n")
        keys.append(key())
        (folder / name).write_bytes(before)
    (folder / "a.c").rename(folder / "b.c")
    keys.append(key())
    (folder / "b.c").rename(folder / "a.c")
    newer = {**list_peers(), "xstate": replace(list_peers()["xstate"], version="99.0.0")}
    with monkeypatch.context() as patched:
        patched.setattr(recorded_answers, "list_peers", lambda: newer)
        keys.append(key("xstate"))
    assert len(set(keys)) == len(keys)
    (folder / "manifest.json").write_text("{}")  # which no peer reads
    assert key() == keys[0]


def say_of_peers(problem: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let peers have this problem instead of what is missing here."""
    peers = {name: replace(peer, find_missing=lambda: problem) for name, peer in list_peers().items()}
    monkeypatch.setattr(recorded_answers, "list_peers", lambda: peers)


KNOWN = Answer(True, "7 ticks, 0 mismatches")


def test_an_unknown_answer_fails_where_integration_lacks_the_peer(monkeypatch: pytest.MonkeyPatch) -> None:
    say_of_peers("needs gcc", monkeypatch)
    sentence = r"needs gcc \(the export to gcc or its rows changed; .* -m tests\.export\.record_conformance\)"
    monkeypatch.setenv("CI", "true")
    with pytest.raises(pytest.fail.Exception, match=sentence):
        Answers({}).find("key", "gcc", "test", lambda: KNOWN)
    monkeypatch.delenv("CI")
    with pytest.raises(pytest.skip.Exception, match=sentence):
        Answers({}).find("key", "gcc", "test", lambda: KNOWN)


def test_a_known_answer_needs_no_peer(monkeypatch: pytest.MonkeyPatch) -> None:
    say_of_peers("needs gcc", monkeypatch)
    monkeypatch.setenv("CI", "true")
    assert Answers({"key": KNOWN}).find("key", "gcc", "test", lambda: Answer(False, "")) == KNOWN
    with pytest.raises(pytest.fail.Exception, match="needs gcc"):
        Answers({"key": KNOWN}, asks_all=True).find("key", "gcc", "test", lambda: KNOWN)


def test_a_peer_that_answers_otherwise_than_recorded_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    say_of_peers("", monkeypatch)
    asked = Answers({"key": KNOWN}, asks_all=True)
    assert asked.find("key", "gcc", "test", lambda: KNOWN) == KNOWN
    with pytest.raises(
        pytest.fail.Exception, match=r"gcc answers .*6 mismatches.* recorded is .*0 mismatches"
    ):
        asked.find("key", "gcc", "test", lambda: Answer(False, "7 ticks, 6 mismatches"))


def test_a_peer_that_was_asked_says_how_to_record(monkeypatch: pytest.MonkeyPatch) -> None:
    say_of_peers("", monkeypatch)
    asked = Answers({})
    with pytest.warns(UnrecordedAnswer, match=re.escape("python -m tests.export.record_conformance")):
        assert asked.find("key", "gcc", "test", lambda: KNOWN) == KNOWN
    assert asked.asked == {"key": ("gcc", "test", KNOWN)}


def test_nothing_is_asked_where_what_is_missing_is_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    say_of_peers("", monkeypatch)
    listed = Answers({"key": KNOWN}, is_listing=True)
    assert listed.find("key", "gcc", "test", lambda: Answer(False, "")) == KNOWN
    with pytest.raises(pytest.skip.Exception, match="clang has to be asked"):
        listed.find("other", "clang", "test", lambda: KNOWN)
    assert listed.asked == {"key": ("gcc", "test", KNOWN), "other": ("clang", "test", None)}
