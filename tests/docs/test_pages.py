"""What the documents say is true: links lead somewhere, commands exist, code runs, and prints what is shown."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from tests.docs import command_line, figures, renew
from tests.docs.pages import PAGES, ROOT, Block, anchors, blocks, commands, links, read, strip_output
from tests.ui.cli.commands import run

from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy.ui.cli.main import make_command_line

HEADER = "state,next,kind"
"""How a table of examples begins; other tables are rows to predict."""

MADE = ("try/index.html",)
"""Files that `make docs` puts beside the documents; where it cannot, it leaves out the links, too."""
UNWELCOME = re.compile(r"https?://|pypi|/home/|/tmp/|/wor[k]/|/root/|\blocalhost\b", re.IGNORECASE)
"""No addresses, and no places on anybody's machine."""


def name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def test_links_lead_somewhere() -> None:
    assert len(PAGES) > 50
    found = []
    for page in PAGES:
        for link in links(page):
            where, _, anchor = link.partition("#")
            target = (page.parent / where) if where else page
            if where in MADE:
                continue
            if not target.exists():
                found.append(f"{name(page)}: {link} leads nowhere")
            elif anchor and anchor not in anchors(target.resolve()):
                found.append(f"{name(page)}: {link} names no heading")
    assert not found, "\n".join(found)


def test_no_unwelcome_words() -> None:
    found = [f"{name(page)}: {word}" for page in PAGES for word in UNWELCOME.findall(read(page))]
    assert not found, "addresses, and places on a machine:\n" + "\n".join(found)


def test_lines_are_short() -> None:
    """Pages are read in terminals, too; tables and pictures are as wide as they are."""
    wide = ("|", "<img", "![", "understudy ")
    found = [
        f"{name(page)}:{number}: {len(line)} characters"
        for page in PAGES
        for number, line in enumerate(read(page).splitlines(), 1)
        if len(line) > 122 and not line.startswith(wide)
    ]
    assert not found, "lines of more than 122 characters:\n" + "\n".join(found)


def test_the_index_names_every_page() -> None:
    index = ROOT / "docs" / "README.md"
    pages = {page.relative_to(index.parent).as_posix() for page in PAGES if index.parent in page.parents}
    of_decisions = {
        page for page in pages if page.startswith("decisions/0")
    }  # they have an index of their own
    assert pages - of_decisions - {"README.md", "index.md"} <= set(links(index))


def test_the_reference_of_the_command_line_is_up_to_date() -> None:
    """If not: python -m tests.docs.command_line."""
    assert command_line.PAGE.read_text(encoding="utf-8") == command_line.make_page()


def test_commands_parse() -> None:
    """Every command that is named is there, and takes the options it is shown with."""
    shown = sorted({(command, name(page)) for page in PAGES for command in commands(page)})
    assert len(shown) > 200
    command_line = typer.main.get_command(make_command_line())
    found = [
        f"{page}: {command}: {fault}"
        for command, page in shown
        for fault in find_faults(command_line, command)
    ]
    assert not found, "commands that cannot be run:\n" + "\n".join(found)


def find_faults(command_line: Any, command: str) -> Iterator[str]:
    """Say what is wrong with a command that a page shows."""
    _, *words = command.split()
    found = command_line
    while words and hasattr(found, "commands"):
        if words[0].startswith("-"):  # such an option acts at once
            if not any(words[0] in each.opts for each in found.params):
                yield f"understudy has no option {words[0]}"
            return
        if words[0] not in found.commands:
            yield f"understudy has no command {words[0]}"
            return
        found = found.commands[words.pop(0)]
    takes_more = hasattr(found, "commands") or any(parameter.required for parameter in found.params)
    if words or not takes_more:  # `understudy show` alone just names the command
        try:
            found.make_context(found.name, [word.replace("…", "x") for word in words])
        except Exception as error:  # which class refuses an option depends on the version of Typer
            yield str(error) or repr(error)


