"""Templates of exported files, which are in the folder `templates` as files of their own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from string import Template

TEMPLATES = Path(__file__).parent / "templates"


def fill_template(name: str, values: Mapping[str, str]) -> bytes:
    """Fill in a template: `$name` and `${name}` stand for values, `$$` for a dollar sign."""
    return Template((TEMPLATES / name).read_text(encoding="utf-8")).substitute(values).encode()
