"""The file of properties: what it can say, and how it is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from understudy.errors import FileError
from understudy.judging.properties.property_file import load_properties
from understudy.model.property import PropertyKind, SeededWorlds

HEAD = 'understudy = "properties"\nversion = 1\n'
WHO = 'behavior = "forage"\nworld = "forage"\nseeds = 3\n'


def write(folder: Path, text: str) -> Path:
    path = folder / "properties.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_one_of_each_kind(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").touch()
    text = f"""{HEAD}
[clear]
behavior = "forage"
world = "mine.toml"
seeds = {{ first = 1000, count = 2 }}
limit_s = 60
never = "distance(robot, food) is below 0.1 m"
[delivers]
{WHO}always = "goal"
within_s = 600
at_least = 0.99
targets = {{ A = "station" }}
[moves]
behavior = "forage"
world = "forage"
seeds = [5, 3]
never_longer_than_s = 20
while = "food_stored is below 1 units"
[advances]
{WHO}never_longer_than_s = 30
without = "progress"
"""
    clear, delivers, moves, advances = load_properties(write(tmp_path, text))
    assert clear.start == SeededWorlds(str(tmp_path / "mine.toml"), (1000, 1001), 60.0)
    assert (clear.kind, clear.what, clear.name) == (
        PropertyKind.NEVER,
        "distance(robot, food) is below 0.1 m",
        "clear",
    )
    assert (delivers.what, delivers.seconds, delivers.at_least) == ("goal is reached", 600.0, 0.99)
    assert dict(delivers.targets) == {"A": "station"}
    assert moves.start == SeededWorlds("forage", (5, 3))
    assert [each.claim for each in (clear, delivers, moves, advances)] == [
        "never distance(robot, food) is below 0.1 m",
        "goal is reached within 600 s",
        "never longer than 20 s: food_stored is below 1 units",
        "never longer than 30 s without progress",
    ]


REFUSED = [  # what stands below the head, what is said after the path
    ("[a]\n" + WHO, "at a.never: is missing; give one of never, always and never_longer_than_s"),
    (f'[a]\n{WHO}never = "x is yes"\nalways = "goal"\n', "at a.always: is there beside never"),
    (f'[a]\n{WHO}always = "goal"\n', "at a.within_s: is missing; give the time in s"),
    (
        f'[a]\n{WHO}never = "x is yes"\nwithin_s = 3\n',
        "at a.within_s: does not belong to never; leave it out",
    ),
    (f'[a]\n{WHO}always = "goal"\nwithin_s = -3\n', "at a.within_s: is -3; give seconds above 0"),
    (f'[a]\n{WHO}always = "goal"\nwithin_s = "3 s"\n', "at a.within_s: is a text in quotes; give a number"),
    (f"[a]\n{WHO}never_longer_than_s = 3\n", "at a.without: is missing; write without = 'progress'"),
    (f'[a]\n{WHO}never = "front < 2"\n', "at a.never: 'front < 2' cannot be understood; write it as"),
    (f'[a]\n{WHO}never = "x is yes"\nat_least = 1\n', "at a.at_least: is 1; give a share between 0 and 1"),
    ('[a]\nworld = "forage"\nseeds = 3\nnever = "x is yes"\n', "at a.behavior: is missing; give 'behavior'"),
    (f'[a]\n{WHO}nevr = "x is yes"\n', "at a.nevr: is not a key here; did you mean 'never'?"),
    (
        '[a]\nbehavior = "b"\nworld = "forage"\nseeds = 0\nnever = "x is yes"\n',
        "at a.seeds: are 0; give their number",
    ),
    (
        '[a]\nbehavior = "b"\nworld = "f"\nseeds = [1, 1]\nnever = "x is yes"\n',
        "at a.seeds: are not all different",
    ),
    (
        f'[a]\n{WHO}always = "x is above 3 m and below 2 m"\nwithin_s = 3\n',
        "at a.always: 'x is above 3 m and x is below 2 m' can never hold at once; join them by 'or'",
    ),
    (f'[a]\n{WHO}never = "x is below inf m"\n', "at a.never: 'x is below inf m' always holds, so that"),
    ("a = 3\n", "at a: is not a table; begin a property with [a]"),
    ("[a\n", "is not TOML"),
]


@pytest.mark.parametrize(("text", "said"), REFUSED)
def test_what_is_refused(text: str, said: str, tmp_path: Path) -> None:
    path = write(tmp_path, HEAD + text)
    with pytest.raises(FileError) as refused:
        load_properties(path)
    assert str(refused.value).startswith(str(path))
    assert said in str(refused.value)


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ("", "at understudy: is missing; let the file begin with"),
        (
            'understudy = "scenario"\nversion = 1\n',
            "at understudy: is 'scenario': this is not a file of properties",
        ),
        ('understudy = "properties"\n', "at version: is missing"),
        (
            'understudy = "properties"\nversion = 9\n',
            "reads properties up to version 1; use a newer Understudy",
        ),
    ],
)
def test_another_file(head: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(FileError) as refused:
        load_properties(write(tmp_path, head))
    assert said in str(refused.value)
