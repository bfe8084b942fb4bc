"""Files of scenarios: what is written is read again the same, and no bytes at all end in anything but one error."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from tests.sim.test_placement import scenarios
from tests.sim.test_validation import with_change

from understudy.errors import FileError, SettingError
from understudy.sim.scenario import files
from understudy.sim.scenario.files import (
    HEAD,
    format_scenario,
    list_builtin_scenarios,
    load_scenario,
    parse_scenario,
)
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario.toml_writer import format_toml
from understudy.sim.scenario.validation import check_scenario

BUILT_IN = {
    name: resources.files("understudy.sim").joinpath("scenarios", f"{name}.toml").read_bytes()
    for name in list_builtin_scenarios()
}
SMALL = HEAD + 'size = [5, 5]\n[types.a]\n[[robots]]\ntype = "a"\n'


def test_what_ships() -> None:
    assert list_builtin_scenarios() == (
        "arena", "boxes", "forage", "forage-team", "patrol", "regions", "rooms", "salvage", "soccer", "swarm",
    )  # fmt: skip
    for name in list_builtin_scenarios():
        scenario = load_scenario(name)
        assert scenario.name == name
        assert scenario.about
        assert all(target.doc for target in scenario.targets.values())


@pytest.mark.parametrize("name", list_builtin_scenarios())
def test_written_and_read_again_it_is_the_same(name: str) -> None:
    scenario = load_scenario(name)
    text = format_scenario(scenario)
    assert parse_scenario(text) == scenario
    assert format_scenario(parse_scenario(text)) == text
    assert text.startswith('understudy = "scenario"\nversion = 1\n')


@settings(max_examples=50)
@given(scenarios(), st.text(st.characters(exclude_categories=["Cs"]), max_size=20))
def test_any_scenario_is_the_same_again(scenario: Scenario, about: str) -> None:
    scenario = replace(scenario, about=about)
    try:
        check_scenario(scenario)
    except SettingError:
        return
    assert parse_scenario(format_scenario(scenario)) == scenario


TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=6)
KEYS = st.one_of(TEXTS, st.sampled_from(("types", "objects", "sensors", "behaviors", "goal", "kind", "*")))
SCALARS = st.one_of(st.booleans(), st.integers(-(2**63), 2**63 - 1), st.floats(allow_nan=False), TEXTS)
PLAIN = st.recursive(
    SCALARS,
    lambda inside: st.lists(inside, max_size=3) | st.dictionaries(KEYS, inside, max_size=3),
    max_leaves=12,
)
TABLES = st.dictionaries(KEYS, PLAIN, max_size=3)
OPENED = {
    "types": st.dictionaries(
        TEXTS, TABLES | st.fixed_dictionaries({"behaviors": TABLES, "sensors": st.lists(TABLES)})
    ),
    "targets": TABLES,
    "objects": st.lists(TABLES, max_size=3),
    "goal": TABLES,
}


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(st.fixed_dictionaries({}, optional={**OPENED, "size": PLAIN, "a b": PLAIN}))
def test_any_plain_values_are_the_same_again(document: dict[str, Any]) -> None:
    assert tomllib.loads(format_toml(document)) == document


def test_the_name_is_that_of_the_file_unless_it_says_another() -> None:
    assert parse_scenario(SMALL, "somewhere/my world.toml").name == "my world"
    assert parse_scenario(HEAD + 'name = "x"\n' + SMALL.removeprefix(HEAD), "y.toml").name == "x"
    assert parse_scenario(SMALL, "odd.name.toml").name == "scenario"


def test_a_file_is_loaded_by_its_path(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_bytes(b"\xef\xbb\xbf" + SMALL.replace("\n", "\r\n").encode())
    assert load_scenario(path) == load_scenario(str(path)) == parse_scenario(SMALL, "mine.toml")


WRONG = [  # content -> place, words
    (b"\xff", "line 1", "UTF-8"),
    (HEAD.encode() + b"about = '\xe4'", "line 3", "UTF-8"),
    (HEAD + "size = [1, 2", "line 3, column 13", "is not TOML"),
    (HEAD + "size == 3", "line 3, column 7", "is not TOML"),
    (HEAD + "size = 1\nsize = 2\n[types]", "line 4", "is not TOML"),
    ("a = " + "[" * 5000, "", "nested too deeply"),
    ("a = " + "9" * 5000, "line 1", "is not TOML"),
    ("", "understudy", "is missing"),
    ('understudy = "library"', "understudy", "is 'library': this is not a scenario file"),
    ('understudy = "scenario"', "version", "is missing"),
    ('understudy = "scenario"\nversion = true', "version", "is True"),
    ('understudy = "scenario"\nversion = 0', "version", "is 0"),
    ('understudy = "scenario"\nversion = 2', "version", "up to version 1"),
    (HEAD, "size", "is missing"),
    (SMALL + "[types.a.b]", "types.a.b", "is not a key here"),
    (SMALL + '[types."b c"]\nradius = "x"', "types.'b c'.radius", "give a number"),
    (SMALL.replace("[5, 5]", "[1979-05-27, 5]"), "size[0]", "give a number"),
]


@pytest.mark.parametrize(("content", "place", "words"), WRONG, ids=lambda each: str(each)[:50])
def test_files_that_are_none(content: str | bytes, place: str, words: str) -> None:
    with pytest.raises(FileError) as caught:
        parse_scenario(content, "bad.toml")
    assert caught.value.place.startswith(place)
    assert caught.value.path == "bad.toml"
    assert words in str(caught.value)


MISSING = [
    ("forrage", "did you mean 'forage'"),
    ("no such.toml", "'arena'"),
    ("a\0b", "cannot be read"),
    (".", "cannot"),
]


@pytest.mark.parametrize(("source", "words"), MISSING)
def test_what_cannot_be_read(source: str, words: str) -> None:
    with pytest.raises(FileError, match=words):
        load_scenario(source)


def test_older_files_are_brought_up_to_date(monkeypatch: pytest.MonkeyPatch) -> None:
    def to_second(document: dict[str, Any]) -> dict[str, Any]:
        return {("size" if key == "area" else key): value for key, value in document.items()}

    monkeypatch.setattr(files, "VERSION", 2)
    monkeypatch.setattr(files, "MIGRATIONS", {1: to_second})
    assert parse_scenario(SMALL.replace("size", "area")).size == (5, 5)


def read(content: str | bytes) -> None:
    """Either it is a scenario, or one error says what is wrong."""
    scenario: Scenario | FileError
    try:
        scenario = parse_scenario(content)
    except FileError as error:
        scenario = error
    if isinstance(scenario, FileError):
        assert scenario.problem
        assert scenario.remedy
        assert "\n" not in str(scenario)
    else:
        assert parse_scenario(format_scenario(scenario)) == scenario


PIECES = st.one_of(
    st.binary(max_size=4),
    st.sampled_from(
        (
            b"",
            b"\n",
            b"-1",
            b"nan",
            b"inf",
            b"1e400",
            b"0",
            b"'",
            b'"""',
            b"[[",
            b"]]",
            b"{",
            b"true",
            b"[1, 2]",
            b"=",
            b".",
        )
    ),
)


