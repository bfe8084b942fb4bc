"""Names of the code as people read them; the page's tests read the same table."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from understudy.model.plain_names import format_names

TABLE = Path(__file__).parents[2] / "page" / "test" / "plain_names.json"
NAMES: list[tuple[str, str]] = json.loads(TABLE.read_text(encoding="utf-8"))


@pytest.mark.parametrize(("text", "read"), NAMES)
def test_a_name_is_read_as(text: str, read: str) -> None:
    assert format_names(text) == read
