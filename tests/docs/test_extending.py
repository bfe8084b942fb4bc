"""The page on other packages lists the extension points as `understudy.spi` does."""

from __future__ import annotations

import pytest
from tests.docs.pages import ROOT, read

from understudy.spi import EXTENSION_POINTS, ExtensionPoint

PAGE = ROOT / "docs" / "extending.md"


@pytest.mark.parametrize("point", EXTENSION_POINTS, ids=lambda point: point.group)
def test_an_extension_point_is_listed(point: ExtensionPoint) -> None:
    group = point.group.removeprefix("understudy.")
    assert f"| `{group}` | {point.offers} | {point.used} | `{point.check}` |\n" in read(PAGE)
    assert f"`{point.contract}`" in point.offers
