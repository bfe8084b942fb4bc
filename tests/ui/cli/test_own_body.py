"""Commands with a body of one's own, by --world MODULE:NAME: it is run, drawn and evaluated, and mistakes are told."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from PIL import Image
from tests.own_worlds import NAME, Slope
from tests.ui.cli.commands import run, run_json

from understudy import Library, Session, new_lesson
from understudy.storage.library_folder import save_automaton

SLOPE = ("--world", f"{NAME}:make_slope")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A library with an automaton that drives ahead until 9 m."""
    body = Slope(0.0)
    library = Library(body.kit)
    lesson = new_lesson(library, "climb", states=["ahead"], flags=["done"], features=["x"], live=False)
    session = Session(body, library, lesson)
    session.direct("ahead")
    session.run_for(9.0)
    session.direct("done")
    session.tick()
    save_automaton(tmp_path / "library", session.make_trained_automaton())
    return tmp_path / "library"


def test_run(folder: Path) -> None:
    """From 2 m to 9 m at 1 m/s."""
    found = run_json("run", *SLOPE, "--library", folder, "--seed", 2)
    assert (found["behavior"], found["world"], found["seed"], found["robots"]) == (
        "climb", f"{NAME}:make_slope", 2, 1,
    )  # fmt: skip
    assert found["seconds"] == pytest.approx(7.5)  # the press acts in the tick after
    assert (found["over"], found["path"], found["readings"]) == (False, ["done"], {"x": [9.0]})
    shown = run("run", *SLOPE, "--library", folder, "--seed", 2).output
    assert f"climb in {NAME}:make_slope 2: in done after 7.5 s" in shown


def test_run_ends_with_the_episode_or_the_time() -> None:
    ended = run_json("run", *SLOPE, "--behavior", "ahead", "--seed", 8, "--library", "none")
    assert (ended["over"], ended["seconds"]) == (True, 2.0)
    assert (
        run_json("run", *SLOPE, "--behavior", "back", "--library", "none", "--seconds", 5)["seconds"] == 5.0
    )


def test_run_is_drawn(folder: Path, tmp_path: Path) -> None:
    options = ("--library", folder, "--seed", 2, "--speed", 8)
    run("run", *SLOPE, *options, "--record", tmp_path / "climb.gif")
    run("run", *SLOPE, *options, "--record", tmp_path / "climb.png")
    with Image.open(tmp_path / "climb.gif") as film, Image.open(tmp_path / "climb.png") as last:
        assert film.n_frames == 8  # type: ignore[attr-defined]  # equal ones are one: columns 2 to 9
        assert film.convert("L").getpixel((2, 0)) == 255
        assert last.convert("L").getpixel((9, 0)) == 255


def test_run_is_recorded_and_explained(folder: Path, tmp_path: Path) -> None:
    """At 7.5 s the cart has passed 9 m and is done, since the press came there."""
    made = tmp_path / "climb.mcap"
    shown = run("run", *SLOPE, "--library", folder, "--seed", 2, "--record", made).output
    assert f"Recorded in {made}" in shown.replace("\n", "")
    why = run_json("why", made, "--time", 7.5)
    assert (why["scenario"], why["seed"], why["doing"], why["switched"]) == (
        f"{NAME}:make_slope",
        2,
        "done",
        True,
    )
    (level,) = why["agents"][0]["levels"]
    assert (level["automaton"], level["decision"]["before"], level["decision"]["values"]) == (
        "climb", "ahead", {"x": 9.0},
    )  # fmt: skip
    assert f"robot 0 of {NAME}:make_slope 2 at 7 s: done" in run("why", made, "--time", 7.5).output
    replayed = run_json("run", "--replay", made)
    assert replayed["ticks"] == 15


@pytest.mark.long
def test_evaluated(folder: Path) -> None:
    found = run_json("eval", *SLOPE, "--library", folder, "--seeds", "0:4", "--limit", 9, "--metric", "x")
    assert (found["world"], found["success"], found["failed_seeds"]) == (f"{NAME}:make_slope", 0.75, [0])
    assert found["metrics"]["x"]["median"] == 9.0
    two = run_json("eval", *SLOPE, "--library", folder, "--seeds", "0:4", "--limit", 9, "--jobs", 2)
    assert two["success"] == found["success"]


def test_its_library_is_shown(folder: Path, tmp_path: Path) -> None:
    assert run_json("show", "climb", "--library", folder, *SLOPE)["features"][0]["unit"] == "m"
    assert [row["name"] for row in run_json("list", "--library", folder, *SLOPE)["automata"]] == ["climb"]
    out = tmp_path / "climb.svg"
    assert run("draw", "climb", "--library", folder, *SLOPE, "--out", out).exit_code == 0
    assert out.is_file()


def test_its_library_is_tested_checked_and_exported(folder: Path, tmp_path: Path) -> None:
    tested = run_json("test", folder, *SLOPE)
    assert (tested["world"], tested["works"], tested["automata"][0]["name"]) == (
        f"{NAME}:make_slope",
        True,
        "climb",
    )
    assert [row["name"] for row in run_json("check", folder, *SLOPE)["checked"]] == ["climb"]
    assert run_json("validate", "--library", folder, *SLOPE)["valid"]
    assert run_json("rebuild", "--library", folder, *SLOPE)["world"] == f"{NAME}:make_slope"
    out = tmp_path / "climb"
    assert run("export", "climb", "--library", folder, *SLOPE, "--to", "json", "--out", out).exit_code == 0
    assert any(out.iterdir())


