"""Writing one property into a library's file: all else stays as a person wrote it."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from understudy.errors import FileError
from understudy.judging.properties.edit_property_file import (
    remove_table,
    set_table,
    split_statements,
    write_property,
)
from understudy.judging.properties.property_file import HEAD, load_tables

TEXT = """\
# What our robots must never do.
understudy = "properties"
version = 1   # of the format

# --- safety ---

# Agreed on with the hall's owner.
[clear]
behavior = "forage"   # the whole of it
world = "forage"
seeds = [
  1, 2,   # the narrow ones
  3,
]
never = "robot is in pit"

# --- speed ---
[arrives]   # soon
behavior = "goto"
world = "forage"
seeds = 20
always = "done is raised"
within_s = 40   # measured: 31
[arrives.targets]
A = "station"   # not the food
# the last word
"""
CLEAR: dict[str, Any] = tomllib.loads(TEXT)["clear"]
ARRIVES: dict[str, Any] = tomllib.loads(TEXT)["arrives"]

EDITS: list[tuple[str, dict[str, Any] | None, list[tuple[str, str]]]] = [
    ("clear", CLEAR, []),
    ("clear", CLEAR | {"never": "robot is in field"}, [('"robot is in pit"', '"robot is in field"')]),
    (
        "clear",
        CLEAR | {"behavior": "goto", "at_least": 0.9},
        [('"forage"   # the whole', '"goto"  # the whole'), ('in pit"\n', 'in pit"\nat_least = 0.9\n')],
    ),
    ("clear", CLEAR | {"seeds": 9}, [("[\n  1, 2,   # the narrow ones\n  3,\n]", "9")]),
    ("arrives", ARRIVES | {"within_s": 50}, [("40   # measured", "50  # measured")]),
    (
        "arrives",
        ARRIVES | {"targets": {"A": "food"}},
        [
            ("measured: 31\n", 'measured: 31\ntargets = { A = "food" }\n'),
            ('[arrives.targets]\nA = "station"   # not', "# not"),
        ],
    ),
    (
        "arrives",
        {key: value for key, value in ARRIVES.items() if key not in ("always", "within_s")} | {"never": "x"},
        [
            ('always = "done is raised"\nwithin_s = 40   # m', "# m"),
            ("measured: 31\n", 'measured: 31\nnever = "x"\n'),
        ],
    ),
    ("clear", None, [(TEXT[TEXT.index("[clear]") : TEXT.index("\n# --- speed")], "")]),
    ("arrives", None, [(TEXT[TEXT.index("[arrives]") : TEXT.index("# the last")], "")]),
]
"""The table that is written or removed, and the only pieces of the text that differ then."""


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize(("name", "table", "pieces"), EDITS)
def test_only_what_was_changed_differs(
    tmp_path: Path, name: str, table: dict[str, Any] | None, pieces: list[tuple[str, str]], ends: str
) -> None:
    path = tmp_path / "properties.toml"
    path.write_bytes(TEXT.replace("\n", ends).encode())
    write_property(path, name, table)
    wanted = TEXT
    for before, after in pieces:
        assert wanted.count(before) == 1
        wanted = wanted.replace(before, after)
    assert path.read_bytes().decode() == wanted.replace("\n", ends)


def test_a_new_property_comes_last_and_makes_the_file(tmp_path: Path) -> None:
    path = tmp_path / "library" / "properties.toml"
    write_property(path, "is quick", CLEAR)
    assert path.read_text() == HEAD + (
        '\n["is quick"]\nbehavior = "forage"\nworld = "forage"\nseeds = [1, 2, 3]\nnever = "robot is in pit"\n'
    )
    assert load_tables(path) == {"is quick": CLEAR}


ODD = [
    HEAD + 'clear = { behavior = "forage" }\n',
    HEAD + 'clear.behavior = "forage"\n',
    HEAD + "clear = 3\n",
    'understudy = "something else"\n',
    "[clear\n",
]


@pytest.mark.parametrize("text", ODD)
def test_what_cannot_be_changed_safely_is_left_alone(tmp_path: Path, text: str) -> None:
    path = tmp_path / "properties.toml"
    path.write_text(text)
    with pytest.raises(FileError, match=r"properties\.toml"):
        write_property(path, "clear", CLEAR)
    assert path.read_text() == text


NAMES = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), min_size=1, max_size=8).filter(
    lambda name: name not in ("understudy", "version")
)
VALUES = st.one_of(
    st.text(max_size=30), st.integers(-9, 9), st.lists(st.integers(0, 9), max_size=3), st.booleans()
)
TABLES = st.dictionaries(NAMES, VALUES, min_size=1, max_size=4)


@given(st.dictionaries(NAMES, TABLES, max_size=4), NAMES, TABLES, TABLES)
def test_any_table_is_set_changed_and_removed(
    others: dict[str, Any], name: str, first: dict[str, Any], then: dict[str, Any]
) -> None:
    """Whatever tables and values there are, the others keep theirs, and removing takes back what was added."""
    others.pop(name, None)
    text = HEAD
    for each, table in others.items():
        text = set_table(text, each, table)
    head = tomllib.loads(HEAD)
    added = set_table(text, name, first)
    assert tomllib.loads(added) == head | others | {name: first}
    assert "".join(each.text for each in split_statements(added)) == added
    assert tomllib.loads(set_table(added, name, then)) == head | others | {name: then}
    assert remove_table(added, name) == text
