"""The pages on keys of files say what the schemas say, and describe every key."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest
from tests.docs import library_keys, robot_keys
from tests.docs.renew import between
from tests.docs.schema_tables import Parts

from understudy.sim.scenario.squad_schema import StrictStruct
from understudy.storage import library_schema

PAGES = [
    pytest.param(module.PAGE, module.KEYS, module.make_tables(), module.__name__, id=module.PAGE.stem)
    for module in (library_keys, robot_keys)
]


@pytest.mark.parametrize(("page", "keys", "tables", "module"), PAGES)
def test_the_tables_are_those_of_the_schema(
    page: Path, keys: tuple[str, str], tables: str, module: str
) -> None:
    assert between(page, keys) == tables, f"bring the page up to date with: python -m {module}"


@pytest.mark.parametrize("parts", [library_keys.PARTS, robot_keys.PARTS])
def test_every_key_is_described_and_no_other(parts: Parts) -> None:
    for part, (_, rows) in parts.items():
        assert list(rows) == [field.encode_name for field in msgspec.structs.fields(part)]


def test_every_part_of_the_schema_is_described() -> None:
    abstract = {library_schema.DocStruct, library_schema.FormatVersion}
    documents = {
        each
        for each in vars(library_schema).values()
        if isinstance(each, type) and issubclass(each, msgspec.Struct)
    }
    assert set(library_keys.PARTS) == documents - abstract - {msgspec.Struct}
    robots = {
        each
        for each in StrictStruct.__subclasses__()
        if each.__module__.startswith("understudy.addons.robots.")
    }
    assert set(robot_keys.PARTS) == robots
