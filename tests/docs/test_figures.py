"""The pictures of the page on figures are those that its code draws: the same marks, with the same texts."""

from __future__ import annotations

from collections import Counter
from xml.etree import ElementTree

import pytest
from tests.docs import figures


def shapes(svg: str) -> Counter[str]:
    """How many elements of each kind a picture has."""
    return Counter(node.tag.removeprefix(figures.SVG) for node in ElementTree.fromstring(svg).iter())


@pytest.mark.long
@pytest.mark.xdist_group("drawing pages")  # their code runs once
def test_the_pictures_are_up_to_date() -> None:
    """If not: python -m tests.docs.figures."""
    drawn = figures.draw()
    kept = {path.stem: path.read_text(encoding="utf-8") for path in figures.PICTURES.glob("*.svg")}
    assert sorted(drawn) == sorted(kept)
    for name, svg in drawn.items():
        assert figures.list_texts(svg) == figures.list_texts(kept[name]), name
        assert shapes(svg) == shapes(kept[name]), name


def test_the_pictures_are_small() -> None:
    sizes = {path.name: path.stat().st_size for path in figures.PICTURES.glob("*.svg")}
    assert sizes
    assert not [name for name, size in sizes.items() if size > 120_000]
