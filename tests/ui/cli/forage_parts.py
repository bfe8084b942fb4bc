"""A foraging library written by hand, so that commands can be tested without a learner or a teacher."""

from __future__ import annotations

from math import pi, tau

from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.sim.forage import FORAGE_KIT

A = Binding(A="A")
angle_to, distance_to = FORAGE_KIT.features["angle_to"], FORAGE_KIT.features["distance_to"]
food_below_me, food_left, food_stored = (
    FORAGE_KIT.features[name] for name in ("food_below_me", "food_left", "food_stored")
)
ALWAYS = Tree((make_leaf(1),))
DONE = BoundFeature(FORAGE_KIT.features["done"])


def steer(width: float) -> Tree:
    return Tree(
        (
            Node(TestKind.BELOW, 0, high=0.3, yes=1, no=2),
            make_leaf(4),
            Node(TestKind.ARC, 1, low=tau - width, high=width, yes=3, no=4),
            make_leaf(1),
            Node(TestKind.BELOW, 1, high=pi, yes=5, no=6),
            make_leaf(2),
            make_leaf(3),
        )
    )


def when_done(no: int, yes: int) -> Tree:
    return Tree((Node(TestKind.LABEL, 0, branches=(1, 2)), make_leaf(no), make_leaf(yes)))


goto = Automaton(
    "goto",
    (
        START,
        State("forward", "forward"),
        State("left", "rotate_left"),
        State("right", "rotate_right"),
        State("done", flag="done"),
    ),
    (BoundFeature(distance_to, A), BoundFeature(angle_to, A)),
    ("A",),
    transitions={"start": steer(0.1), "forward": steer(0.3), "left": steer(0.1), "right": steer(0.1)},
)
harvest = Automaton(
    "harvest",
    (
        START,
        State("goto", "goto", Binding(A="nearest_food")),
        State("load", "load_food"),
        State("done", flag="done"),
    ),
    (DONE, BoundFeature(food_below_me), BoundFeature(food_stored), BoundFeature(food_left)),
    transitions={
        "start": ALWAYS,
        "goto": when_done(1, 2),
        "load": Tree(
            (
                Node(TestKind.BELOW, 2, high=9.5, yes=1, no=2),
                Node(TestKind.BELOW, 1, high=0.5, yes=3, no=4),
                make_leaf(3),
                Node(TestKind.LABEL, 3, branches=(5, 6)),
                make_leaf(STAY),
                make_leaf(3),
                make_leaf(1),
            )
        ),
    },
)
deposit = Automaton(
    "deposit",
    (
        START,
        State("goto", "goto", Binding(A="station")),
        State("unload", "unload_food"),
        State("done", flag="done"),
    ),
    (DONE, BoundFeature(food_stored)),
    transitions={
        "start": ALWAYS,
        "goto": when_done(1, 2),
        "unload": Tree((Node(TestKind.BELOW, 1, high=0.5, yes=1, no=2), make_leaf(3), make_leaf(2))),
    },
)
forage = Automaton(
    "forage",
    (START, State("harvest", "harvest"), State("deposit", "deposit")),
    (DONE,),
    transitions={"start": ALWAYS, "harvest": when_done(1, 2), "deposit": when_done(2, 1)},
)
AUTOMATA = (goto, harvest, deposit, forage)
