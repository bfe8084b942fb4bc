"""The notebook of the tutorial: the cells of the page, without outputs."""

import json

from tests.docs.pages import ROOT, blocks

TUTORIALS = ROOT / "docs" / "tutorials"


def test_the_notebook_has_the_code_of_its_page() -> None:
    cells = json.loads((TUTORIALS / "notebook.ipynb").read_text(encoding="utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    shown = [
        block.text.rstrip("\n") for block in blocks(TUTORIALS / "notebook.md") if block.language == "ipython"
    ]
    assert code == shown


def test_the_notebook_has_no_outputs() -> None:
    cells = json.loads((TUTORIALS / "notebook.ipynb").read_text(encoding="utf-8"))["cells"]
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in cells if "outputs" in cell)
