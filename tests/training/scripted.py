"""A session to be killed: random presses on the foraging world, one acknowledged step per line.

Run as a program it is a nursery: it imports everything once, then forks a session for every line it reads
("FOLDER SEED STEPS OPERATIONS"), which kills itself after so many steps and operations on files, and says when
it has ended.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from random import Random

from tests.killed_at_operation import kill_self_after
from tests.training.steps import do, draw_step

from understudy.learning.fit import learn
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.storage.library_folder import open_library, save_automaton
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

LIBRARY = Library(FORAGE_KIT)
STATES = ("forward", "rotate_left", "rotate_right", "load_food", "done", "start")
FEATURES = (
    "distance_to(nearest_food)",
    "angle_to(nearest_food)",
    "food_below_me",
    "food_left",
    "food_stored",
)
STEPS = 80


def is_live(seed: int) -> bool:
    """Whether the session of a seed is taught live; every other one is."""
    return seed % 2 == 1


def begin(folder: Path, seed: int) -> Session:
    lesson = new_lesson(
        LIBRARY,
        "fetch",
        states=STATES[:4],
        flags=["done"],
        features=FEATURES[:2],
        options=LearnerOptions(reaction_s=0.2, watched=True),
        live=is_live(seed),
    )
    return Session(Forage([seed]), LIBRARY, lesson, journal=folder / "journal")


def play(folder: Path, seed: int, acknowledge: Callable[[int, Session], None]) -> None:
    """All steps; every fifth or so saves what was learned to a library."""
    session, random = begin(folder, seed), Random(seed)
    more = (("teach",),) * 12 if is_live(seed) else ()
    acknowledge(-1, session)
    for index in range(STEPS):
        do(session, draw_step(random, STATES, FEATURES, more=more))
        if random.random() < 0.2:
            save_automaton(folder / "library", session.make_trained_automaton())
        acknowledge(index, session)
    session.close()


def play_until_killed(folder: Path, seed: int, *, steps: int, operations: int) -> None:
    """Play until so many steps are acknowledged, and so many operations on files followed."""
    said = os.open(folder / "said", os.O_WRONLY | os.O_CREAT | os.O_APPEND)

    def acknowledge(index: int, _: Session) -> None:
        os.write(said, f"{index}\n".encode())
        if index + 2 == steps:
            kill_self_after(operations)

    if steps == 0:
        kill_self_after(operations)
    play(folder, seed, acknowledge)


def main() -> None:
    with_everything_warm = Path(sys.argv[1])
    play(with_everything_warm, 0, lambda *_: None)
    open_library(with_everything_warm / "library", FORAGE_KIT, learn)
    os.write(1, b"ready\n")
    while line := sys.stdin.readline():
        folder, seed, steps, operations = line.rsplit(maxsplit=3)
        child = os.fork()
        if child == 0:
            play_until_killed(Path(folder), int(seed), steps=int(steps), operations=int(operations))
            os._exit(0)
        os.waitpid(child, 0)
        os.write(1, b"ended\n")


if __name__ == "__main__":
    main()
