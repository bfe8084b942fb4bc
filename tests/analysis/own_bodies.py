"""A body of one's own in a few lines of Python: carts on a line that drive to a ball. Other processes find it here."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from understudy.judging.world_run import WorldRun
from understudy.model.automaton import Automaton
from understudy.model.behaviors import Behavior, Command
from understudy.model.features import BoundFeature, Feature, Percept, ReadingKey
from understudy.model.library import Kit, Library
from understudy.model.value_kinds import BOOLEAN, Continuous
from understudy.runtime.body import Channel, Commands, Reading
from understudy_lab.tree_builder import build_automaton, split_below

FAR, LOAD = Feature("far", Continuous(), reading="far"), Feature("load", Continuous(), reading="load")
FORWARD = Behavior("forward", command=Command(drive=1.0))
KIT = Kit.from_parts(FAR, LOAD, FORWARD)


def make_approach(stop: float, name: str = "approach") -> Automaton:
    """Make an automaton that drives until it is nearer than `stop`, and is done then."""
    transitions = {
        "start": split_below("far", stop, "done", "forward"),
        "forward": split_below("far", stop, "done", "forward"),
    }
    return build_automaton(
        name, transitions, readings={"far": BoundFeature(FAR)}, flags=("done",), basics=["forward"]
    )


LIBRARY = Library.from_automata(KIT, make_approach(0.5))


class Carts:
    """N carts that start as many meters away as the seed says, each one meter farther than the one before."""

    tick_s = 0.5
    targets = ()
    channels = (Channel("drive"),)
    readings = (Reading("far", Continuous(), "m"), Reading("load", Continuous()), Reading("near", BOOLEAN))

    def __init__(self, seed: int, agents: int = 1) -> None:
        self.agents, self.time_s = agents, 100.0
        self.far = seed + np.arange(agents, dtype=np.float64)
        self.is_closed = False

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        found = {"far": self.far, "load": np.full(self.agents, np.nan), "near": 1.0 * (self.far < 2)}
        return {key: found[key[0]] for key in keys}

    def act(self, commands: Commands) -> None:
        self.far = self.far - self.tick_s * commands["drive"]
        self.time_s += self.tick_s

    def close(self) -> None:
        self.is_closed = True


def make_pair(seed: int) -> Carts:
    """Make two carts."""
    return Carts(seed, agents=2)


def make_number(seed: int) -> int:
    """Make what is no body."""
    return seed


def make_cart_but_the_third(seed: int) -> Carts:
    """Make a cart, or fail."""
    if seed == 3:
        raise RuntimeError("no cart\nis left")
    return Carts(seed)


class Frozen(Carts):
    """Carts whose clock stands still."""

    def act(self, commands: Commands) -> None:
        pass


def is_close(run: WorldRun) -> bool:
    return bool(np.all(run.read("far") < 1))


def raise_error_after_2_m(run: WorldRun) -> bool:
    if run.read("far")[0] < 2:
        raise ValueError("too near")
    return False


def measure_way(run: WorldRun) -> float:
    """Sum the ways of all carts, m."""
    return float(np.abs(np.diff(run.recorded["far"], axis=0)).sum())


def divide_by_seed(run: WorldRun) -> float:
    return 1 / run.seed


def give_text(run: WorldRun) -> str:
    return "far"
