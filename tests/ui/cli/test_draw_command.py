"""The command `draw`: pictures in every form, nothing overwritten, and mistakes in a sentence."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from PIL import Image
from tests.ui.cli.commands import run, run_json
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT
from understudy.ui.cli.commands.show import list_automata_below
from understudy.viz.automaton_file import ENDINGS

LEVELS = ["forage", "harvest", "deposit", "goto"]


def draw(library: Path, *arguments: object) -> tuple[int, str]:
    done = run("draw", *arguments, "-l", library)
    return done.exit_code, " ".join(done.output.split())


def svg_texts(path: Path) -> list[str]:
    root = ElementTree.parse(path).getroot()
    return ["".join(node.itertext()) for node in root.iter("{http://www.w3.org/2000/svg}text")]


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_picture_of_each_kind(library: Path, tmp_path: Path, ending: str) -> None:
    out = tmp_path / f"goto{ending}"
    assert draw(library, "goto", "-o", out) == (0, f"Drawn in {out}")
    begin = {".svg": b"<svg", ".pdf": b"%PDF", ".png": b"\x89PNG", ".dot": b'digraph "goto(A)"'}[ending]
    first = out.read_bytes()
    assert first.startswith(begin)
    again = tmp_path / f"again{ending.upper()}"
    draw(library, "goto", "-o", again)
    assert again.read_bytes() == first


def test_a_png_is_fit_for_print(library: Path, tmp_path: Path) -> None:
    draw(library, "goto", "-o", tmp_path / "goto.png")
    with Image.open(tmp_path / "goto.png") as image:
        assert image.width > 1200


@pytest.mark.parametrize(("option", "names"), [([], LEVELS[:1]), (["--children"], LEVELS)])
def test_levels(library: Path, tmp_path: Path, option: list[str], names: list[str]) -> None:
    out = tmp_path / "forage.svg"
    told = run_json("draw", "forage", "-o", out, "-l", library, *option)
    assert told == {"name": "forage", "file": str(out), "automata": names, "bytes": out.stat().st_size}
    titles = [text for text in svg_texts(out) if re.fullmatch(r"\d states.*", text)]
    assert len(titles) == len(names)
    assert ("goto(A)" in svg_texts(out)) == (len(names) > 1)


def test_levels_of_an_automaton_that_is_used_twice_are_listed_once() -> None:
    library = Library.from_automata(FORAGE_KIT, *AUTOMATA)
    assert list_automata_below(library, "forage") == LEVELS
    assert list_automata_below(library, "goto") == ["goto"]


def test_text_for_graphviz(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "forage.dot"
    draw(library, "forage", "--children", "-o", out)
    text = out.read_text(encoding="utf-8")
    assert text.count("{") == text.count("}") == 1 + len(LEVELS)
    assert re.findall(r"label=\"([^\"]*)\";", text) == ["forage", "harvest", "deposit", "goto(A)"]
    known = set(re.findall(r"^ +(\w+) \[", text, re.MULTILINE)) - {"node", "edge"}
    used = {end for pair in re.findall(r"(\w+) -> (\w+)", text) for end in pair}
    assert used <= known
    assert len(re.findall("style=dotted", text)) == 4  # forage runs two automata, each of which runs goto
    assert all(line.endswith((";", "{", "}")) for line in text.splitlines())


def test_an_existing_file_is_kept(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "goto.svg"
    out.write_text("mine")
    code, told = draw(library, "goto", "-o", out)
    assert code == 2
    assert (
        told == f"Error: {out}: this file exists already; name another file, or give --force to overwrite it"
    )
    assert out.read_text() == "mine"
    assert draw(library, "goto", "-o", out, "--force")[0] == 0
    assert out.read_text().startswith("<svg")


MISTAKES = [
    (
        ["goto", "-o", "goto.gif"],
        "--out: 'goto.gif' is not a picture; name a file that ends in .svg, .pdf or .png",
    ),
    (["goto", "-o", "goto"], "--out: 'goto' is not a picture"),
    (["gota", "-o", "goto.svg"], "the library has no automaton 'gota'; did you mean 'goto'?"),
    (["goto", "-o", "no/such/goto.svg"], "no/such/goto.svg: writing the picture failed: No such file"),
]


@pytest.mark.parametrize(("arguments", "problem"), MISTAKES)
def test_mistakes(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], problem: str
) -> None:
    monkeypatch.chdir(tmp_path)
    code, told = draw(library, *arguments)
    assert code == 2
    assert told.startswith(f"Error: {problem}")
    assert [path.name for path in tmp_path.iterdir()] == ["library"]
