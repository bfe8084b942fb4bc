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

Extra: `pip install 'understudy-robots[cluster]'`, only for jobs of Slurm.

Each experiment answers one question, about a claim of the paper or about something that users ask. Anyone can run them
again:

```sh
understudy experiment list
understudy experiment forage --quick   # a small part, compared with the published results
understudy experiment forage           # all of it; continues a run that was interrupted
make experiments                       # all experiments, quick versions
```

How to read the results:

- All demonstrators are scripted. They teach through the public interface of a session. They see what a person sees on
  the screen, press a quarter of a second late unless the experiment says otherwise, and use no other information.
- A *teaching* is one training of a whole behavior from nothing, with one seed. Statistics are over teachings or taught
  automata, not over single trials.
- Unless a table says otherwise, numbers are medians, with the smallest and the largest value in brackets.
- No robot is tested in a world in which it was taught. *Unseen worlds* are worlds that no lesson was taught in.
- *Hand-written* controllers and automata are the references: programs that know how the task is done.
- A goal that was not reached is marked *missed*.

The README of each experiment describes how it was done; it lies beside the code, in `src/understudy_lab`. This page is
generated from the published results (`python -m tests.docs.experiments`).

## On several computers

```sh
understudy experiment forage --part 2/8     # on each of 8 computers, with a common folder of results
understudy experiment forage --gather       # when all parts have ended
understudy experiment forage --cluster slurm --jobs 8 --cluster-option slurm_partition=cpu
```

Each part keeps its rows in a file of its own, so that job arrays, matrices of a CI and loops of a shell need nothing
else. A part that was killed goes on where it was. What is gathered is what one run would have written, byte for byte.
`--cluster` runs `--jobs` parts as jobs of Slurm (`local`: as processes of this computer) with the extra `cluster`, and
gathers them; a job that is preempted is queued again.
"""


def page() -> str:
    """The whole page."""
    results = [found for name in QUESTIONS if (found := load_published(name)) is not None]
    return "\n".join([HEAD, *(line for result in results for line in write_experiment(result))])


def write_experiment(result: StudyResult) -> Iterator[str]:
    """One experiment, line by line."""
    findings = result.findings
    yield f"## {result.experiment.capitalize()}\n"
    yield from wrap(f"**{result.question}** {findings.headline}")
    yield f"![{result.experiment}](pictures/experiments/{result.experiment}.svg)\n"
    for table in findings.tables:
        yield from as_markdown(table)
    if findings.goals:
        yield from as_markdown(goals(findings))
    for note in findings.notes:
        yield from wrap(note)
    where = f"../src/understudy_lab/{FOLDERS.get(result.experiment, result.experiment)}"
    kept = find_published(result.experiment)
    assert kept is not None
    yield f"[How it was done]({where}/README.md),\n[all results]({where}/{kept.name})\n"


def wrap(text: str) -> Iterator[str]:
    """A paragraph in lines of readable length."""
    yield from (*fill(text, 118, break_on_hyphens=False).splitlines(), "")


def goals(findings: StudyFindings) -> ResultTable:
    """What was to be reached, as a table."""
    rows = [(each.what, each.wanted, each.measured, "" if each.held else "missed") for each in findings.goals]
    return ResultTable("Goals", ("goal", "#wanted", "#measured", ""), rows)


def as_markdown(table: ResultTable) -> Iterator[str]:
    """A table in Markdown."""
    names = [name.lstrip("#~") for name in table.columns]
    yield from wrap(f"{table.title}:" if table.title else "")
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
