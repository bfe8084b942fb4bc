"""The commands that run robots in worlds: worlds, run, eval."""

from __future__ import annotations

import json
import os
import pty
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from tests.sim.patrollers import ROBOTS
from tests.ui.cli.commands import ROOT, run, run_json

from understudy.errors import SettingError
from understudy.model.automaton import START, Automaton, State
from understudy.model.library import TrainedAutomaton
from understudy.model.tree import Tree, make_leaf
from understudy.storage.library_folder import save_automaton
from understudy.ui.cli.named_inputs import choose_behavior, find_kit, open_behavior_library
from understudy_lab.bench.patrol import lead


def test_worlds(tmp_path: Path) -> None:
    told = run_json("worlds")["worlds"]
    assert [(row["name"], row["robots"]) for row in told] == [
        ("arena", 1), ("boxes", 20), ("forage", 1), ("forage-team", 4), ("patrol", 4), ("regions", 16), ("rooms", 1),
        ("salvage", 12), ("soccer", 1), ("swarm", 200),
    ]  # fmt: skip
    text = run("worlds").stdout
    assert max(map(len, text.splitlines())) <= 80
    assert "Bring food from sources" in text
    printed = run("worlds", "patrol").stdout
    assert printed == (ROOT / "src/understudy/sim/scenarios/patrol.toml").read_text(encoding="utf-8")
    mine = tmp_path / "mine.toml"
    mine.write_text(printed)
    assert run("worlds", mine).stdout == printed
    assert run_json("worlds", mine)["name"] == "patrol"


def test_eval(library: Path) -> None:
    told = run_json(
        "eval", "--library", library, "--behavior", "forage", "--world", "forage", "--seeds", "0:4"
    )
    assert (told["worlds"], told["success"]) == (4, 1.0)
    assert 0.5 < told["relative_to_expert"] < 1.1
    each = run_json("eval", "-l", library, "--seeds", "2:3", "--each")["results"]
    alone = run_json("eval", "-l", library, "--seeds", "0:4", "--each")["results"]
    assert each[0] == alone[2]  # side by side or alone
    assert "finished in time    100%" in run("eval", "-l", library, "--seeds", "0:2").stdout
    goto = run("eval", "-l", library, "--behavior", "goto", "--bind", "A=station", "--seeds", "0:2").stdout
    assert "done in time        100%" in goto
    assert "yardstick" not in goto