SLIPPERY = ("--world", f"{NAME}:make_slippery")


@pytest.mark.long
def test_falsified(folder: Path, tmp_path: Path) -> None:
    """From 2 m to 9 m in 7.5 s; with each fourth seed it stands still. Seeds begin at 1 000 000 000."""
    out = tmp_path / "failures"
    result = run(
        "falsify", folder, "climb", *SLIPPERY, "--limit", 8, "--worlds", 9, "--jobs", 2, "-o", out, "--json"
    )
    assert result.exit_code == 1, result.output
    found = json.loads(result.stdout)
    seeds = [1_000_000_000, 1_000_000_004, 1_000_000_008]
    assert (found["random"]["runs"], found["random"]["failed"], found["random"]["seeds"]) == (9, 3, seeds)
    failure = found["failure"]
    assert (failure["folder"], failure["seed"], failure["robustness"], failure["scenario"]) == (
        str(out / "climb-1"), 1_000_000_000, -1.0, None,
    )  # fmt: skip
    assert failure["why"] == [
        "The goal was not reached within 8.0 s.",
        "At 0.0 s climb went from start to ahead, always.",
        "It read x = 2.00 m.",
        "The decision was shown by 1 (directive at 0.0 s).",
    ]
    assert run_json(*failure["command"].split()[1:])["path"] == ["ahead"]
    assert run_json("why", failure["recording"], "--time", 5)["doing"] == "ahead"
    kept = (out / "climb-1" / "why.txt").read_text()
    assert "understudy teach climb --world" in kept
    assert run_json("test", folder, *SLIPPERY, "--failures", out)["works"], (
        "these folders are no scenarios to test"
    )


def test_falsified_in_time_and_by_a_reading(folder: Path, tmp_path: Path) -> None:
    options = ("falsify", folder, "climb", *SLIPPERY, "-o", tmp_path / "failures", "--worlds", 3)
    found = run(*options, "--seed", 1, "--limit", 7)  # without its last half second
    assert found.exit_code == 1
    assert "At random: 3 of 3 worlds failed" in found.stdout
    assert f"climb fails in {NAME}:make_slippery 2000000000" in found.stdout
    none = run("falsify", folder, "climb", *SLOPE, "--limit", 3, "--worlds", 2, "-o", tmp_path / "failures")
    assert none.exit_code == 0, none.output
    assert "No failing world was found" in none.stdout


def test_a_body_that_breaks_in_a_search(folder: Path, tmp_path: Path) -> None:
    options = ("--limit", 8, "--worlds", 5, "-o", tmp_path / "failures")
    result = run("falsify", folder, "climb", "--world", f"{NAME}:make_breaking", *options)
    assert result.exit_code == 2
    assert "1000000000" in result.stderr
    assert "a wheel is off" in result.stderr
    assert not (tmp_path / "failures").exists()


def test_described() -> None:
    found = run_json("worlds", f"{NAME}:make_slope")
    assert (found["robots"], found["tick_s"], found["behaviors"]) == (1, 0.5, ["ahead", "back"])
    assert [each["name"] for each in found["readings"] + found["channels"]] == ["x", "drive"]
    shown = run("worlds", f"{NAME}:make_bare").output
    assert "give one with --kit" in shown


def test_nothing_to_prepare() -> None:
    assert run_json("prepare", f"{NAME}:make_slope")["worlds"] == []


REFUSED = [  # words of the command, what is said
    (["eval", *SLOPE, "--behavior", "ahead"], "--limit is missing"),
    (["eval", *SLOPE, "--behavior", "ahead", "--limit", "3"], "goal is missing"),
    (["eval", "--world", f"{NAME}:make_bare", "--limit", "3"], "without a kit; give the kit: --kit"),
    (["run", *SLOPE, "--trace", "a.jsonl"], "--trace is not written of a body of your own"),
    (
        ["run", *SLOPE, "--record", "a.svg"],
        "neither a picture nor a recording; name a file that ends in .gif",
    ),
    (
        [
            "run",
            "--world",
            f"{NAME}:make_plain",
            "--behavior",
            "ahead",
            "--record",
            "a.gif",
            "--library",
            "x",
        ],
        "needs pictures",
    ),
    (["run", "--world", f"{NAME}:make_text"], "is a Text, which is no list of numbers"),
    (["run", "--world", f"{NAME}:make_number"], "returned a int; name a function"),
    (["studio", "--world", f"{NAME}:make_number"], "returned a int; name a function"),
    (["studio", "--world", f"{NAME}:make_broken", "--no-browser"], "returned an array of float64"),
    (["teach", "climb", "--world", "nowhere:make"], "No module named 'nowhere'"),
    (["teach", "climb", *SLOPE], "is not a terminal"),
    (["falsify", "x", "ahead", *SLOPE], "--limit is missing"),
    (["falsify", "x", "ahead", *SLOPE, "--limit", "nan"], "--limit is nan; give a time in s"),
    (["falsify", "x", "ahead", *SLOPE, "--limit", "3"], "goal is missing"),
    (["falsify", "x", "ahead", *SLOPE, "--limit", "3", "--vary", "sizes"], "known by their seeds only"),
    (["falsify", "x", "forward", "--goal", "done"], "a scenario has a goal of its own"),
]


@pytest.mark.parametrize(("words", "sentence"), REFUSED, ids=[" ".join(words) for words, _ in REFUSED])
def test_refused(words: list[str], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(*words)
    assert result.exit_code == 2, result.output
    assert sentence in " ".join(result.stderr.split())
    assert not list(tmp_path.iterdir())
