"""The commands: what they print for people and for programs, and how they fail."""

from __future__ import annotations

import json
import os
import pty
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from tests.cli.forage_parts import AUTOMATA
from tests.model.lessons import goto as taught_goto
from typer.testing import CliRunner, Result

from understudy.cli.app import app
from understudy.cli.parts import behavior_of, find_kit, library_for
from understudy.errors import SettingError
from understudy.model.folder import save
from understudy.model.library import Taught

ROOT = Path(__file__).parents[2]
TABLE = """state,next,kind,distance:continuous,ready:categorical(no|yes)
start,forward,directive,5,yes
forward,forward,default,5,yes
forward,done,directive,0.4,yes
"""


@pytest.fixture
def library(tmp_path: Path) -> Path:
    folder = tmp_path / "library"
    for automaton in AUTOMATA:
        save(folder, Taught(automaton))
    return folder


@pytest.fixture
def lessons(tmp_path: Path) -> Path:
    folder = tmp_path / "lessons"
    save(folder, taught_goto())
    original = taught_goto()
    assert original.lesson is not None
    return folder


def run(*arguments: object, monkeypatch: pytest.MonkeyPatch | None = None) -> Result:
    given = [str(argument) for argument in arguments]
    if monkeypatch is not None:
        monkeypatch.setattr(sys, "argv", ["understudy", *given])
    return CliRunner(env={"COLUMNS": "80", "NO_COLOR": "1", "TERM": "dumb"}).invoke(app, given)


def said(*arguments: object) -> Any:
    result = run(*arguments, "--json")
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_list(library: Path) -> None:
    told = said("list", "-l", library)
    assert [row["name"] for row in told["automata"]] == ["deposit", "forage", "goto", "harvest"]
    assert told["automata"][1]["uses"] == ["harvest", "deposit"]
    assert told["automata"][2]["used_by"] == ["deposit", "harvest"]
    assert "goto(A)" in run("list", "-l", library).stdout


def test_list_shows_the_rest_beside_a_bad_file(library: Path) -> None:
    (library / "forage.json").write_text("{")
    result = run("list", "-l", library, "--json")
    assert result.exit_code == 2
    told = json.loads(result.stdout)
    assert [row["name"] for row in told["automata"]] == ["deposit", "goto", "harvest"]
    assert "cut short" in told["problems"]["forage.json"]


def test_show(lessons: Path, library: Path) -> None:
    told = said("show", "goto", "-l", lessons)
    assert [state["name"] for state in told["states"]] == ["start", "forward", "done"]
    assert told["examples"][1]["values"] == {
        "distance_to(A)": 5.5,
        "angle_to(A)": None,
        "ready": "yes",
        "bump": "no",
    }
    assert told["options"] == {"learner": "trees", "reaction_s": 0.2, "watched": True}
    assert any("distance_to(A)" in line for line in told["conditions"]["forward"])
    text = run("show", "goto", "-l", lessons).stdout
    assert "When it switches" in text
    assert "beside 2 watched examples" in text
    assert max(map(len, text.splitlines())) <= 80
    assert "goto(nearest_food)" in run("show", "harvest", "-l", library).stdout


def test_validate(library: Path) -> None:
    told = said("validate", "-l", library)
    assert told["valid"]
    assert told["checked"] == ["deposit", "forage", "goto", "harvest"]
    assert "all valid" in run("validate", "-l", library).stdout


def test_validate_finds_what_is_missing(library: Path) -> None:
    (library / "goto.json").unlink()
    result = run("validate", "-l", library, "--json")
    assert result.exit_code == 2
    assert set(json.loads(result.stdout)["problems"]) == {"deposit", "forage", "harvest"}
    assert "no behavior 'goto'" in run("validate", "deposit", "-l", library).stdout.replace("\n", " ")


def test_validate_says_which_scenario_a_library_is_of(library: Path) -> None:
    result = run("validate", "-l", library, "--world", "soccer")
    assert result.exit_code == 2
    assert "all valid in another scenario: give --world forage or" in " ".join(result.stdout.split())
    assert said("validate", "-l", library)["advice"] is None
    goto = library / "goto.json"
    goto.write_text(goto.read_text().replace('"distance_to"', '"depth_of"'))
    result = run("validate", "-l", library)
    assert "give --world SCENARIO; with a kit of your own" in " ".join(result.stdout.split())