def test_eval_elsewhere(library: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(run("worlds", "forage-team").stdout.replace("limit_s = 1800", "limit_s = 60"))
    told = run_json("eval", mine, "-l", library, "--seeds", "0:2", "--each")
    assert (told["world"], told["worlds"], told["expert_median_s"]) == ("forage-team", 2, None)
    assert [set(row) for row in told["results"]] == [
        {"seed", "success", "seconds", "delivered", "gathered"}
    ] * 2
    text = run("eval", mine, "-l", library, "--seeds", "0:2", "--each").stdout
    assert "yardstick" not in text
    assert f"understudy run {mine} --behavior forage --library {library} --seed" in text


def test_the_run_that_eval_advises_runs(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It names the library, the kit and the bindings, too, and every name survives a shell."""
    folder = tmp_path / "my library"
    library.rename(folder)
    (tmp_path / "eval_kit.py").write_text("from understudy.sim.forage import FORAGE_KIT as kit\n")
    mine = tmp_path / "mine.toml"
    mine.write_text(run("worlds", "forage").stdout.replace("limit_s", "limit_s = 1 #"))
    monkeypatch.chdir(tmp_path)
    chosen = ("-l", folder, "--behavior", "goto", "--bind", "A=station", "--kit", "eval_kit:kit")
    text = run("eval", mine, *chosen, "--seeds", "0:1").stdout
    (line,) = (line for line in text.splitlines() if line.startswith("Watch one: understudy "))
    told = run_json(*shlex.split(line.removeprefix("Watch one: understudy ")))
    assert (told["behavior"], told["seed"]) == ("goto", 0)


def test_run(library: Path, tmp_path: Path) -> None:
    told = run_json("run", "-l", library, "--seed", "1", "--record", tmp_path / "out.png")
    assert told["success"]
    assert (tmp_path / "out.png").read_bytes()[:4] == b"\x89PNG"
    arrived = run_json("run", "-l", library, "--behavior", "goto", "--bind", "A=station", "--seed", "1")
    assert arrived["path"] == ["done"]
    result = run("run", "-l", library, "-r", tmp_path / "out.gif", "--seconds", "20")
    assert "Drawn in" in result.stdout
    assert (tmp_path / "out.gif").read_bytes()[:3] == b"GIF"


def test_run_elsewhere(library: Path, tmp_path: Path) -> None:
    """Basic behaviors need no library; every robot runs what is asked for, and several are drawn."""
    nowhere = tmp_path / "nowhere"
    arguments = ("run", "patrol", "-l", nowhere, "--behavior", "forwards", "--seconds", "3")
    told = run_json(*arguments, "--record", tmp_path / "out.png", "--trace", tmp_path / "out.jsonl")
    assert (told["world"], told["robots"], told["success"]) == ("patrol", 4, None)
    assert (told["doing"], told["path"]) == ({"forwards": 4}, None)
    assert (tmp_path / "out.png").read_bytes()[:4] == b"\x89PNG"
    header, *rows = [json.loads(line) for line in (tmp_path / "out.jsonl").read_text().splitlines()]
    assert (header["scenario"], header["robots"], len(rows)) == ("patrol", 4, 4 * 30)
    assert "forwards in patrol world 0: 4 robots: forwards 4 after 3.0 s\n" in run(*arguments).stdout
    assert run_json(*arguments[:1], *arguments[2:], "--world", "patrol")["world"] == "patrol"
    told = run_json("run", "forage-team", "-l", library, "--seconds", "30", "--record", tmp_path / "out.gif")
    assert told["total"] > 0
    assert sum(told["doing"].values()) == 4


def test_a_squad_runs_what_it_was_taught(tmp_path: Path) -> None:
    """Its automata are in a folder of its name; what its coordinator does is said by what the robots do."""
    for automaton in (ROBOTS.automaton(name) for name in ROBOTS.taught):
        save_automaton(tmp_path, TrainedAutomaton(automaton))
    save_automaton(tmp_path / "patrol", TrainedAutomaton(lead()))
    for name in ("lead", "patrol/lead"):
        told = run_json("run", "patrol", "-l", tmp_path, "--behavior", name, "--seconds", "5")
        assert (told["behavior"], told["doing"]) == ("lead", {"wander": 4})
    assert run_json("run", "patrol", "-l", tmp_path, "--seconds", "1")["behavior"] == "lead"
    alone = run_json("run", "patrol", "-l", tmp_path, "--behavior", "patrol", "--seconds", "1")
    assert alone["behavior"] == "patrol"


def test_eval_judges_a_coordinator_with_its_robots(tmp_path: Path) -> None:
    """Found as run finds it; the run that is advised names it the same way."""
    folder, mine = tmp_path / "library", tmp_path / "mine.toml"
    for automaton in (ROBOTS.automaton(name) for name in ROBOTS.taught):
        save_automaton(folder, TrainedAutomaton(automaton))
    save_automaton(folder / "patrol", TrainedAutomaton(lead()))
    mine.write_text(
        run("worlds", "patrol").stdout.replace("limit_s = 600", "limit_s = 20")
        + '\n[goal]\ntarget = "intruder"\nwithin = 0.5\n'
    )
    for name in ("lead", "patrol/lead"):
        told = run_json("eval", mine, "-l", folder, "--behavior", name, "--seeds", "0:3", "--each")
        assert (told["behavior"], told["worlds"], told["expert_median_s"]) == ("lead", 3, None)
        for row in told["results"]:
            seed = ("--seed", str(row["seed"]))
            seen = run_json("run", mine, "-l", folder, "--behavior", name, *seed)
            assert row["success"] == seen["success"]
            assert row["seconds"] == (seen["seconds"] if seen["success"] else None)
    text = run("eval", mine, "-l", folder, "--behavior", "patrol/lead", "--seeds", "0:3").stdout
    assert f"run {mine} --behavior patrol/lead --library {folder} --seed" in text


def test_types_that_differ_run_what_is_in_their_folders(tmp_path: Path) -> None:
    """Others idle; and a name that two types know has to say whose."""
    for kind, behavior in (("scout", "forward"), ("carrier", "rotate_left")):
        states = (START, State(behavior, behavior))
        roam = Automaton("roam", states, (), (), False, {"start": Tree((make_leaf(1),))})
        save_automaton(tmp_path / kind, TrainedAutomaton(roam))
    told = run_json("run", "salvage", "-l", tmp_path, "--behavior", "carrier/roam", "--seconds", "2")
    assert told["doing"] == {"rotate_left": 8, "idles": 4}
    told = run_json("run", "salvage", "-l", tmp_path, "--behavior", "load", "--seconds", "1")
    assert told["doing"] == {"load": 8, "idles": 4}
    refused = run("run", "salvage", "-l", tmp_path, "--behavior", "roam")
    assert refused.exit_code == 2
    assert "scout/roam and carrier/roam" in " ".join(refused.output.split())


def test_a_run_leaves_a_trace(library: Path, tmp_path: Path) -> None:
    told = run("run", "-l", library, "--seconds", "2", "--trace", tmp_path / "out.jsonl")
    assert "Traced in" in told.stdout
    header, *rows = [json.loads(line) for line in (tmp_path / "out.jsonl").read_text().splitlines()]
    assert (header["scenario"], header["seed"], header["robots"]) == ("forage", 0, 1)
    assert [row["time_s"] for row in rows] == [round(0.1 * tick, 6) for tick in range(1, 21)]
    assert rows[-1]["doing"].startswith("harvest > ")


def test_a_goal_is_reached(library: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(run("worlds", "forage").stdout.replace("delivered = true", 'target = "station"'))
    told = run("run", mine, "-l", library, "--behavior", "goto", "--bind", "A=station")
    assert "goal reached after" in told.stdout


def test_what_a_table_taught_runs_in_a_scenario(tmp_path: Path) -> None:
    table, folder, picture = tmp_path / "table.csv", tmp_path / "library", tmp_path / "out.png"
    table.write_text(
        "state,next,kind,sonar_ahead:continuous\n"
        "start,forward,directive,3\n"
        "forward,rotate_left,directive,0.3\n"
        "rotate_left,forward,directive,1.5\n"
    )
    assert run("learn", table, "-l", folder, "-n", "wander").exit_code == 0
    options = ("-l", folder, "--behavior", "wander", "--seconds", "2", "--record", picture)
    assert run("run", "arena", *options).exit_code == 0
    assert picture.exists()


def test_a_run_without_an_end_is_refused() -> None:
    result = run("run", "patrol", "--behavior", "stop", "--seconds", "inf")
    assert result.exit_code == 2
    assert "--seconds" in result.stderr


TOPS = [  # what is left of the library, what runs when nothing is named
    (["deposit", "forage", "goto", "harvest"], "forage"),
    (["deposit", "goto"], "deposit"),
    (["goto"], "goto"),
    (["deposit", "goto", "harvest"], None),
    ([], None),
]


@pytest.mark.parametrize(("left", "top"), TOPS)
def test_the_automaton_at_the_top_runs_when_none_is_named(
    left: list[str], top: str | None, library: Path
) -> None:
    for file in library.glob("*.json"):
        if file.stem not in left:
            file.unlink()
    kit = find_kit(None, "forage")
    found = open_behavior_library(None, library, kit)
    if top is not None:
        assert choose_behavior(found, None, library) == top
        return
    with pytest.raises(SettingError, match=r"give --behavior NAME: the automata of .* are") as refusal:
        choose_behavior(found, None, library)
    assert all(name in str(refusal.value) for name in [*left, "rotate_left"])


@pytest.mark.long
def test_watching_in_a_terminal(library: Path) -> None:
    master, slave = pty.openpty()
    watching = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "understudy.ui.cli",
            "run",
            "-l",
            str(library),
            "--seconds",
            "30",
            "--speed",
            "30",
        ],
        stdout=slave,
        stderr=slave,
        env={**os.environ, "PYTHONPATH": str(ROOT / "src"), "COLUMNS": "80", "LINES": "24", "TERM": "xterm"},
    )
    os.close(slave)
    text = b""
    while True:
        try:
            part = os.read(master, 65536)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        text += part
    os.close(master)
    assert watching.wait() == 0
    assert b"harvest > " in text
    assert "⌂".encode() in text
