"""Failing worlds in folders: the scenario, the seed, why it fails, and a picture; they replay bit for bit.

The worlds of a folder are listed the worst first, and after each the one that differs most.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, nan
from pathlib import Path
from typing import Literal, TypeAlias

import msgspec

from understudy.addons.checks.falsification.failure_replay import ExplainedRun, draw_failure
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.errors import FileError, UnderstudyError
from understudy.sim.scenario.files import format_scenario, load_scenario
from understudy.storage.atomic_write import convert_os_errors, write_atomically
from understudy.storage.json_text import convert_decode_errors, format_json

RerunVerdict: TypeAlias = Literal["not run", "fails", "passes", "unknown"]

FORMAT, VERSION = "failing world", 1
SCENARIO_FILE, FACTS_FILE, PICTURE_FILE, WHY_FILE = "world.toml", "failure.json", "path.png", "why.txt"


class FailureFacts(msgspec.Struct, frozen=True, kw_only=True):
    """The facts about a failing world, as `failure.json` stores them.

    `wrong_s` is the time at which it went wrong, `robot` the robot that is explained, `end_hash` that of the world at
    the end of the run, and `limit_s` the time limit, s. `property` names the property of the library's file that
    failed; None if it was the goal. `place` is where the robot stood when it went wrong, m, and `states` are its states
    after the decision that explains it, outermost first; older folders lack both. `found_by` is the search that found
    it, and `steps` says how it was shrunk.
    """

    understudy: str = FORMAT
    version: int = VERSION
    behavior: str
    binding: dict[str, str]
    seed: int
    limit_s: float
    robustness: float
    wrong_s: float
    end_hash: str
    robot: int = 0
    property: str | None = None
    place: tuple[float, float] | None = None
    states: tuple[str, ...] = ()
    found_by: str
    steps: tuple[str, ...]
    why: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class FailingWorld:
    """A failing world in a folder, and how it went when it was run again, perhaps with a corrected library.

    Parameters
    ----------
    folder
        Its folder.
    trial
        The scenario, and the seed that lays it out.
    facts
        What was kept about it when it was found.
    robustness
        The distance from failing when it was run again, below 0 if it still fails; NaN if it was not, or could not be.
    problem
        Why it could not be run again; empty if it could, or was not.
    """

    folder: Path
    trial: Trial
    facts: FailureFacts
    robustness: float = nan
    problem: str = ""

    @property
    def summary(self) -> str:
        """A short description of the failure: its first sentence, and the states of the robot at that time."""
        went_wrong = self.facts.why[0] if self.facts.why else "It failed."
        doing = " > ".join(self.facts.states)
        return f"{went_wrong[:-1]}: {doing}." if doing else went_wrong

    @property
    def has_failed(self) -> bool:
        """True if it was run again, and still fails."""
        return self.robustness < 0

    @property
    def has_passed(self) -> bool:
        """True if it was run again, and no longer fails."""
        return self.robustness >= 0

    @property
    def verdict(self) -> RerunVerdict:
        """The result of running it again, "unknown" if it could not be run."""
        if self.problem:
            return "unknown"
        return "fails" if self.has_failed else "passes" if self.has_passed else "not run"

    def __str__(self) -> str:
        if self.problem:
            return f"{self.folder.name} could not be run: {self.problem}"
        result = {"fails": " still fails", "passes": " passes now"}.get(self.verdict, "")
        return f"{self.folder.name}{result}"


def choose_folder(parent: Path | str, behavior: str) -> Path:
    """Return the first folder in `parent` that does not exist yet: BEHAVIOR-1, BEHAVIOR-2 and so on."""
    number = 1
    while (folder := Path(parent) / f"{behavior}-{number}").exists():
        number += 1
    return folder


def write_failing_world(
    folder: Path | str, trial: Trial, facts: FailureFacts, replay: ExplainedRun, *, command: str
) -> FailingWorld:
    """Write a failing world to a new folder.

    Parameters
    ----------
    folder
        A folder that does not exist. FileError if it cannot be written.
    trial
        The scenario, as it is to be written, and the seed.
    facts
        What is known about it.
    replay
        The run, for the picture and the explanation.
    command
        The command that runs it again.

    Returns
    -------
    FailingWorld
        The failing world.
    """
    folder = Path(folder)
    title = f"{facts.behavior} fails in {trial.scenario.name}, seed {trial.seed}"
    picture = draw_failure(replay, title=title)
    why = [title, "", *facts.why, "", "Simpler than the world that was found:"]
    why += [f"- {step}" for step in facts.steps] or ["- nothing: no simpler world failed"]
    why += ["", "Run it again:", f"  {command}", ""]
    with convert_os_errors(folder, "writing the failing world", remedy="name a folder that you may write to"):
        folder.mkdir(parents=True)
        write_atomically(folder / SCENARIO_FILE, format_scenario(trial.scenario).encode())
        write_atomically(folder / PICTURE_FILE, picture)
        write_atomically(folder / WHY_FILE, "\n".join(why).encode())
        write_atomically(folder / FACTS_FILE, format_json(facts))
    return FailingWorld(folder, trial, facts)


def read_failing_world(folder: Path | str) -> FailingWorld:
    """Read a failing world from its folder.

    Parameters
    ----------
    folder
        The folder.

    Returns
    -------
    FailingWorld
        The scenario with its seed, and what is known about it.

    Raises
    ------
    FileError
        If a file is missing or is not what it should be.
    """
    folder = Path(folder)
    path = folder / FACTS_FILE
    remedy = "name a folder that `understudy falsify` wrote"
    with convert_os_errors(path, "reading the failing world", remedy=remedy):
        content = path.read_bytes()
    try:
        with convert_decode_errors():
            facts = msgspec.json.decode(content, type=FailureFacts)
    except msgspec.DecodeError as error:
        raise FileError(path=path, place="", problem=f"is not valid: {error}", remedy=remedy) from None
    if facts.understudy != FORMAT or facts.version != VERSION:
        problem = f"is {facts.understudy!r:.40}, version {facts.version}"
        raise FileError(path=path, place="understudy", problem=problem, remedy=remedy)
    return FailingWorld(folder, Trial(load_scenario(folder / SCENARIO_FILE), facts.seed), facts)


def list_failing_worlds(folder: Path | str) -> tuple[tuple[FailingWorld, ...], tuple[str, ...]]:
    """List the failing worlds that a folder has, in the order in which they are best corrected.

    See `order_failing_worlds` for the order. A world that cannot be read is left out, and a sentence says why.

    Parameters
    ----------
    folder
        The folder, such as `failures`. If there is none, the list is empty.

    Returns
    -------
    tuple[tuple[FailingWorld, ...], tuple[str, ...]]
        The failing worlds, and a sentence about each that cannot be read.

    Raises
    ------
    FileError
        If the folder cannot be read.
    """
    folder = Path(folder)
    if not folder.exists():
        return (), ()
    with convert_os_errors(folder, "reading the failing worlds", remedy="name a folder"):
        folders = sorted(each for each in folder.iterdir() if (each / FACTS_FILE).is_file())
    worlds, problems = list[FailingWorld](), list[str]()
    for each in folders:
        try:
            worlds.append(read_failing_world(each))
        except UnderstudyError as error:
            problems.append(str(error))
    return order_failing_worlds(worlds), tuple(problems)


def order_failing_worlds(worlds: Sequence[FailingWorld]) -> tuple[FailingWorld, ...]:
    """Order failing worlds: the worst first, then always the one that differs most from those before it.

    The worst is the one with the least robustness. So the first few show different mistakes, and a mistake that many
    worlds share comes once before it comes again. If two differ equally, the worse of them comes first.

    Parameters
    ----------
    worlds
        The failing worlds.

    Returns
    -------
    tuple[FailingWorld, ...]
        The same worlds in order.
    """
    left = sorted(worlds, key=lambda each: (each.facts.robustness, each.folder.name))
    ordered = left[:1]
    left = left[1:]
    apart = [compare_failures(each, ordered[0]) for each in left]
    while left:
        row = apart.index(max(apart))  # the first is the worst of those that are as far
        ordered.append(left.pop(row))
        apart.pop(row)
        apart = [
            min(difference, compare_failures(each, ordered[-1]))
            for difference, each in zip(apart, left, strict=True)
        ]
    return tuple(ordered)


def compare_failures(one: FailingWorld, other: FailingWorld) -> float:
    """Compute how much two failures differ, from 0 to about 3.

    It is the distance of the places where they went wrong, in diagonals of the larger arena, plus 1 if the robots were
    in different innermost states, plus 1 if different behaviors or properties failed. A place that was not kept counts
    as the same place.

    Parameters
    ----------
    one
        A failing world.
    other
        The one that it is compared with.

    Returns
    -------
    float
        The difference.
    """
    mine, its = one.facts, other.facts
    difference = float(mine.states[-1:] != its.states[-1:])
    difference += (mine.behavior, mine.property) != (its.behavior, its.property)
    if mine.place is not None and its.place is not None:
        diagonal = max(hypot(*each.trial.scenario.size) for each in (one, other))
        difference += hypot(mine.place[0] - its.place[0], mine.place[1] - its.place[1]) / diagonal
    return difference
