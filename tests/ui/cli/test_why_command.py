"""`understudy why`: a run made again until a moment, and what every level decided in it."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from tests.sim.patrollers import ROBOTS
from tests.ui.cli.commands import run, run_json

from understudy.model.library import Library, TrainedAutomaton
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.storage.library_folder import open_library, save_automaton
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy_lab.bench.patrol import lead


@pytest.fixture
def approach_library(tmp_path: Path) -> Path:
    """A library whose one automaton was taught by two presses: drive, and stop near the station."""
    lesson = new_lesson(
        Library(FORAGE_KIT),
        "approach",
        states=["forward", "rotate_left"],
        flags=["done"],
        features=["distance_to(station)"],
        live=False,
    )
    session = Session(Forage([9]), Library(FORAGE_KIT), lesson)
    session.direct("forward")
    session.run_for(2.0)
    session.direct("rotate_left")
    session.tick()
    save_automaton(tmp_path / "library", session.make_trained_automaton())
    return tmp_path / "library"


def record(library: Path, *arguments: object, name: str = "run.jsonl") -> Path:
    path = library.parent / name
    assert run("run", "-l", library, "--trace", path, *arguments).exit_code == 0
    return path


def switches(path: Path) -> list[tuple[float, str, str]]:
    """When a run with one robot went from what to what."""
    rows = [json.loads(line) for line in path.read_text().splitlines()[1:]]
    return [
        (after["time_s"], before["doing"], after["doing"])
        for before, after in pairwise(rows)
        if before["doing"] != after["doing"]
    ]


def test_examples_and_when_they_were_shown(approach_library: Path) -> None:
    path = record(approach_library, "--behavior", "approach", "--seed", "9", "--seconds", "6")
    ((when, _, after),) = switches(path)
    assert after == "rotate_left"
    told = run_json("why", path, "--time", when)
    ((level,),) = (agent["levels"] for agent in told["agents"])
    decision = level["decision"]
    assert (decision["before"], decision["after"], told["switched"]) == ("forward", "rotate_left", True)
    (condition,) = decision["conditions"]
    assert condition.startswith("distance_to(station) is ")
    assert [(row["number"], row["kind"], row["shown_s"]) for row in decision["examples"]] == [
        (3, "directive", 2.0)
    ]
    told = run_json("why", path, "--time", when - 0.5)
    assert not told["switched"]
    assert [row["kind"] for row in told["agents"][0]["levels"][0]["decision"]["examples"]] == ["default"]
    assert (told["last_switch"]["before"], told["last_switch"]["time_s"]) == ("start", 0.0)
    text = " ".join(run("why", path, "--time", when).stdout.split())
    assert "goes from forward to rotate_left because distance_to(station) is" in text
    assert "shown by 3 (directive at 2.0 s)" in text
    text = run("why", path, "--time", when + 1.0).stdout
    assert f"The last switch, at {when - 0.1:g} s, of approach" in text


def test_every_level_of_a_hierarchy_answers(library: Path) -> None:
    """At each switch of a run, and a tick later, the levels are in the states that the trace tells."""
    path = record(library, "--seed", "1", "--seconds", "40")
    found = switches(path)
    assert len(found) > 5
    for when, _, after in found[:4]:
        told = run_json("why", path, "--time", when)
        levels = told["agents"][0]["levels"]
        assert " > ".join(level["state"] for level in levels) == after
        switched = [
            level for level in levels if level["decision"] and level["decision"]["before"] != level["state"]
        ]
        assert switched
        assert all(level["decision"]["by_hand"] for level in levels if level["decision"])
        told = run_json("why", path, "--time", when + 0.1)
        assert told["last_switch"]["time_s"] == pytest.approx(when - 0.1)
    assert "written by hand: no example is behind it" in run("why", path, "--time", "3").stdout


def test_a_recording_answers_as_a_trace(library: Path) -> None:
    """Without making the run again, so that a real robot can be asked, too; its times are those of decisions."""
    pytest.importorskip("rosbags", reason="needs the extra ros2")
    pytest.importorskip("mcap", reason="needs the extra ros2")
    recording = library.parent / "run.mcap"
    path = record(library, "--seed", "1", "--seconds", "20", "--record", recording)
    for when in (0.1, 3.0, 7.4, 20.0, *(when for when, _, _ in switches(path)[:4])):
        of_trace = run_json("why", path, "--time", when)
        told = run_json("why", recording, "--time", when - 0.1)
        assert told.pop("time_s") == pytest.approx(of_trace.pop("time_s") - 0.1)
        assert told == of_trace
    for option, value, problem in (
        ("--time", 21, "after the run had ended"),
        ("--agent", 1, "is 1; count from 0 to 0"),
    ):
        refused = run("why", recording, "--time", 1, option, value)
        assert refused.exit_code == 2
        assert problem in refused.stderr


def test_a_recording_of_another_library_gives_no_reasons(library: Path) -> None:
    pytest.importorskip("mcap", reason="needs the extra ros2")
    recording = library.parent / "run.mcap"
    record(library, "--seconds", "5", "--record", recording)
    (library / "goto.json").write_text(
        (library / "goto.json").read_text().replace('"cut": 0.3,', '"cut": 0.4,')
    )
    refused = run("why", recording, "--time", 1)
    assert refused.exit_code == 1
    assert "goto in" in refused.stderr


def test_a_robot_in_a_team_is_asked_from_its_coordinator_down(tmp_path: Path) -> None:
    folder = tmp_path / "library"
    for automaton in (ROBOTS.automaton(name) for name in ROBOTS.taught):
        save_automaton(folder, TrainedAutomaton(automaton))
    save_automaton(folder / "patrol", TrainedAutomaton(lead()))
    path = tmp_path / "run.jsonl"
    arguments = ("-l", folder, "--behavior", "lead", "--seconds", "22", "--trace", path)
    assert run("run", "patrol", *arguments).exit_code == 0
    told = run_json("why", path, "--time", "15", "--agent", "2")
    assert [(each["sort"], each["ordered"]) for each in told["agents"]] == [
        ("patrol", None),
        ("pioneer", "wander"),
    ]
    coordinator, robot = (each["levels"] for each in told["agents"])
    assert [level["automaton"] for level in coordinator + robot] == ["lead", "wander"]
    assert told["doing"] == f"wander > {robot[0]['state']}"
    assert coordinator[0]["decision"]["conditions"] == ["someone_sees(intruder) is no"]
    rows = [json.loads(line) for line in path.read_text().splitlines()[1:]]
    changed = next(row for row in rows if row["robot"] == 2 and row["doing"].startswith("servo"))
    told = run_json("why", path, "--time", changed["time_s"] + 0.1, "--agent", "2")
    assert told["agents"][1]["ordered"] == "servo(intruder)"
    assert [level["automaton"] for level in told["agents"][1]["levels"]] == ["servo(intruder)"]
    assert told["agents"][1]["levels"][0]["decision"]
    last = told["last_switch"]
    assert (last["automaton"], last["after"]) == ("lead", "attack"), "and not what followed from it"
    assert "pioneer 2, ordered to wander" in run("why", path, "--time", "15", "--agent", "2").stdout


def test_a_library_that_changed_is_never_lied_about(library: Path, tmp_path: Path) -> None:
    path = record(library, "--seed", "1", "--seconds", "5")
    before = run_json("why", path, "--time", "3")
    opened = open_library(library, FORAGE_KIT).library
    goto = opened.automaton("goto")
    other = replace(goto, transitions={**goto.transitions, "start": goto.transitions["left"]})
    other = replace(
        other, transitions={name: it for name, it in other.transitions.items() if name != "right"}
    )
    save_automaton(library, TrainedAutomaton(other))
    save_automaton(
        library, TrainedAutomaton(replace(other, transitions={"start": other.transitions["start"]}))
    )
    told = run_json("why", path, "--time", "3")
    assert told["former"] == {"goto": 1}
    assert {**told, "former": {}} == before
    assert "goto is another by now: this is its version 1" in run("why", path, "--time", "3").stdout
    assert len(list((library / "versions" / "goto").iterdir())) == 2
    for version in (library / "versions" / "goto").iterdir():
        version.unlink()
    refused = run("why", path, "--time", "3")
    assert refused.exit_code == 1
    assert "goto in" in refused.output
    assert "no former version is what was run" in " ".join(refused.output.split())


def test_a_library_that_is_elsewhere_by_now(library: Path, tmp_path: Path) -> None:
    path = record(library, "--seconds", "3")
    before = run_json("why", path, "--time", "2")
    elsewhere = library.rename(tmp_path / "elsewhere")
    refused = run("why", path, "--time", "2")
    assert refused.exit_code == 2
    assert "there is no folder" in " ".join(refused.output.split())
    assert run_json("why", path, "--time", "2", "-l", elsewhere) == before


def test_a_scenario_that_changed_is_never_lied_about(library: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(run("worlds", "forage").stdout)
    path = record(library, mine, "--seconds", "3")
    assert run_json("why", path, "--time", "2")["doing"]
    mine.write_text(run("worlds", "forage").stdout.replace("limit_s = 1800", "limit_s = 60"))
    refused = run("why", path, "--time", "2")
    assert refused.exit_code == 1
    assert "the scenario forage is another by now" in " ".join(refused.output.split())


def test_a_run_that_comes_out_otherwise_is_never_lied_about(library: Path) -> None:
    path = record(library, "--seconds", "3")
    path.write_text(path.read_text().replace('"x":', '"x":1'))
    refused = run("why", path, "--time", "2")
    assert refused.exit_code == 1
    assert "the run cannot be repeated" in " ".join(refused.output.split())


MISTAKES = [  # what is given, what is said
    (("--time", "99"), "--time is 99, after the run had ended; give at most 3"),
    (("--time", "1", "--agent", "1"), "--agent is 1; count from 0 to 0"),
]


@pytest.mark.parametrize(("given", "told"), MISTAKES)
def test_what_the_trace_does_not_tell(given: tuple[str, ...], told: str, library: Path) -> None:
    refused = run("why", record(library, "--seconds", "3"), *given)
    assert refused.exit_code == 2
    assert told in " ".join(refused.output.split())


def test_other_files(library: Path, tmp_path: Path) -> None:
    path = record(library, "--seconds", "1")
    header = json.loads(path.read_text().splitlines()[0])
    del header["run"]
    path.write_text(json.dumps(header) + "\n")
    for what, told in (
        (path, "does not say how the run was produced"),
        (library / "goto.json", "not a trace of a run"),
        (tmp_path / "nothing.jsonl", "reading the trace"),
    ):
        refused = run("why", what, "--time", "1")
        assert refused.exit_code == 2
        assert told in " ".join(refused.output.split())


@pytest.mark.parametrize(
    ("line", "content"),
    [
        (0, b'{"format": "understudy trace \xff"}\n'),
        (0, b'{"format":' + b"[" * 3000 + b"]" * 3000 + b"}\n"),
        (1, b'{"time_s": 0.1, "doing": "\xff"}\n'),
        (1, b'{"more":' + b"[" * 3000 + b"]" * 3000 + b"}\n"),
    ],
)
def test_a_damaged_trace_is_refused(line: int, content: bytes, library: Path) -> None:
    """Bytes that are no UTF-8, and nesting deeper than any program can follow."""
    path = record(library, "--seconds", "1")
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([*lines[:line], content, *lines[line + 1 :]]))
    refused = run("why", path, "--time", "1")
    assert refused.exit_code == 2
    assert ("it is not a trace of a run", "a line of it cannot be read")[line] in " ".join(
        refused.output.split()
    )


def test_a_run_that_was_killed(library: Path) -> None:
    """Its trace ends within a line: what is before that can be asked all the same."""
    path = record(library, "--seconds", "3")
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:21]) + lines[21][:30])
    assert run_json("why", path, "--time", "2")["time_s"] == 2.0
    assert run("why", path, "--time", "2.1").exit_code == 2
    path.write_bytes(lines[0] + lines[1][:30])
    refused = run("why", path, "--time", "0")
    assert refused.exit_code == 2
    assert "has no data of robot 0" in " ".join(refused.output.split())


def test_parquet(library: Path) -> None:
    pytest.importorskip("duckdb")
    lines = record(library, "--seconds", "3")
    table = record(library, "--seconds", "3", name="run.parquet")
    assert run_json("why", table, "--time", "2") == run_json("why", lines, "--time", "2")


def test_a_basic_behavior_decides_nothing(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    arguments = ("-l", tmp_path / "none", "--behavior", "forwards", "--seconds", "1", "--trace", path)
    assert run("run", "patrol", *arguments).exit_code == 0
    assert "runs no automaton: nothing is decided" in run("why", path, "--time", "1").stdout