def test_validate_gives_no_advice_on_a_file_that_is_broken_anywhere(library: Path) -> None:
    (library / "forage.json").write_text("{")
    told = run("validate", "-l", library, "--json").stdout
    assert json.loads(told)["advice"] is None


def test_stale_trees_are_noted_and_rebuilt(tmp_path: Path) -> None:
    table, folder = tmp_path / "lesson.csv", tmp_path / "library"
    table.write_text(TABLE)
    assert run("learn", table, "-l", folder, "-n", "walk").exit_code == 0
    path = folder / "walk.json"
    path.write_text(path.read_text().replace("0.4, ", "0.5, "))
    assert said("list", "-l", folder)["automata"][0]["rebuilt"] is not None
    kit = tmp_path / "walking_kit.py"
    kit.write_text(
        "from understudy.model.behavior import Behavior\n"
        "from understudy.model.feature import Feature\n"
        "from understudy.model.kinds import BOOLEAN, Continuous\n"
        "from understudy.model.kit import Kit\n"
        "kit = Kit.of(Feature('distance', Continuous(), reading='distance'), Behavior('forward'),\n"
        "             Feature('ready', BOOLEAN, reading='ready'), Behavior('done'))\n"
    )
    command = [sys.executable, "-m", "understudy.cli"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    for arguments, expected in (
        ("validate", "built anew"),
        ("rebuild", "1 automaton rebuilt"),
        ("validate", "all valid"),
    ):
        done = subprocess.run(
            [*command, arguments, "-l", str(folder), "--kit", "walking_kit:kit"],
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env={**environment, "PYTHONIOENCODING": "utf-8"},
            check=True,
        )
        assert expected in done.stdout
    assert len(list((folder / "versions" / "walk").iterdir())) == 1


def test_diff(tmp_path: Path) -> None:
    table, folder = tmp_path / "lesson.csv", tmp_path / "library"
    table.write_text(TABLE)
    run("learn", table, "-l", folder, "-n", "walk")
    table.write_text(TABLE.replace("0.4", "0.9") + "start,done,directive,0.1,no\n")
    run("learn", table, "-l", folder, "-n", "walk")
    told = said("diff", "walk", "-l", folder)
    assert told["from"] == "1"
    assert len(told["changes"]["examples"]) == 3
    assert told["changes"]["conditions"][0] == "  start"
    assert said("diff", "walk", "--to", "1", "-l", folder)["changes"] == {}
    assert "nothing changed" in run("diff", "walk", "--from", folder / "walk.json", "-l", folder).stdout


def test_learn(tmp_path: Path) -> None:
    table, rows = tmp_path / "lesson.csv", tmp_path / "rows.csv"
    table.write_text(TABLE)
    rows.write_text(
        "state,next,distance:continuous,ready:categorical(no|yes)\nforward,,0.3,yes\nforward,,9,\n"
    )
    told = said("learn", table, "--predict", rows)
    assert told["predictions"] == ["done", "forward"]
    assert set(told["states"]["forward"]) == {
        "conditions", "nodes", "depth", "contradictions", "disagreements", "fit_ms",
    }  # fmt: skip
    assert "done when distance" in run("learn", table, "--predict", rows).stdout


def test_eval(library: Path) -> None:
    told = said("eval", "--library", library, "--behavior", "forage", "--world", "forage", "--seeds", "0:4")
    assert (told["worlds"], told["success"]) == (4, 1.0)
    assert 0.5 < told["relative_to_expert"] < 1.1
    each = said("eval", "-l", library, "--seeds", "2:3", "--each")["results"]
    alone = said("eval", "-l", library, "--seeds", "0:4", "--each")["results"]
    assert each[0] == alone[2]  # side by side or alone
    assert "finished in time    100%" in run("eval", "-l", library, "--seeds", "0:2").stdout


def test_eval_elsewhere(library: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(run("worlds", "forage-team").stdout.replace("limit_s = 1800", "limit_s = 60"))
    told = said("eval", mine, "-l", library, "--seeds", "0:2", "--each")
    assert (told["world"], told["worlds"], told["expert_median_s"]) == ("forage-team", 2, None)
    assert [set(row) for row in told["results"]] == [{"seed", "success", "seconds", "delivered"}] * 2
    text = run("eval", mine, "-l", library, "--seeds", "0:2", "--each").stdout
    assert "yardstick" not in text
    assert f"understudy run {mine} --behavior forage --seed" in text


def test_worlds(tmp_path: Path) -> None:
    told = said("worlds")
    assert [(row["name"], row["robots"]) for row in told] == [
        ("arena", 1), ("forage", 1), ("forage-team", 4), ("patrol", 4), ("rooms", 1), ("soccer", 1),
    ]  # fmt: skip
    text = run("worlds").stdout
    assert max(map(len, text.splitlines())) <= 80
    assert "Bring food from sources" in text
    printed = run("worlds", "patrol").stdout
    assert printed == (ROOT / "src/understudy/worlds/scenarios/patrol.toml").read_text(encoding="utf-8")
    mine = tmp_path / "mine.toml"
    mine.write_text(printed)
    assert run("worlds", mine).stdout == printed
    assert said("worlds", mine)["name"] == "patrol"


def test_run_elsewhere(library: Path, tmp_path: Path) -> None:
    """Basic behaviors need no library; every robot runs what is asked for, and several are drawn."""
    nowhere = tmp_path / "nowhere"
    arguments = ("run", "patrol", "-l", nowhere, "--behavior", "forwards", "--seconds", "3")
    told = said(*arguments, "--record", tmp_path / "out.png", "--trace", tmp_path / "out.jsonl")
    assert (told["world"], told["robots"], told["success"]) == ("patrol", 4, None)
    assert (told["doing"], told["path"]) == ({"forwards": 4}, None)
    assert (tmp_path / "out.png").read_bytes()[:4] == b"\x89PNG"
    header, *rows = [json.loads(line) for line in (tmp_path / "out.jsonl").read_text().splitlines()]
    assert (header["scenario"], header["robots"], len(rows)) == ("patrol", 4, 4 * 30)
    assert "forwards in patrol world 0: 4 robots: forwards 4 after 3.0 s\n" in run(*arguments).stdout
    assert said(*arguments[:1], *arguments[2:], "--world", "patrol")["world"] == "patrol"
    told = said("run", "forage-team", "-l", library, "--seconds", "30", "--record", tmp_path / "out.gif")
    assert told["total"] > 0
    assert sum(told["doing"].values()) == 4


def test_a_goal_is_reached(library: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(run("worlds", "forage").stdout.replace("delivered = true", 'target = "station"'))
    told = run("run", mine, "-l", library, "--behavior", "goto", "--bind", "A=station")
    assert "goal reached after" in told.stdout


def test_run(library: Path, tmp_path: Path) -> None:
    told = said("run", "-l", library, "--seed", "1", "--record", tmp_path / "out.png")
    assert told["success"]
    assert (tmp_path / "out.png").read_bytes()[:4] == b"\x89PNG"
    arrived = said("run", "-l", library, "--behavior", "goto", "--bind", "A=station", "--seed", "1")
    assert arrived["path"] == ["done"]
    result = run("run", "-l", library, "-r", tmp_path / "out.gif", "--seconds", "20")
    assert "Drawn in" in result.stdout
    assert (tmp_path / "out.gif").read_bytes()[:3] == b"GIF"


def test_a_run_leaves_a_trace(library: Path, tmp_path: Path) -> None:
    told = run("run", "-l", library, "--seconds", "2", "--trace", tmp_path / "out.jsonl")
    assert "Traced in" in told.stdout
    header, *rows = [json.loads(line) for line in (tmp_path / "out.jsonl").read_text().splitlines()]
    assert (header["scenario"], header["seed"], header["robots"]) == ("forage", 0, 1)
    assert [row["time_s"] for row in rows] == [round(0.1 * tick, 6) for tick in range(1, 21)]
    assert rows[-1]["doing"].startswith("harvest > ")


def test_watching_in_a_terminal(library: Path) -> None:
    master, slave = pty.openpty()
    watching = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "understudy.cli",
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


def test_bench(monkeypatch: pytest.MonkeyPatch) -> None:
    from understudy.bench import interpreter

    monkeypatch.setattr(interpreter, "TICKS", 100)
    monkeypatch.setattr(interpreter, "ROUNDS", 3)
    result = run("bench", "interpreter", "--json")
    told = json.loads(result.stdout)
    assert told["levels"] == 3
    assert told["py_trees_nodes"] == 11
    assert result.exit_code == (0 if told["passed"] else 1)


def test_the_bench_compares_equal_decisions() -> None:
    from understudy.bench.interpreter import _peer, interpreter, readings

    ours, theirs = interpreter(), _peer()
    for tick, row in enumerate(readings(300)):
        basic = ours.pulse(row, tick * 0.1)
        theirs.tick(row)
        assert str(ours.program.basics[basic]) == theirs.action


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
    found = library_for(None, library, kit)
    if top is not None:
        assert behavior_of(found, None, library) == top
        return
    with pytest.raises(SettingError, match=r"give --behavior NAME: the automata of .* are") as refusal:
        behavior_of(found, None, library)
    assert all(name in str(refusal.value) for name in [*left, "rotate_left"])


BAD = [  # arguments, what the error says
    (["show", "nope", "-l", "{lib}"], "no automaton 'nope'; it has deposit, forage, goto and harvest"),
    (["show", "x", "-l", "/nowhere"], "/nowhere: opening the library failed: No such file"),
    (["list", "-l", "{lib}", "--world", "mars"], "no world 'mars'; it has arena, forage"),
    (["list", "-l", "{lib}", "--kit", "nokit"], "--kit: 'nokit' cannot be had"),
    (["list", "-l", "{lib}", "--kit", "json:loads"], "is a function; name a Kit as MODULE:NAME"),
    (["diff", "goto", "-l", "{lib}"], "has no former version"),
    (["diff", "goto", "--from", "7", "-l", "{lib}"], "no version '7'; it has none"),
    (["diff", "goto", "--from", "/no.json", "-l", "{lib}"], "/no.json: reading failed"),
    (["eval", "-l", "{lib}", "--seeds", "3:1"], "'3:1' is no range of seeds; write A:B"),
    (["eval", "-l", "{lib}", "--seeds", "x"], "'x' is no range of seeds"),
    (["eval", "-l", "{lib}", "--behavior", "goto"], "parameter 'A' of 'goto' is bound to nothing"),
    (["eval", "-l", "{lib}", "--behavior", "fly"], "no behavior 'fly'"),
    (["run", "-l", "{lib}", "--behavior", "goto", "--bind", "A=moon"], "no target 'moon'"),
    (
        ["run", "-l", "{lib}", "--behavior", "goto", "--bind", "A"],
        "'A' is no binding; write PARAMETER=TARGET",
    ),
    (["run", "moon", "-l", "{lib}"], "no world 'moon'; it has arena"),
    (["run", "moon.toml", "-l", "{lib}"], "moon.toml: there is no such file"),
    (["run", "patrol", "--world", "rooms"], "'rooms' is another scenario than 'patrol'; name one"),
    (
        ["run", "patrol", "-l", "{lib}/no", "--behavior", "fly"],
        "the kit has no behavior 'fly'; it has forwards",
    ),
    (["run", "-l", "{lib}", "--behavior", "fly"], "no behavior 'fly'"),
    (
        ["run", "patrol", "-l", "{lib}/no"],
        "--behavior is missing; give --behavior NAME: there is no folder",
    ),
    (["eval", "patrol", "-l", "{lib}/no"], "and the basic behaviors are forwards, "),
    (["run", "patrol", "-l", "{lib}"], "open it with the kit it was taught with"),
    (["eval", "patrol", "-l", "{lib}/no", "--behavior", "stop"], "goal is missing, so that no run of it can"),
    (["eval", "moon", "-l", "{lib}"], "no world 'moon'"),
    (["worlds", "moon"], "no world 'moon'; it has arena"),
    (["run", "-l", "{lib}", "--trace", "x.csv"], "is no trace; name a file that ends in .jsonl"),
    (["run", "-l", "{lib}", "--trace", "/nowhere/x.jsonl"], "/nowhere/x.jsonl: writing the trace failed"),
    (["run", "-l", "{lib}", "--record", "x.mp4"], "is no picture; name a file that ends in .gif"),
    (
        ["run", "-l", "{lib}", "--record", "/nowhere/x.png", "--seconds", "1"],
        "/nowhere/x.png: writing the picture",
    ),
    (["learn", "/none.csv"], "/none.csv"),
    (["learn", "/none.csv", "--name", "x"], "--library is missing"),
    (["rebuild", "nope", "-l", "{lib}"], "no automaton 'nope'"),
    (["validate", "nope", "-l", "{lib}"], "no automaton 'nope'"),
]


@pytest.mark.parametrize(
    ("arguments", "expected"), BAD, ids=lambda each: " ".join(each) if isinstance(each, list) else ""
)
def test_a_mistake_is_one_paragraph(
    arguments: list[str], expected: str, library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = contents(library)
    given = [argument.format(lib=library) for argument in arguments]
    for extra in ([], ["--json"]):
        result = run(*given, *extra, monkeypatch=monkeypatch)
        assert result.exit_code == 2
        assert result.stderr.startswith("Error: ")
        assert expected in result.stderr
        assert result.stderr.count("\n") == 1
        if extra:
            assert expected in json.loads(result.stdout)["error"]["message"]
    assert contents(library) == before


def test_a_fault_of_ours_says_how_to_report_it(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("oh")

    monkeypatch.setattr("understudy.cli.shelf.look", broken)
    result = run("list", "-l", library)
    assert result.exit_code == 70
    assert "ZeroDivisionError: oh" in result.stderr
    assert "--debug" in result.stderr
    assert isinstance(run("--debug", "list", "-l", library).exception, ZeroDivisionError)


def test_interrupted(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("understudy.cli.shelf.look", interrupt)
    assert run("list", "-l", library).exit_code == 130


def test_it_starts_quickly() -> None:
    code = (
        "import sys; sys.argv = ['understudy', '--help']\n"
        "from understudy.cli import main\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "slow = {'numba', 'matplotlib', 'textual', 'sklearn', 'numpy', 'PIL'} & set(sys.modules)\n"
        "assert not slow, slow\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "understudy demo" in done.stdout


def test_as_a_process(library: Path) -> None:
    """No traceback, the right exit codes, and a pipe that closes early is no error."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    command = f"{sys.executable} -m understudy.cli"
    for arguments, code in (("--version", 0), ("list -l /nowhere", 2), ("nonsense", 2), ("eval --seeds", 2)):
        done = subprocess.run(
            f"{command} {arguments}", shell=True, capture_output=True, text=True, env=environment, check=False
        )
        assert done.returncode == code
        assert "Traceback" not in done.stderr
    done = subprocess.run(
        f"{command} list -l {library} | head -1",
        shell=True,
        capture_output=True,
        text=True,
        env=environment,
        check=True,
    )
    assert done.stderr == ""


def test_a_run_without_an_end_is_refused() -> None:
    result = run("run", "patrol", "--behavior", "stop", "--seconds", "inf")
    assert result.exit_code == 2
    assert "--seconds" in result.stderr


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


LATE = [  # mistakes that show only when the behavior is made ready to run
    ["run", "-l", "{lib}", "--behavior", "goto"],
    ["run", "-l", "{lib}", "--behavior", "goto", "--bind", "A=moon"],
    ["eval", "-l", "{lib}", "--behavior", "goto"],
    ["eval", "patrol", "-l", "{lib}/no", "--behavior", "stop"],
]


@pytest.mark.parametrize("arguments", LATE, ids=" ".join)
def test_mistakes_are_told_before_anything_is_compiled(
    arguments: list[str], library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def compiled(**_: object) -> None:
        pytest.fail("compiled first")

    monkeypatch.setattr("understudy.cli.progress.compile_once", compiled)
    result = run(*(argument.format(lib=library) for argument in arguments))
    assert result.exit_code == 2
    assert result.stderr.startswith("Error: ")
