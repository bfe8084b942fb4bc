"""The code of pages, run once for all tests, and the pictures that it draws: python -m tests.docs.figures."""

from __future__ import annotations

import io
import re
from contextlib import redirect_stdout
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

from tests.docs.pages import ROOT, read

PAGES = (ROOT / "docs" / "figures.md", ROOT / "docs" / "tutorials" / "study.md")
PICTURES = ROOT / "docs" / "pictures" / "figures"
_PART = re.compile(
    r"^```python\n(.*?)^```$|^!\[[^\]]+\]\((?:\.\./)?pictures/figures/(\w+)\.svg\)$", re.DOTALL | re.MULTILINE
)
SVG = "{http://www.w3.org/2000/svg}"


class PageRun(NamedTuple):
    """What the code of a page did: what each block printed, and its pictures by their names, as SVG."""

    printed: list[str]
    pictures: dict[str, str]


@cache
def run_page(page: Path) -> PageRun:
    """Run the code of a page from top to bottom; a picture is of the axes that the code before it left in `axes`."""
    text, names = read(page), dict[str, Any](__name__="docs")
    run = PageRun([], {})
    for match in _PART.finditer(text):
        code, picture = match.groups()
        if picture is None:
            above = "\n" * (
                text.count("\n", 0, match.start()) + 1
            )  # so that errors name the line of the page
            printed = io.StringIO()
            with redirect_stdout(printed):
                exec(compile(above + code, str(page), "exec"), names)
            run.printed.append(printed.getvalue())
        elif page in PAGES:
            from matplotlib import pyplot

            run.pictures[picture] = write_svg(names["axes"])
            pyplot.close("all")
    return run


def draw() -> dict[str, str]:
    """All pictures of the pages by their names, as SVG."""
    import matplotlib as mpl

    mpl.use("agg")
    return {name: svg for page in PAGES for name, svg in run_page(page).pictures.items()}


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
    for name, svg in draw().items():
        (folder / f"{name}.svg").write_text(svg, encoding="utf-8")


if __name__ == "__main__":
    main()
