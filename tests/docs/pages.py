"""The pages of the documentation, taken apart: blocks of code, links, commands."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
MADE = ("api", "studies")
"""Folders of the reference that the site's build makes."""
PAGES = (
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md")),
    *sorted(page for page in (ROOT / "docs").rglob("*.md") if page.parent.name not in MADE),
)

_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_LINK = re.compile(r"\]\(([^)]+)\)|(?:src|href)=\"([^\"]+)\"")
_SPAN = re.compile(r"(?<!`)`([^`]+)`(?!`)")


class Block(NamedTuple):
    """A fenced block: its language, its text, the line it begins on."""

    language: str
    text: str
    line: int


@cache
def read(page: Path) -> str:
    """The text of a page."""
    return page.read_text(encoding="utf-8")


@cache
def blocks(page: Path) -> tuple[Block, ...]:
    """The fenced blocks of a page, in order."""
    text = read(page)
    return tuple(
        Block(match[1], match[2], text.count("\n", 0, match.start()) + 2) for match in _BLOCK.finditer(text)
    )


@cache
def outside_blocks(page: Path) -> str:
    """A page without its fenced blocks."""
    return _BLOCK.sub("", read(page))


def links(page: Path) -> list[str]:
    """Where a page leads to."""
    return [markdown or html for markdown, html in _LINK.findall(outside_blocks(page))]


@cache
def anchors(page: Path) -> set[str]:
    """The headings of a page as links name them."""
    titles = re.findall(r"^#+ (.+)$", outside_blocks(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def commands(page: Path) -> Iterator[str]:
    """Every `understudy …` that a page tells its reader to run."""
    for span in _SPAN.findall(outside_blocks(page)):
        if span.startswith("understudy "):
            yield " ".join(span.split())
    for block in blocks(page):
        if block.language == "sh":
            for line in block.text.splitlines():
                if line.startswith("understudy "):
                    yield re.split("[#>]", line)[0].strip()


def strip_output(lines: Sequence[str]) -> list[str]:
    """Printed lines as documents show them: no empty ones, no rules, no blanks at the end."""
    return [line.rstrip() for line in lines if line.strip() and "─" not in line]
