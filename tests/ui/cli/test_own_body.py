"""Commands with a body of one's own, by --world MODULE:NAME: it is run, drawn and evaluated, and mistakes are told."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image
from tests.own_worlds import NAME, Slope
from tests.ui.cli.commands import run, said

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
    found = said("run", *SLOPE, "--library", folder, "--seed", 2)
    assert (found["behavior"], found["world"], found["seed"], found["robots"]) == (
        "climb", f"{NAME}:make_slope", 2, 1,
    )  # fmt: skip
    assert found["seconds"] == pytest.approx(7.5)  # the press acts in the tick after
    assert (found["over"], found["path"], found["readings"]) == (False, ["done"], {"x": [9.0]})
    shown = run("run", *SLOPE, "--library", folder, "--seed", 2).output
    assert f"climb in {NAME}:make_slope 2: in done after 7.5 s" in shown


def test_run_ends_with_the_episode_or_the_time() -> None:
    ended = said("run", *SLOPE, "--behavior", "ahead", "--seed", 8, "--library", "none")
    assert (ended["over"], ended["seconds"]) == (True, 2.0)
    assert said("run", *SLOPE, "--behavior", "back", "--library", "none", "--seconds", 5)["seconds"] == 5.0


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
    why = said("why", made, "--time", 7.5)
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
    replayed = said("run", "--replay", made)
    assert replayed["ticks"] == 15


def test_evaluated(folder: Path) -> None:
    found = said("eval", *SLOPE, "--library", folder, "--seeds", "0:4", "--limit", 9, "--metric", "x")
    assert (found["world"], found["success"], found["failed_seeds"]) == (f"{NAME}:make_slope", 0.75, [0])
    assert found["metrics"]["x"]["median"] == 9.0
    two = said("eval", *SLOPE, "--library", folder, "--seeds", "0:4", "--limit", 9, "--jobs", 2)
    assert two["success"] == found["success"]


def test_its_library_is_shown(folder: Path, tmp_path: Path) -> None:
    assert said("show", "climb", "--library", folder, *SLOPE)["features"][0]["unit"] == "m"
    assert [row["name"] for row in said("list", "--library", folder, *SLOPE)["automata"]] == ["climb"]
    out = tmp_path / "climb.svg"
    assert run("draw", "climb", "--library", folder, *SLOPE, "--out", out).exit_code == 0
    assert out.is_file()


def test_its_library_is_tested_checked_and_exported(folder: Path, tmp_path: Path) -> None:
    tested = said("test", folder, *SLOPE)
    assert (tested["world"], tested["works"], tested["automata"][0]["name"]) == (
        f"{NAME}:make_slope",
        True,
        "climb",
    )
    assert [row["name"] for row in said("check", folder, *SLOPE)["checked"]] == ["climb"]
    assert said("validate", "--library", folder, *SLOPE)["valid"]
    assert said("rebuild", "--library", folder, *SLOPE)["world"] == f"{NAME}:make_slope"
    out = tmp_path / "climb"
    assert run("export", "climb", "--library", folder, *SLOPE, "--to", "json", "--out", out).exit_code == 0
    assert any(out.iterdir())


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
    (["prepare", f"{NAME}:make_slope"], "Scenario"),
]


@pytest.mark.parametrize(("words", "sentence"), REFUSED, ids=[" ".join(words) for words, _ in REFUSED])
def test_refused(words: list[str], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(*words)
    assert result.exit_code == 2, result.output
    assert sentence in " ".join(result.stderr.split())
    assert not list(tmp_path.iterdir())
