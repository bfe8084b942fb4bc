"""Packages that extend Understudy, installed for a test as an editable install does, without network."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path

import pytest

PLUGIN = Path(__file__).parents[1] / "fixtures" / "plugin"
"""The project of the package `orchard`, which uses every extension point."""


def install_project(project: Path, site: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Install the package of a project: its folder is put on the path, and its entry points are listed."""
    about = tomllib.loads((project / "pyproject.toml").read_text("utf-8"))["project"]
    install_entry_points(about["name"], about["entry-points"], site, monkeypatch)
    monkeypatch.syspath_prepend(project)


def install_entry_points(
    name: str, groups: Mapping[str, Mapping[str, str]], site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Write what an installer writes for a package, into a folder that is put on the path."""
    folder = site / f"{name}-1.0.dist-info"
    folder.mkdir(parents=True)
    (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", "utf-8")
    lines = [
        line
        for group, entries in groups.items()
        for line in (f"[{group}]", *(f"{entry} = {place}" for entry, place in entries.items()), "")
    ]
    (folder / "entry_points.txt").write_text("\n".join(lines), "utf-8")
    monkeypatch.syspath_prepend(site)
