"""The pictures of pages that draw some, drawn by the code of those pages: python -m tests.docs.figures."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from tests.docs.pages import ROOT

PAGES = (ROOT / "docs" / "figures.md", ROOT / "docs" / "tutorials" / "study.md")
PICTURES = ROOT / "docs" / "pictures" / "figures"
_PART = re.compile(
    r"^```python\n(.*?)^```$|^!\[[^\]]+\]\((?:\.\./)?pictures/figures/(\w+)\.svg\)$", re.DOTALL | re.MULTILINE
)
SVG = "{http://www.w3.org/2000/svg}"


def draw() -> Iterator[tuple[str, Any]]:
    """Each picture of the pages by its name, and the axes that the page's code left in `axes`."""
    import matplotlib as mpl
    from matplotlib import pyplot

    mpl.use("agg")
    for page in PAGES:
        names: dict[str, Any] = {"__name__": "docs", "print": lambda *_: None}
        for match in _PART.finditer(page.read_text(encoding="utf-8")):
            code, picture = match.groups()
            if picture is None:
                exec(compile(code, str(page), "exec"), names)
            else:
                yield picture, names["axes"]
                pyplot.close("all")


def write_svg(axes: Any) -> str:
    """A figure as the text of an SVG file: the same figure gives the same text."""
    import matplotlib as mpl

    from understudy.viz.axes import STYLE

    made = io.StringIO()
    with mpl.rc_context(STYLE):
        axes.figure.savefig(made, format="svg", metadata={"Date": None})
    return re.sub(r"[ \t]+$", "", made.getvalue(), flags=re.MULTILINE)


def list_texts(svg: str) -> list[str]:
    """All texts of an SVG file, in order."""
    return ["".join(node.itertext()).strip() for node in ElementTree.fromstring(svg).iter(f"{SVG}text")]


def main(folder: Path = PICTURES) -> None:
    """Draw all pictures again."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, axes in draw():
        (folder / f"{name}.svg").write_text(write_svg(axes), encoding="utf-8")


if __name__ == "__main__":
    main()
