"""The page of the experiments, from what was published of them; with its figures.

After an experiment was published anew, bring the page up to date with: python -m tests.docs.experiments
"""

from __future__ import annotations

from collections.abc import Iterator
from textwrap import fill

from tests.docs.pages import ROOT

from understudy_lab import figures
from understudy_lab.results import StudyResult, find_published, load_published
from understudy_lab.study import FOLDERS, QUESTIONS, ResultTable, StudyFindings, find_experiment

PAGE = ROOT / "docs" / "experiments.md"
PICTURES = ROOT / "docs" / "pictures" / "experiments"
HEAD = """# The experiments

What the paper claims of the method, and what people ask of it, as experiments that anyone can run again:

```sh
understudy experiment list
understudy experiment forage --quick   # a small part, compared with what was published
understudy experiment forage           # the whole; goes on where it was cut off
make experiments                       # all of them, quick
```

All that is taught here is taught by scripted demonstrators through the session's public interface: they see what a
person sees on the screen, react a quarter of a second late, and press. The unit is always the taught automaton, never
the trial: numbers are medians over automata, with the smallest and the largest in brackets. No robot is judged where it
was taught. How each is done is told in the README beside its code in `src/understudy_lab`. This page is
written from the published results (`python -m tests.docs.experiments`).
"""


def page() -> str:
    """The whole page."""
    results = [found for name in QUESTIONS if (found := load_published(name)) is not None]
    return "\n".join([HEAD, *(line for result in results for line in told(result))])


def told(result: StudyResult) -> Iterator[str]:
    """One experiment, line by line."""
    findings = result.findings
    yield f"## {result.experiment.capitalize()}\n"
    yield from wrapped(f"**{result.question}** {findings.headline}")
    yield f"![{result.experiment}](pictures/experiments/{result.experiment}.svg)\n"
    for table in findings.tables:
        yield from as_markdown(table)
    if findings.goals:
        yield from as_markdown(goals(findings))
    for note in findings.notes:
        yield from wrapped(note)
    where = f"../src/understudy_lab/{FOLDERS.get(result.experiment, result.experiment)}"
    kept = find_published(result.experiment)
    assert kept is not None
    yield f"[How it is done]({where}/README.md),\n[all rows]({where}/{kept.name})\n"


def wrapped(text: str) -> Iterator[str]:
    """A paragraph in lines of readable length."""
    yield from (*fill(text, 118, break_on_hyphens=False).splitlines(), "")


def goals(findings: StudyFindings) -> ResultTable:
    """What was to be reached, as a table."""
    rows = [(each.what, each.wanted, each.measured, "" if each.held else "short") for each in findings.goals]
    return ResultTable("What it was to reach", ("goal", "#wanted", "#measured", ""), rows)


def as_markdown(table: ResultTable) -> Iterator[str]:
    """A table in Markdown."""
    names = [name.lstrip("#~") for name in table.columns]
    yield from wrapped(f"{table.title}:" if table.title else "")
    yield f"| {' | '.join(names)} |"
    yield f"|{'|'.join('---:' if name.startswith('#') else '---' for name in table.columns)}|"
    yield from (f"| {' | '.join(row)} |" for row in table.rows)
    yield ""


def main() -> None:
    """Write the page and its figures."""
    PAGE.write_text(page(), encoding="utf-8")
    for name in QUESTIONS:
        if (found := load_published(name)) is not None:
            figures.save(find_experiment(name).draw(found.rows), PICTURES / f"{name}.svg")


if __name__ == "__main__":
    main()