@st.composite
def broken_bytes(draw: st.DrawFn) -> bytes:
    """A built-in file with a few pieces cut out and others put there."""
    content = BUILT_IN[draw(st.sampled_from(sorted(BUILT_IN)))]
    for _ in range(draw(st.integers(1, 4))):
        begin = draw(st.integers(0, len(content)))
        end = min(len(content), begin + draw(st.integers(0, 12)))
        content = content[:begin] + draw(PIECES) + content[end:]
    return content


def places_in(value: Any, steps: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    """Where in plain values there is something."""
    parts: list[tuple[str | int, Any]] = []
    if isinstance(value, Mapping):
        parts = list(value.items())
    elif isinstance(value, list):
        parts = list(enumerate(value))
    return [steps, *(place for key, part in parts for place in places_in(part, (*steps, key)))]


ODD = st.one_of(
    st.sampled_from(
        (
            -1,
            0,
            1,
            2,
            1e9,
            -1e9,
            float("inf"),
            float("nan"),
            2**62,
            "",
            "food",
            "red",
            True,
            [],
            {},
            [1, 0],
            [[0, 0]],
        )
    ),
    st.lists(st.floats(), min_size=2, max_size=4),
    st.floats(),
    st.integers(-5, 50),
)


@st.composite
def broken_values(draw: st.DrawFn) -> str:
    """A built-in file with other values, or keys that are unknown."""
    document: Any = tomllib.loads(BUILT_IN[draw(st.sampled_from(sorted(BUILT_IN)))].decode())
    for _ in range(draw(st.integers(1, 3))):
        steps = draw(st.sampled_from(places_in(document)[1:]))
        if draw(st.booleans()) and isinstance(steps[-1], str):
            keys = st.sampled_from(
                ("near", "within", "at", "count", "presence", "color", "radius", "kind", "zzz")
            )
            steps = (*steps[:-1], draw(keys))
        document = with_change(document, steps, draw(ODD))
    return format_toml(document)


@settings(max_examples=300, suppress_health_check=[HealthCheck.too_slow])
@given(broken_bytes())
def test_no_bytes_end_in_anything_but_one_error(content: bytes) -> None:
    read(content)


@settings(max_examples=300, suppress_health_check=[HealthCheck.too_slow])
@given(broken_values())
def test_no_values_end_in_anything_but_one_error(content: str) -> None:
    read(content)


@pytest.mark.soak
@settings(max_examples=20_000, suppress_health_check=[HealthCheck.too_slow])
@given(broken_bytes() | broken_values())
def test_no_file_ends_in_anything_but_one_error(content: str | bytes) -> None:
    read(content)


def test_a_scenario_is_plain_data() -> None:
    """As snapshots and journals keep it."""
    scenario = load_scenario("patrol")
    assert msgspec.json.decode(msgspec.json.encode(scenario), type=Scenario) == scenario
