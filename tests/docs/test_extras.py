"""Each page that needs an extra says at its head how to install it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from tests.docs.pages import PAGES, ROOT, read

from understudy.extras import format_install_command

NEEDS = {
    "camera": r"understudy robots color",
    "cluster": r"--cluster|submitit",
    "falsify": r"understudy falsify(-body)? (?!LIBRARY)",
    "frames": r"\bto_frame\(|backend=|understudy-robots\[frames\]",
    "gymnasium": r"\bGymnasiumBody\b",
    "minari": r"\bwrite_minari\b|--to minari",
    "mujoco": r"understudy robots simulate",
    "notebook": r"\bshow_session\b|jupyter lab",
    "parquet": r"\.parquet\b|write_lerobot",
    "pettingzoo": r"\bPettingZooBody\b",
    "ros2": r"understudy (robots|team) (check|run|studio|teach|agent|status|arm|push|merge|color)|learn \w+ \S+\.mcap"
    r"|--record \S+\.mcap|why \S+\.mcap|replay \S+\.mcap|\"\S+\.mcap\"",
    "sklearn": r"understudy-robots\[sklearn\]|RandomForest",
}
"""What a page does that needs an extra."""
ELSEWHERE = (
    "docs/decisions/",
    "docs/reference/",
    "docs/architecture.md",
    "docs/semantics.md",
    "docs/index.md",
    "docs/README.md",
    "README.md",
    "CHANGELOG.md",
)
"""Pages that list everything, or say why something is so."""
INSTALL = re.compile(r"pip install 'understudy-robots\[([a-z0-9,-]+)\]'")
HEAD = 1200
"""So many characters of a page are its head, if its second heading does not come before."""


def list_extras(page: Path) -> set[str]:
    """Return the extras that the head of a page names in a command to install them."""
    head = re.split(r"^## ", read(page), maxsplit=1, flags=re.MULTILINE)[0][:HEAD]
    return {extra for names in INSTALL.findall(head) for extra in names.split(",")}


def test_each_page_names_the_extras_that_it_needs() -> None:
    missing = []
    for page in PAGES:
        label = page.relative_to(ROOT).as_posix()
        if label.startswith("docs/") and not label.startswith(ELSEWHERE):
            needed = {extra for extra, sign in NEEDS.items() if re.search(sign, read(page))}
            missing += [f"{label}: {extra}" for extra in sorted(needed - list_extras(page))]
    assert not missing, "the head of a page names the extras that it needs:\n" + "\n".join(missing)


def test_pages_name_extras_that_there_are() -> None:
    known = tomllib.loads(read(ROOT / "pyproject.toml"))["project"]["optional-dependencies"].keys()
    assert NEEDS.keys() <= known
    named = {extra for page in PAGES for names in INSTALL.findall(read(page)) for extra in names.split(",")}
    assert named <= known
    assert INSTALL.fullmatch(format_install_command("ros2"))
