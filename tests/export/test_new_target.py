"""A new target of exports is one module with a function, and its line in `TARGETS`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.export.exports import FIXTURE, open_fixture
from tests.ui.cli.commands import run, run_json

from understudy.addons.export.export_automaton import export_automaton
from understudy.addons.export.target_files import ExportJob, TargetFiles
from understudy.addons.export.targets.target_table import TARGETS, ExportTarget
from understudy.errors import SettingError


def make_outline_files(job: ExportJob) -> TargetFiles:
    """Make the files of a target that lists automata with their states."""
    lines = [
        f"{automaton.name}: {', '.join(state.name for state in automaton.states)}"
        for automaton in job.hierarchy.automata
    ]
    readings = {str(slot): f"r{index}" for index, slot in enumerate(job.hierarchy.readings)}
    return TargetFiles({"outline.txt": "\n".join(lines).encode()}, {"readings": readings})


@pytest.fixture
def outline(monkeypatch: pytest.MonkeyPatch) -> None:
    """The target, by the one line that it needs."""
    monkeypatch.setitem(TARGETS, "outline", ExportTarget(f"{__name__}:make_outline_files"))


@pytest.mark.usefixtures("outline")
def test_a_target_is_a_function_and_a_line(tmp_path: Path) -> None:
    library, body = open_fixture()
    result = export_automaton(library, "goto", tmp_path, to="outline", body=body, binding={"A": "station"})
    assert (
        tmp_path / "outline.txt"
    ).read_text() == "goto(station): start, forward, rotate_left, rotate_right, done"
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert manifest["target"] == "outline"
    assert manifest["files"] == ["conformance.csv", "outline.txt"]
    head, *rows = (tmp_path / "conformance.csv").read_text().splitlines()
    assert head == "starts,time,r0,r1,path,flags,basic,drive,turn,load,unload"
    assert len(rows) == result.ticks
    assert manifest["readings"][0]["identifier"] == "r0"


@pytest.mark.usefixtures("outline")
def test_commands_know_it(tmp_path: Path) -> None:
    arguments = ["export", "deposit", "--library", FIXTURE, "--out", tmp_path / "out", "--to"]
    assert list(run_json(*arguments, "outline")["files"]) == [
        "conformance.csv",
        "manifest.json",
        "outline.txt",
    ]
    refused = run(*arguments, "rust")
    assert "json, btcpp, ros2 and outline" in refused.stderr


@pytest.mark.usefixtures("outline")
def test_it_has_no_single_precision_unless_it_says_so(tmp_path: Path) -> None:
    library, body = open_fixture()
    with pytest.raises(SettingError, match="target outline: single precision is not offered"):
        export_automaton(library, "deposit", tmp_path, to="outline", body=body, single_precision=True)
