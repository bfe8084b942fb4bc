"""How commands fail: in one paragraph, with the right exit code, and before anything slow."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from tests.ui.cli.commands import ROOT, run


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


BAD = [  # arguments, what the error says
    (["show", "nope", "-l", "{lib}"], "no automaton 'nope'; it has deposit, forage, goto and harvest"),
    (["show", "x", "-l", "/nowhere"], "/nowhere: opening the library failed: No such file"),
    (["list", "-l", "{lib}", "--world", "mars"], "no world 'mars'; it has arena, boxes, forage"),
    (["list", "-l", "{lib}", "--kit", "nokit"], "--kit: 'nokit' is not offered by any installed package"),
    (["list", "-l", "{lib}", "--kit", "json:loads"], "is a function; name a Kit as MODULE:NAME"),
    (["diff", "goto", "-l", "{lib}"], "has no former version"),
    (["diff", "goto", "--from", "7", "-l", "{lib}"], "no version '7'; it has none"),
    (["diff", "goto", "--from", "/no.json", "-l", "{lib}"], "/no.json: reading failed"),
    (["eval", "-l", "{lib}", "--seeds", "3:1"], "'3:1' is not a range of seeds; write A:B"),
    (["eval", "-l", "{lib}", "--seeds", "x"], "'x' is not a range of seeds"),
    (["eval", "-l", "{lib}", "--behavior", "goto"], "parameter 'A' of 'goto' is bound to nothing"),
    (["eval", "-l", "{lib}", "--behavior", "fly"], "no behavior 'fly'"),
    (["eval", "-l", "{lib}", "--goal", "there"], "no flag, feature or reading 'there'; it has distance_to"),
    (["eval", "-l", "{lib}", "--goal", "food_stored"], "goal 'food_stored' is continuous; name one that is"),
    (["eval", "-l", "{lib}", "--metric", "foot"], "no feature or reading 'foot'; did you mean 'food_left'"),
    (["eval", "-l", "{lib}", "--limit", "-1"], "limit_s is -1.0; give a time in s"),
    (["eval", "-l", "{lib}", "--jobs", "0"], "jobs is 0; give the number of processes, at least 1"),
    (["eval", "-l", "{lib}", "--against", "/none"], "there is no folder /none with automata"),
    (["eval", "-l", "{lib}", "--format", "html"], "'html' is unknown; give markdown, latex or csv"),
    (["run", "-l", "{lib}", "--behavior", "goto", "--bind", "A=moon"], "no target 'moon'"),
    (
        ["run", "-l", "{lib}", "--behavior", "goto", "--bind", "A"],
        "'A' is not a binding; write PARAMETER=TARGET",
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
    (
        ["eval", "patrol", "-l", "{lib}/no", "--behavior", "stop"],
        "goal is missing, and a run cannot be evaluated",
    ),
    (["eval", "moon", "-l", "{lib}"], "no world 'moon'"),
    (["worlds", "moon"], "no world 'moon'; it has arena"),
    (["run", "-l", "{lib}", "--trace", "x.csv"], "is not a trace; name a file that ends in .jsonl"),
    (["run", "-l", "{lib}", "--trace", "/nowhere/x.jsonl"], "/nowhere/x.jsonl: writing the trace failed"),
    (
        ["run", "-l", "{lib}", "--record", "x.mp4"],
        "is neither a picture nor a recording; name a file that ends in",
    ),
    (
        ["run", "-l", "{lib}", "--robot", "r.toml", "--record", "x.gif"],
        "'x.gif' is not a recording, and real robots are not drawn",
    ),
    (
        ["run", "-l", "{lib}", "--robot", "r.toml", "--record", "x.mcap", "--no-record"],
        "--record: and --no-record were both given; give one of them",
    ),
    (
        ["run", "-l", "{lib}", "--robot", "r.toml", "--trace", "x.jsonl"],
        "--trace is not used with real robots",
    ),
    (["run", "-l", "{lib}", "--replay", "/none.mcap"], "/none.mcap: there is no such file"),
    (
        ["run", "-l", "{lib}", "--record", "/nowhere/x.mcap"],
        "/nowhere/x.mcap: recording failed: No such file",
    ),
    (
        ["run", "--robot", "r.toml", "--replay", "x.mcap"],
        "--robot is not used with --replay",
    ),
    (["learn", "x.csv", "--features", "x"], "--features is not used with a table; leave it"),
    (["learn", "--recording", "/none.mcap", "--features", "x"], "/none.mcap: there is no such file"),
    (["why", "/none.mcap", "--time", "1"], "/none.mcap: there is no such file"),
    (
        ["run", "-l", "{lib}", "--record", "/nowhere/x.png", "--seconds", "1"],
        "/nowhere/x.png: writing the picture",
    ),
    (
        ["studio", "--map", "m.toml", "--drive"],
        "--map is given without a recording; give --recording FILE, or",
    ),
    (["studio", "--name", "x"], "--name is given without a recording; give --recording FILE or --drive"),
    (["studio", "--driver", "anna"], "--driver is given without a recording; give --recording FILE"),
    (["studio", "--recording", "x.csv", "--trust", "anna"], "review: --trust is not used with one driver"),
    (
        ["studio", "--recording", "x.csv", "--recording", "y.csv", "--driver", "anna"],
        "review: --driver is given once for 2 recordings",
    ),
    (["studio", "--recording", "x.csv", "--drive"], "--recording is given beside a world or a robot"),
    (["studio", "--robot", "r.toml", "--drive"], "--drive is given for real robots; name a simulated world"),
    (["studio", "moon", "--drive"], "no world 'moon'; it has arena"),
    (["studio", "--drive", "--agent", "1"], "--agent is 1; count from 0 to 0"),
    (["studio", "-l", "{lib}/no", "--drive", "--behaviors", "fly"], "no behavior 'fly'"),
    (["studio", "-l", "{lib}/no", "--drive", "--features", "fly"], "no feature 'fly'"),
    (["learn", "/none.csv"], "/none.csv"),
    (["learn", ""], "Is a directory; name a CSV file"),
    (
        ["learn", "/none.csv", "--name", "x"],
        "--library is missing; give the folder of the library to save 'x' in",
    ),
    (
        ["learn", "/none.csv", "--library", "mine"],
        "--name is missing; give the name to save the automaton under in mine",
    ),
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


LATE = [  # mistakes that show only when the behavior is made ready to run, or the library is looked at
    ["run", "-l", "{lib}", "--behavior", "goto"],
    ["run", "-l", "{lib}", "--behavior", "goto", "--bind", "A=moon"],
    ["eval", "-l", "{lib}", "--behavior", "goto"],
    ["eval", "patrol", "-l", "{lib}/no", "--behavior", "stop"],
    ["studio", "--no-browser", "-l", "{lib}/goto.json"],
    ["studio", "--no-browser", "-l", "{lib}/goto.json/library"],
    ["studio", "--no-browser", "-l", "{lib}", "--host", "nowhere.invalid"],
]


@pytest.mark.parametrize("arguments", LATE, ids=" ".join)
def test_mistakes_are_told_before_any_kernel_runs(
    arguments: list[str], library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail_if_called(*_: object) -> None:
        pytest.fail("a kernel ran first")

    monkeypatch.setattr("understudy.jit.decorators.Kernel.__call__", fail_if_called)
    result = run(*(argument.format(lib=library) for argument in arguments))
    assert result.exit_code == 2
    assert result.stderr.startswith("Error: ")


def test_a_fault_of_ours_says_how_to_report_it(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("oh")

    monkeypatch.setattr("understudy.ui.cli.library_data.open_each_automaton", broken)
    result = run("list", "-l", library)
    assert result.exit_code == 70
    assert "ZeroDivisionError: oh" in result.stderr
    assert "--debug" in result.stderr
    assert isinstance(run("--debug", "list", "-l", library).exception, ZeroDivisionError)


def test_interrupted(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("understudy.ui.cli.library_data.open_each_automaton", interrupt)
    assert run("list", "-l", library).exit_code == 130


@pytest.mark.long
def test_as_a_process(library: Path) -> None:
    """No traceback, the right exit codes, and a pipe that closes early is no error."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    command = f"{sys.executable} -m understudy.ui.cli"
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


def test_it_starts_quickly() -> None:
    code = (
        "import sys; sys.argv = ['understudy', '--help']\n"
        "from understudy.ui.cli import run_command_line\n"
        "try:\n    run_command_line()\nexcept SystemExit:\n    pass\n"
        "slow = {'numba', 'matplotlib', 'textual', 'sklearn', 'numpy', 'PIL'} & set(sys.modules)\n"
        "assert not slow, slow\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "understudy demo" in done.stdout