ONCE = pytest.mark.xdist_group("drawing pages")  # the code of these pages runs once
MARKS = {
    "docs/gymnasium.md": pytest.mark.long,  # it evaluates in 60 worlds that step in Python, one after another
    **{name(page): ONCE for page in figures.PAGES},
}
WITH_PYTHON = [
    pytest.param(page, marks=MARKS.get(name(page), ()), id=name(page))
    for page in PAGES
    if any(block.language == "python" for block in blocks(page))
]


@pytest.mark.parametrize("page", WITH_PYTHON)
def test_python_runs_and_prints_what_is_shown(page: Path) -> None:
    found, printed = blocks(page), iter(figures.run_page(page).printed)
    for index, block in enumerate(found):
        if block.language != "python":
            continue
        lines = next(printed).splitlines()
        following = found[index + 1] if index + 1 < len(found) else None
        if following is not None and following.language == "text" and lines:
            assert strip_output(lines) == strip_output(following.text.splitlines())
    assert next(printed, None) is None


def lessons() -> list[Any]:
    """The tables of the page on learning: examples, rows to predict where there are any, what is printed."""
    found = blocks(ROOT / "docs" / "learning.md")
    cases = []
    for index, block in enumerate(found):
        if block.language == "csv" and block.text.startswith(HEADER):
            rows = found[index + 1] if found[index + 1].language == "csv" else None
            shown = found[index + 1 if rows is None else index + 2]
            cases.append(pytest.param(block, rows, shown, id=f"line {block.line}"))
    return cases


@pytest.mark.parametrize(("lesson", "rows", "shown"), lessons())
def test_lessons_learn_what_is_shown(
    lesson: Block, rows: Block | None, shown: Block, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lesson.csv").write_text(lesson.text, encoding="utf-8")
    arguments = ["learn", "lesson.csv"]
    if rows is not None:
        (tmp_path / "rows.csv").write_text(rows.text, encoding="utf-8")
        arguments += ["--predict", "rows.csv"]
    done = run(*arguments)
    assert done.exit_code == 0, done.output
    timeless = re.sub(r"(depth \d+), \S+ ms", r"\1", done.stdout)
    assert strip_output(timeless.splitlines()) == strip_output(shown.text.splitlines())


def test_five_presses_teach_what_the_readme_says() -> None:
    """All of the 40 worlds from 200 on."""
    lesson = new_lesson(
        Library(FORAGE_KIT),
        "goto",
        parameters=["A"],
        states=["rotate_left", "forward"],
        flags=["done"],
        features=["distance_to(A)", "angle_to(A)"],
        live=False,
    )
    session = Session(Forage([24]), Library(FORAGE_KIT), lesson, targets={"A": "station"})
    presses = [("rotate_left", 1.6), ("forward", 3.9), ("rotate_left", 2.4), ("forward", 0.3), ("done", 0.1)]
    for state, seconds in presses:
        session.direct(state)
        session.run_for(seconds)
    session.test()
    arrived = 0
    for world in range(200, 240):
        session.reset(world)
        session.run_for(60.0)
        view = session.view()
        arrived += view.state == "done" and view.features["distance_to(A)"] < 0.5
    assert arrived == 40
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert "In all of the 40 worlds 200 to 239" in readme
    assert all(f'("{state}", {seconds})' in readme for state, seconds in presses)


RENEW = "the results changed; bring the documents up to date with: python -m tests.docs.renew"


def test_published_results_are_those_shown() -> None:
    assert renew.between(renew.FORAGING, renew.RESULTS) == renew.tables(), RENEW


@pytest.mark.long
def test_the_demo_prints_what_the_readme_shows(tmp_path: Path) -> None:
    assert renew.between(renew.README, renew.DEMO) == renew.excerpt(renew.demo(tmp_path)), RENEW


def test_source_files_exist() -> None:
    """Files of the source are named from `src/understudy`, from `src`, or from the repository."""
    places = (ROOT / "src" / "understudy", ROOT / "src", ROOT)
    found = [
        f"{name(page)}: {path}"
        for page in PAGES
        for path in re.findall(r"`([\w./]+/[\w.]+\.(?:py|tsx?))\b", read(page))
        if not any((place / path).exists() for place in places)
    ]
    assert not found, "files that are not there:\n" + "\n".join(found)
