"""Minari reads what was written: values, states of all levels, commands, presses."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from tests.make.records import KINDS, draw_records, make_record, without_commands

from understudy.addons.bridges.datasets.demonstrations import list_commands
from understudy.addons.bridges.datasets.minari import write_minari
from understudy.errors import DefinitionError, FileError, SettingError
from understudy.extras import ExtraMissing
from understudy.records.record import Record, RecordedPress

minari: Any = pytest.importorskip("minari", reason="needs Minari: pip install 'minari[hdf5]'")


def load(folder: Path) -> Any:
    return minari.MinariDataset(folder / "data")


def check(data: Any, episodes: Sequence[Record]) -> None:
    """Everything of the episodes is in the data set, but for the commands of their last ticks."""
    metadata = data.storage.metadata
    abouts = list(data.storage.get_episode_metadata(range(len(episodes))))
    for episode, got, about in zip(episodes, data, abouts, strict=True):
        steps = episode.ticks - 1
        assert got.observations.dtype == np.float64
        for place, label in enumerate(metadata["readings"]):
            np.testing.assert_array_equal(got.observations[:, place], episode.columns[label])
        for place, channel in enumerate(metadata["channels"]):
            np.testing.assert_array_equal(got.actions[:, place], list_commands(episode)[channel][:steps])
        for place, name in enumerate(metadata["pose"]):
            np.testing.assert_array_equal(got.infos["pose"][:, place], episode.pose[name])
        np.testing.assert_array_equal(got.infos["time"], episode.times)
        assert read_states(got.infos, metadata["state_labels"]) == episode.states
        subtasks = [metadata["subtask_labels"][number] for number in got.infos["subtask"]]
        assert subtasks == [" > ".join(path) for path in episode.states]
        pressed = {press.tick for press in episode.presses}
        assert got.infos["press"].tolist() == [tick in pressed for tick in range(episode.ticks)]
        assert (got.rewards.tolist(), got.terminations.any()) == ([0.0] * steps, False)
        assert got.truncations.tolist() == [False] * (steps - 1) + [True]
        presses = [
            RecordedPress(each["tick"], each["state"], each["correction"], each["kind"])
            for each in json.loads(about["presses"])
        ]
        assert presses == list(episode.presses)
        assert (about["agent"], about["behavior"], about["source"]) == (
            episode.agent,
            episode.behavior,
            episode.source,
        )
        assert about.get("seed") == episode.seed


def read_states(infos: dict[str, Any], labels: Sequence[Sequence[str]]) -> tuple[tuple[str, ...], ...]:
    columns = [infos[f"state_{level}"] for level in range(len(labels))]
    return tuple(
        tuple(labels[level][number] for level, number in enumerate(row) if number >= 0)
        for row in np.stack(columns, axis=1)
    )


@given(draw_records(ticks=2))
@settings(deadline=None, max_examples=40)
def test_nothing_else_is_lost(episodes: list[Record]) -> None:
    with TemporaryDirectory() as folder:
        write_minari(episodes, Path(folder) / "new-v0")
        check(load(Path(folder) / "new-v0"), episodes)


def test_minari_finds_it_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    episodes = [make_record(), make_record(seed=None, agent="robot 1")]
    write_minari(episodes, tmp_path / "warehouse/forage-v1", dataset_id="warehouse/forage-v1")
    write_minari(episodes, tmp_path / "forage-v0")
    assert list(minari.list_local_datasets(compatible_minari_version=True)) == [
        "forage-v0",
        "warehouse/forage-v1",
    ]
    data = minari.load_dataset("warehouse/forage-v1")
    assert (data.total_episodes, data.total_steps, data.spec.namespace) == (2, 4, "warehouse")
    assert [len(episode) for episode in data.sample_episodes(2)] == [2, 2]
    assert len(data.filter_episodes(lambda episode: bool(episode.infos["press"].any()))) == 2
    check(data, episodes)


def test_spaces_are_those_of_the_kinds(tmp_path: Path) -> None:
    write_minari([make_record()], tmp_path / "new-v0")
    data = load(tmp_path / "new-v0")
    assert data.observation_space.low.tolist() == [-np.inf, 0, 0]
    assert data.observation_space.high.tolist() == [np.inf, 2 * np.pi, 1]
    assert (data.action_space.shape, str(data.action_space.dtype)) == ((2,), "float64")
    assert data.storage.metadata["kinds"] == [str(kind) for kind in KINDS.values()]
    assert data.storage.metadata["tick_s"] == 0.05


def test_without_commands_the_actions_are_states(tmp_path: Path) -> None:
    episodes = [without_commands(pose={"x": np.arange(3.0), "y": np.ones(3)}), without_commands()]
    episodes[1] = without_commands(pose=episodes[0].pose, presses=())
    write_minari(episodes, tmp_path / "new-v0")
    data = load(tmp_path / "new-v0")
    assert data.action_space.n == 2
    assert data[0].actions.tolist() == [0, 0]
    assert all(data.action_space.contains(action) for action in data[0].actions)
    check(data, episodes)


def test_many_presses_are_kept(tmp_path: Path) -> None:
    presses = tuple(RecordedPress(number, f"state {number}") for number in range(2000))  # 100 kB
    times = np.arange(2000.0)
    episode = make_record(
        presses=presses,
        times=times,
        states=(("go",),) * 2000,
        readings={"x": times},
        commands={"drive": times},
    )
    write_minari([episode], tmp_path / "new-v0")
    check(load(tmp_path / "new-v0"), [episode])


@pytest.mark.parametrize(
    ("folder", "dataset_id", "message"),
    [
        ("forage", "", "its name is 'forage'; use letters, digits, - and _, with a version at the end"),
        ("a b-v0", "", "its name is 'a b-v0'; use letters"),
        (
            "forage-v0",
            "home/forage-v0",
            "'home/forage-v0', and its folder .*; name a folder that ends in home/",
        ),
    ],
)
def test_names_are_those_that_minari_finds(
    folder: str, dataset_id: str, message: str, tmp_path: Path
) -> None:
    with pytest.raises(SettingError, match=message):
        write_minari([make_record()], tmp_path / folder, dataset_id=dataset_id)
    assert not list(tmp_path.iterdir())


def test_mistakes_leave_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    short = make_record(
        times=np.zeros(1), states=(("fetch",),), readings={"carrying": np.zeros(1)}, commands={}, presses=()
    )
    with pytest.raises(
        DefinitionError, match=r"episode 0 \(robot 0 of run.jsonl\): it has one tick, and a step"
    ):
        write_minari([short], tmp_path / "new-v0")
    with pytest.raises(DefinitionError, match="there is no episode"):
        write_minari([], tmp_path / "new-v0")
    (tmp_path / "there-v0").mkdir()
    with pytest.raises(FileError, match="already exists"):
        write_minari([make_record()], tmp_path / "there-v0")
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(ExtraMissing, match=r"a Minari data set needs .*\[minari\]"):
        write_minari([make_record()], tmp_path / "new-v0")
    assert [path.name for path in tmp_path.iterdir()] == ["there-v0"]
