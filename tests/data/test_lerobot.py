"""LeRobot reads what was written: values, states of all levels, commands, presses."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from itertools import accumulate
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from tests.make.records import draw_records, make_record, without_commands

from understudy.addons.bridges.datasets.demonstrations import list_commands
from understudy.addons.bridges.datasets.lerobot import Subtasks, write_lerobot
from understudy.errors import DefinitionError, FileError, SettingError
from understudy.extras import ExtraMissing
from understudy.records.record import Record

duckdb: Any = pytest.importorskip("duckdb", reason="needs the extra parquet")

ROOT = Path(__file__).parents[2]
LEROBOT = ROOT / "build" / "lerobot" / "bin" / "python"


def read_rows(path: Path) -> list[dict[str, Any]]:
    with duckdb.connect() as database:
        found = database.execute("SELECT * FROM read_parquet(?)", [str(path)])
        titles = [column[0] for column in found.description]
        return [dict(zip(titles, row, strict=True)) for row in found.fetchall()]


def read_frames(folder: Path) -> list[dict[str, Any]]:
    return [row for path in sorted(folder.glob("data/*/*.parquet")) for row in read_rows(path)]


def read_json(path: Path) -> Any:
    return json.loads(path.read_text())


def same(got: Any, expected: Any) -> None:
    """The same numbers, with NaN for what is absent: LeRobot cannot load NULL."""
    assert None not in list(got)
    np.testing.assert_array_equal(np.asarray(got, dtype=np.float64), np.asarray(expected, dtype=np.float64))


def check_frames(
    frames: Sequence[dict[str, Any]], features: dict[str, Any], episodes: Sequence[Record]
) -> None:
    """Everything of the episodes is in the frames."""
    ends = list(accumulate((episode.ticks for episode in episodes), initial=0))
    for number, episode in enumerate(episodes):
        own = frames[ends[number] : ends[number + 1]]
        assert [frame["episode_index"] for frame in own] == [number] * episode.ticks
        assert [frame["frame_index"] for frame in own] == list(range(episode.ticks))
        assert [frame["index"] for frame in own] == list(range(ends[number], ends[number + 1]))
        same([frame["time"] for frame in own], episode.times)
        for column, values in (
            ("observation.state", episode.columns),
            ("action", list_commands(episode)),
        ):
            names = features[column]["names"]
            listed = [frame[column] if len(names) > 1 else [frame[column]] for frame in own]
            assert not any(None in each for each in listed)
            got = np.array(listed, dtype=np.float64)
            for place, name in enumerate(names):
                if values:
                    same(got[:, place], values[name])
                else:
                    assert got[:, place].tolist() == [float(path[:1] == (name,)) for path in episode.states]
        assert tuple(read_states(frame, features) for frame in own) == episode.states
        pressed = {press.tick for press in episode.presses}
        assert [frame["press"] for frame in own] == [tick in pressed for tick in range(episode.ticks)]


def read_states(frame: dict[str, Any], features: dict[str, Any]) -> tuple[str, ...]:
    levels = [name for name in features if name.startswith("state_")]
    return tuple(features[level]["info"]["labels"][frame[level]] for level in levels if frame[level] >= 0)


def check_episodes(rows: Sequence[dict[str, Any]], episodes: Sequence[Record]) -> None:
    start = 0
    for number, (row, episode) in enumerate(zip(rows, episodes, strict=True)):
        assert (row["episode_index"], row["length"]) == (number, episode.ticks)
        assert (row["dataset_from_index"], row["dataset_to_index"]) == (start, start + episode.ticks)
        assert row["agent"] == episode.agent
        assert (row["behavior"], row["source"], row["seed"]) == (
            episode.behavior,
            episode.source,
            episode.seed,
        )
        presses = [(each["tick"], each["state"], each["correction"], each["kind"]) for each in row["presses"]]
        assert presses == [(each.tick, each.state, each.correction, each.kind) for each in episode.presses]
        start += episode.ticks


@pytest.mark.long
@given(draw_records())
@settings(deadline=None, max_examples=25)
def test_nothing_is_lost(episodes: list[Record]) -> None:
    with TemporaryDirectory() as folder:
        written = Path(folder) / "new"
        write_lerobot(episodes, written)
        info = read_json(written / "meta/info.json")
        check_frames(read_frames(written), info["features"], episodes)
        check_episodes(read_rows(written / "meta/episodes/chunk-000/file-000.parquet"), episodes)
        assert read_json(written / "meta/stats.json").keys() == info["features"].keys()
        assert info["fps"] * episodes[0].tick_s == pytest.approx(1)


def test_the_format_is_that_of_lerobot(tmp_path: Path) -> None:
    write_lerobot([make_record(), make_record()], tmp_path / "new")
    info = read_json(tmp_path / "new/meta/info.json")
    assert (info["codebase_version"], info["fps"]) == ("v3.0", 20)
    assert (info["total_episodes"], info["total_frames"], info["total_tasks"]) == (2, 6, 1)
    assert info["splits"] == {"train": "0:2"}
    assert info["features"]["observation.state"]["names"] == [
        "distance(station)",
        "bearing(station)",
        "carrying",
    ]
    frames = read_frames(tmp_path / "new")
    assert [frame["timestamp"] for frame in frames[3:]] == pytest.approx([0, 0.05, 0.1])
    assert [frame["subtask_index"] for frame in frames[:3]] == [0, 1, 2]
    subtasks = read_rows(tmp_path / "new/meta/subtasks.parquet")
    assert [each["subtask"] for each in subtasks] == ["fetch > approach", "fetch > grasp", "deliver"]
    with duckdb.connect() as database:
        stored = "SELECT value FROM parquet_kv_metadata(?) WHERE key = 'pandas'"
        ((pandas,),) = database.execute(stored, [str(tmp_path / "new/meta/tasks.parquet")]).fetchall()
    assert json.loads(pandas)["index_columns"] == ["task"]


@pytest.mark.parametrize(
    ("task", "expected"), [("", ["forage", "demonstration"]), ("Get food.", ["Get food."])]
)
def test_tasks_are_named(task: str, expected: list[str], tmp_path: Path) -> None:
    write_lerobot([make_record(), make_record(behavior="")], tmp_path / "new", task=task)
    assert [each["task"] for each in read_rows(tmp_path / "new/meta/tasks.parquet")] == expected


def test_large_data_sets_have_several_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("understudy.addons.bridges.datasets.lerobot.FILES_PER_CHUNK", 2)
    monkeypatch.setattr("understudy.addons.bridges.datasets.lerobot.MEGABYTES_PER_FILE", 1e-9)
    episodes = [make_record(), make_record(), make_record()]
    write_lerobot(episodes, tmp_path / "new")
    names = [path.relative_to(tmp_path / "new").as_posix() for path in sorted(tmp_path.glob("new/data/*/*"))]
    assert names == [
        f"data/chunk-{place}.parquet" for place in ("000/file-000", "000/file-001", "001/file-000")
    ]
    check_frames(
        read_frames(tmp_path / "new"), read_json(tmp_path / "new/meta/info.json")["features"], episodes
    )
    rows = read_rows(tmp_path / "new/meta/episodes/chunk-000/file-000.parquet")
    assert [(row["data/chunk_index"], row["data/file_index"]) for row in rows] == [(0, 0), (0, 1), (1, 0)]


def test_mistakes_leave_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong: Any = "words"
    with pytest.raises(SettingError, match="subtasks is 'words'; choose index or language"):
        write_lerobot([make_record()], tmp_path / "new", subtasks=wrong)
    with pytest.raises(DefinitionError, match="there is no episode"):
        write_lerobot([], tmp_path / "new")
    (tmp_path / "there").write_text("")
    with pytest.raises(FileError, match="already exists"):
        write_lerobot([make_record()], tmp_path / "there")
    monkeypatch.setitem(sys.modules, "duckdb", None)
    with pytest.raises(ExtraMissing, match=r"a LeRobot data set needs .*\[parquet\]"):
        write_lerobot([make_record()], tmp_path / "new")
    assert [path.name for path in tmp_path.iterdir()] == ["there"]


WRITTEN: dict[str, tuple[list[Record], Subtasks]] = {
    "commands": (
        [make_record(), make_record(states=((), ("deliver",), ("deliver",)), agent="robot 1")],
        "index",
    ),
    "states": ([without_commands(tick_s=0.03, pose={"x": np.arange(3.0), "y": np.ones(3)})], "index"),
    "one reading": (
        [make_record(readings={"carrying": np.zeros(3)}, commands={"drive": np.ones(3)}, seed=None)] * 2,
        "index",
    ),
    "language": ([make_record(), without_commands(commands=list_commands(make_record()))], "language"),
}


@pytest.fixture(scope="module")
def read_by_lerobot(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What LeRobot gives for each of WRITTEN, and its version."""
    if not LEROBOT.exists():
        pytest.skip("needs LeRobot: make -f tools/lerobot.mk")
    folder = tmp_path_factory.mktemp("lerobot")
    version = subprocess.run(
        [LEROBOT, "-c", "from importlib.metadata import version; print(version('lerobot'))"],
        check=True, capture_output=True, text=True,
    ).stdout.strip()  # fmt: skip
    old = version.startswith(("0.4", "0.5"))
    names = [name for name, (_, subtasks) in WRITTEN.items() if subtasks == "index" or not old]
    for name in names:
        episodes, subtasks = WRITTEN[name]
        write_lerobot(episodes, folder / name, subtasks=subtasks)
    read = subprocess.run(
        [LEROBOT, ROOT / "tests/data/read_lerobot.py", *(folder / name for name in names)],
        env={**os.environ, "HF_HOME": str(folder / "cache")},
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    found = json.loads(read.stdout)
    return {"old": old, **dict(zip(names, found["datasets"], strict=True))}


@pytest.mark.long
@pytest.mark.parametrize("name", WRITTEN)
def test_lerobot_reads_it(name: str, read_by_lerobot: dict[str, Any]) -> None:
    if name not in read_by_lerobot:
        pytest.skip("LeRobot 0.6 was the first to read language")
    (episodes, subtasks), got = WRITTEN[name], read_by_lerobot[name]
    stored = [dict(zip(got["stored"], row, strict=True)) for row in zip(*got["stored"].values(), strict=True)]
    check_frames(stored, got["features"], episodes)
    check_episodes(got["episodes"], episodes)
    assert got["fps"] == pytest.approx(1 / episodes[0].tick_s)
    assert [frame["task"] for frame in got["frames"]] == ["forage"] * sum(each.ticks for each in episodes)
    assert got["types"]["observation.state"] == "torch.float32"
    described = [" > ".join(path) for episode in episodes for path in episode.states]
    if subtasks == "language":
        assert got["active"] == described
    elif read_by_lerobot["old"]:
        assert [frame["subtask"] for frame in got["frames"]] == described
    last = np.array([*episodes[-1].values.values()]).T.squeeze()
    window, padding = got["window"]
    np.testing.assert_allclose(window, last[[0, 0, 1]], rtol=1e-6)
    assert padding == [True, False, False]
    assert subtasks == "language" or got["batch"] == [len(stored), *last.shape[1:]]
