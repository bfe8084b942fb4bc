"""Episodes are gathered into one data set, or refused in one sentence that says which, and why."""

from __future__ import annotations

from math import nan
from pathlib import Path

import numpy as np
import pytest
from tests.make.records import KINDS, make_record, without_commands

from understudy.addons.bridges.datasets.demonstrations import gather_demonstrations
from understudy.addons.bridges.datasets.lerobot import summarize_columns
from understudy.addons.bridges.datasets.new_folder import create_folder
from understudy.errors import DefinitionError, FileError
from understudy.model.value_kinds import Continuous
from understudy.records.record import Record, RecordedPress

ONE = {"distance(station)": np.array([1.0, 2.0, 3.0])}
REFUSED: list[tuple[list[Record], str]] = [
    ([], "there is no episode; give at least one"),
    ([make_record(times=np.zeros(0), states=())], r"episode 0 \(robot 0 of run.jsonl\): it has no ticks"),
    ([make_record(tick_s=nan)], "its tick_s is nan; give the length of a tick in seconds"),
    ([make_record(readings={})], "its readings were not recorded; give episodes with readings"),
    ([make_record(times=np.zeros(2))], "states has 3 values for 2 ticks; give one value per tick"),
    ([make_record(presses=(RecordedPress(3, None),))], "a press is at tick 3; its ticks are 0 to 2"),
    ([without_commands(states=((),) * 3)], "no episode has commands or states; give episodes in which an"),
    (
        [make_record(), make_record(readings=ONE, source="")],
        r"episode 1 \(robot 0\): its readings are not those of the first episode: "
        r"it lacks bearing\(station\) and carrying; write a data set for each",
    ),
    (
        [make_record(), make_record(commands={"drive": np.zeros(3), "load": np.zeros(3)})],
        "its channels of commands are not those of the first episode: it lacks turn, and it adds load; write",
    ),
    ([make_record(), without_commands()], "its channels of commands .* it lacks drive and turn; write"),
    ([make_record(), make_record(pose={"x": np.zeros(3)})], "columns of the pose .* it adds x; write"),
    (
        [make_record(), make_record(kinds={**KINDS, "carrying": Continuous()})],
        r"carrying is continuous, and categorical\(no\|yes\) in the first episode; write",
    ),
    (
        [make_record(), make_record(tick_s=0.1)],
        "its ticks take 0.1 s, and those of the first .* 0.05 s; write",
    ),
]


@pytest.mark.parametrize(("episodes", "message"), REFUSED)
def test_what_one_data_set_cannot_hold_is_refused(episodes: list[Record], message: str) -> None:
    with pytest.raises(DefinitionError, match=message) as refused:
        gather_demonstrations(episodes)
    assert "\n" not in str(refused.value)


def test_columns_are_those_of_the_first_episode() -> None:
    first = make_record()
    second = make_record(readings=dict(reversed(list(first.columns.items()))))
    found = gather_demonstrations([first, second])
    assert found.readings == tuple(first.columns)
    np.testing.assert_array_equal(found.stack_readings(first), found.stack_readings(second))


def test_states_have_numbers_at_each_level() -> None:
    episode = make_record()
    found = gather_demonstrations([episode])
    assert found.levels == (("fetch", "deliver"), ("approach", "grasp"))
    assert found.subtasks == ("fetch > approach", "fetch > grasp", "deliver")
    assert found.index_states(episode, 0).tolist() == [0, 0, 1]
    assert found.index_states(episode, 1).tolist() == [0, 1, -1]
    assert found.index_subtasks(episode).tolist() == [0, 1, 2]
    assert found.mark_presses(episode).tolist() == [False, True, True]


def test_statistics_leave_out_what_is_absent() -> None:
    values = np.array([[nan, 1.0], [2.0, nan], [4.0, np.inf], [6.0, 3.0]])
    found = summarize_columns(values)
    assert found["count"] == [4]
    assert (found["min"], found["max"], found["mean"]) == ([2.0, 1.0], [6.0, 3.0], [4.0, 2.0])
    assert found["std"] == pytest.approx([np.std([2, 4, 6]), 1.0])
    assert found["q50"] == [4.0, 2.0]


def test_statistics_of_nothing_are_zero() -> None:
    assert set(map(tuple, list(summarize_columns(np.full(3, nan)).values())[1:])) == {(0.0,)}


def test_a_folder_that_exists_is_kept(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    with (
        pytest.raises(FileError, match="already exists; name a new folder"),
        create_folder(tmp_path / "there"),
    ):
        pass
    assert list(tmp_path.iterdir()) == [tmp_path / "there"]


def test_a_folder_is_complete_or_not_there(tmp_path: Path) -> None:
    def write_half() -> None:
        with create_folder(tmp_path / "new") as made:
            (made / "half").write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_half()
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_made_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with (
        pytest.raises(FileError, match="writing the data set failed"),
        create_folder(tmp_path / "file" / "new"),
    ):
        pass
