"""`understudy learn --recording` with drives: proposals that are accepted, splits, latency, and our own recordings."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from tests.segmentation.drives import follow
from tests.ui.cli.commands import run, run_json

MOVES = {"forward": (0.8, 0.0), "arc": (0.3, 0.6), "back": (-0.5, 0.0)}
KNOWN = ("--define", "forward: drive 0.8", "--define", "back: drive -0.5")
ARC = ("--define", "arc: drive 0.3, turn 0.6")


@pytest.fixture
def drive(tmp_path: Path) -> Path:
    """Four rounds of 4 s forward, 3 s on an arc and 4 s back, with a place that follows two ticks later."""
    spans = list(zip(MOVES.values(), (40, 30, 40), strict=True)) * 4
    aims = [aim for aim, ticks in spans for _ in range(ticks)]
    commands = follow(aims)
    x = np.cumsum(0.1 * np.concatenate([np.zeros(3), commands[:-3, 0]]))
    rows = [f"{tick / 10:.1f},{x[tick]:.4f},{one:.4f},{two:.4f}" for tick, (one, two) in enumerate(commands)]
    path = tmp_path / "drive.csv"
    path.write_text("\n".join(["time_s,x,command.drive,command.turn", *rows]) + "\n")
    return path


def test_what_nothing_explains_is_proposed_and_accepted(drive: Path) -> None:
    (proposal,) = run_json("learn", "--recording", drive, *KNOWN)["drive"]["findings"]["behaviors"]
    assert proposal["command"] == pytest.approx({"drive": 0.3, "turn": 0.6}, abs=0.02)
    assert proposal["spans"] == 4
    assert proposal["longest"]["file"] == "drive.csv"
    shown = run("learn", "--recording", drive, *KNOWN).stdout
    assert f"--define 'NAME: {', '.join(f'{k} {v:g}' for k, v in proposal['command'].items())}'" in shown
    found = run_json("learn", "--recording", drive, *KNOWN, *ARC)
    assert {each["label"] for each in found["drive"]["labels"]} == set(MOVES)
    assert found["drive"]["findings"]["behaviors"] == []
    assert set(found["states"]) == {"start", *MOVES}


def test_motion_follows_commands_two_ticks_later(drive: Path) -> None:
    (latency,) = run_json("learn", "--recording", drive, *KNOWN, *ARC)["drive"]["findings"]["latencies"]
    assert (latency["channel"], latency["reading"]) == ("drive", "x")
    assert latency["seconds"] == pytest.approx(0.2, abs=0.02)
    assert "Motion follows drive after 0.20 s" in run("learn", "--recording", drive, *KNOWN, *ARC).stdout


def test_a_state_is_split(drive: Path) -> None:
    found = run_json("learn", "--recording", drive, *KNOWN, *ARC, "--split", "forward after start")
    assert set(found["states"]) == {"start", "forward", "back", "arc", "forward_2"}
    spans = [each["label"] for each in found["drive"]["spans"]]
    assert spans[0] == "forward_2"
    assert "forward_2" not in spans[1:]


def test_behaviors_that_nobody_named_are_listed(drive: Path) -> None:
    result = run("learn", "--recording", drive)
    assert result.exit_code == 2
    for command in ("drive -0.5", "drive 0.8", "drive 0.3, turn 0.6"):
        assert f"--define 'NAME: {command}'" in " ".join(result.stderr.split()), result.stderr


MISTAKES = [  # options, what is said
    (("--define", "arc drive 0.3"), "--define 'arc drive 0.3' is no behavior; write its name"),
    (("--define", "arc: drive fast"), "--define 'arc: drive fast' is no behavior"),
    (("--define", "arc: lift 1"), "the recording has no command channel 'lift'; it has drive and turn"),
    (("--define", "unexplained: drive 1"), "behavior 'unexplained': it cannot be called so"),
    ((*ARC, *ARC), "there is a behavior of that name already"),
    ((*ARC, "--split", "arc"), "--split 'arc' names no state and the states before"),
    ((*ARC, "--split", "back after arc"), "the recording has no state 'back'"),
    ((*ARC, "--split", "arc after arc"), "it was never entered from arc"),
    ((*KNOWN, *ARC, "--split", "arc after forward"), "it was always entered from forward"),
]


@pytest.mark.parametrize(("options", "problem"), MISTAKES)
def test_mistakes(drive: Path, options: tuple[str, ...], problem: str) -> None:
    result = run("learn", "--recording", drive, *options)
    assert result.exit_code == 2
    assert problem in " ".join(result.stderr.split())


def test_a_recording_of_ours_needs_no_mapping(library: Path, tmp_path: Path) -> None:
    """The same run as a trace and as a recording gives the same spans; presses are not needed."""
    trace, recording = tmp_path / "run.jsonl", tmp_path / "run.mcap"
    for option, path in (("--trace", trace), ("--record", recording)):
        run_json("run", "--library", library, "--seed", 7, "--seconds", 150, option, path)
    given = ("--library", library, "--behaviors", "harvest,deposit")
    of_trace = run_json("learn", "--recording", trace, *given, "--name", "one")["drive"]["spans"]
    found = run_json("learn", "--recording", recording, *given, "--name", "two")["drive"]["spans"]
    late_s = of_trace[0]["from_s"]  # a trace has the time after each tick, a recording that before it
    assert len(found) == len(of_trace) > 3
    for one, two in zip(of_trace, found, strict=True):
        assert (one["label"], one["from_s"] - late_s) == (two["label"], pytest.approx(two["from_s"]))
    refused = run("learn", "--recording", recording)
    assert "holds no presses" in refused.stderr
    assert "--behaviors A,B" in " ".join(refused.stderr.split())


def test_recordings_without_commands_are_refused(tmp_path: Path) -> None:
    former = Path(__file__).parents[2] / "fixtures" / "v0_1_0" / "runs" / "forage.mcap"
    result = run("learn", "--recording", former, "--behaviors", "forward")
    assert result.exit_code == 2
    assert "it has no commands by tick; record it again" in " ".join(result.stderr.split())


def test_messages_of_others_need_a_mapping(tmp_path: Path) -> None:
    writer = pytest.importorskip("mcap.writer")
    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        out = writer.Writer(file)
        out.start()
        schema = out.register_schema("twist", "jsonschema", b"{}")
        channel = out.register_channel("/cmd", "json", schema)
        for number in range(20):
            out.add_message(channel, number * 10**8, json.dumps({"v": number % 3}).encode(), number * 10**8)
        out.finish()
    for options in ((), ("--behaviors", "forward")):
        result = run("learn", "--recording", path, *options)
        assert result.exit_code == 2
        assert "give --map MAP.toml" in " ".join(result.stderr.split())
