"""A hundred new worlds side by side: what is in training runs in all of them, and a press corrects it where it fails.

The worlds stay the same as long as a session is open, so that after a press one sees which of them it changed. They are
never those of the score or of keep going, which measure how well it works.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import count, islice
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from understudy.addons.checks.falsification.new_worlds import Mistake, NewWorlds
from understudy.addons.checks.falsification.session_setup import SessionSetup
from understudy.errors import SessionError
from understudy.judging.robot_paths import PathMonitor
from understudy.learning.fit import learn_automaton
from understudy.model.library import TrainedAutomaton
from understudy.sim.view import WorldView
from understudy.ui.controller.keep_going import go_to_mistake
from understudy.ui.controller.status import StatusMessage

if TYPE_CHECKING:
    from understudy.judging.behavior_run import BehaviorRun
    from understudy.ui.controller.trainer import Trainer

WORLDS = 100
FIRST_SEED = 300_000_000
"""The first seed of these worlds, apart from those of the score and of keep going."""
LOOK_S = 0.5
"""The time between two places of a path, s."""
MOST_LOOKS = 60
"""The largest number of places of a path."""
MOST_ROBOTS = 8
"""The largest number of robots of a world whose paths are kept: the trained one, and others in order."""


@dataclass(frozen=True, slots=True)
class GridWorld:
    """One of the worlds: whether the behavior works there, when its run ended (s), and the paths of robots [S, N, 2].

    `view` is the world at the start, and `was_shown` says whether it was on the page, so that it is new no more.
    """

    seed: int
    works: bool
    was_shown: bool
    end_s: float
    path: NDArray[np.float64]
    view: WorldView


@dataclass(frozen=True, slots=True)
class GridResult:
    """The runs of one version of an automaton in all worlds, with the times (s) of the places of paths."""

    name: str
    binding: Mapping[str, str]
    robots: Sequence[int]
    times: Sequence[float]
    worlds: tuple[GridWorld, ...]
    mistakes: Mapping[int, Mistake]
    """Where and when it went wrong, by seed; without a flag, of a few worlds only."""

    @property
    def works(self) -> int:
        """The number of worlds in which it works."""
        return sum(each.works for each in self.worlds)

    @property
    def former_worlds(self) -> int:
        """The number of worlds that were on the page before."""
        return sum(each.was_shown for each in self.worlds)


class WorldGrid:
    """The worlds of one session, and the newest runs in them.

    Parameters
    ----------
    trainer
        The trainer of the session.
    """

    def __init__(self, trainer: Trainer) -> None:
        self._trainer = trainer
        self._seeds: list[int] = []
        self.result: GridResult | None = None
        """The newest runs; None before the first."""

    def begin(self) -> Callable[[], GridResult]:
        """Return a function that runs what is in training as it stands now, also in another thread.

        Returns
        -------
        function
            It returns the result.

        Raises
        ------
        SessionError
            If there are no other worlds, nothing to run, or it is not known what success means.
        """
        session, name = self._trainer.session, self._trainer.name
        setup = self._get_setup()
        if not self._trainer.score.goal:
            raise SessionError("success is not measured: choose what success means first")
        if not any(example.is_from_press for example in session.examples):
            raise SessionError("there is nothing to run yet: press a state to direct the robot first")
        if not self._seeds:
            unseen = (seed for seed in count(FIRST_SEED) if seed not in self._trainer.seen_seeds)
            self._seeds = list(islice(unseen, WORLDS))
        lesson, library = session.lesson, session.library
        present = dict(session.view().targets)
        bindings = self._trainer.score.list_bindings()
        binding = present if present in bindings else dict(bindings[0])
        former, seeds = frozenset(self._trainer.seen_seeds), tuple(self._seeds)
        others = [robot for robot in range(setup.robots) if robot != setup.agent]
        robots = [*([setup.agent] if setup.team is None else []), *others][:MOST_ROBOTS]

        def run() -> GridResult:
            taught = TrainedAutomaton(learn_automaton(lesson), lesson)
            paths: list[PathMonitor] = []

            def observe(running: BehaviorRun) -> list[PathMonitor]:
                stride = max(1, round(LOOK_S / running.body.tick_s))
                paths.append(PathMonitor(running, robots, stride=stride))
                return paths[-1:]

            present_library = library.with_automaton(taught)
            outcome = NewWorlds(setup, seeds).run(present_library, name, binding, observe=observe)
            times, places = paths[0].list_paths(MOST_LOOKS)
            worlds = tuple(
                GridWorld(seed, bool(works), seed in former, float(end_s), path, view)
                for seed, works, end_s, path, view in zip(
                    seeds, outcome.works, paths[0].end_s, places, paths[0].views, strict=True
                )
            )
            return GridResult(
                name, binding, robots, times, worlds, {each.seed: each for each in outcome.mistakes}
            )

        return run

    def finish(self, result: GridResult) -> StatusMessage:
        """Keep the runs, and say in how many worlds it works."""
        self.result = result
        count_shown = result.former_worlds
        caution = f"; {count_shown} of them were on the page before" if count_shown else ""
        return StatusMessage(f"{result.name} works in {result.works} of {len(result.worlds)} worlds{caution}")

    def begin_visit(self, seed: int) -> Callable[[], Mistake]:
        """Return a function that finds when it went wrong in a world, also in another thread.

        Parameters
        ----------
        seed
            The seed of a world in which it did not work.

        Returns
        -------
        function
            It returns the mistake.

        Raises
        ------
        SessionError
            If nothing was run, or it works in that world, or it is none of them.
        """
        result = self.result
        if result is None:
            raise SessionError("nothing was run in these worlds yet: show them first")
        if not any(each.seed == seed and not each.works for each in result.worlds):
            raise SessionError(f"{result.name} did not go wrong in a world {seed} of these")
        mistake = result.mistakes.get(seed)
        session, setup = self._trainer.session, self._get_setup()
        lesson, library = session.lesson, session.library

        def find() -> Mistake:
            if mistake is not None:
                return mistake
            taught = TrainedAutomaton(learn_automaton(lesson), lesson)
            again = NewWorlds(setup, [seed]).run(library.with_automaton(taught), result.name, result.binding)
            return next(
                iter(again.mistakes), Mistake(seed, result.binding, 0.0, "it works here as it is now")
            )

        return find

    def visit(self, mistake: Mistake) -> StatusMessage:
        """Go to where it goes wrong, with the targets with which it ran, paused and without learning."""
        return StatusMessage(f"World {mistake.seed}: {go_to_mistake(self._trainer, mistake)}")

    def _get_setup(self) -> SessionSetup:
        setup = SessionSetup.from_session(self._trainer.session)
        if setup is None:
            raise SessionError(
                "there are no other worlds to run it in: watch the robot, and press where it is wrong"
            )
        return setup
