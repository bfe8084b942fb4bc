"""Understudy: robots and robot teams that learn by being shown.

The public names, each fetched when it is first used, so that a robot or a command starts at once.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from understudy.errors import UnderstudyError
    from understudy.evaluation import Evaluation, evaluate
    from understudy.learning.explain import Explanation, explain
    from understudy.learning.slips import slips
    from understudy.learning.transitions import learn, learned
    from understudy.learning.unlearning import Judgement, judge
    from understudy.model.automaton import START, Automaton, State
    from understudy.model.behavior import (
        Behavior,
        Command,
        behavior,
        increment,
        reset_counter,
        reset_timer,
        set_counter,
        set_timer,
    )
    from understudy.model.binding import Binding
    from understudy.model.example import Example, ExampleKind
    from understudy.model.feature import BoundFeature, Counter, Feature, Flag, TimeInState, Timer, feature
    from understudy.model.folder import open_library
    from understudy.model.folder import save as save_taught
    from understudy.model.kinds import BOOLEAN, TAU, Categorical, Continuous, Toroidal
    from understudy.model.kit import Kit
    from understudy.model.lesson import Lesson, Options, Scikit, Trees
    from understudy.model.library import Library, Taught
    from understudy.model.target import Target
    from understudy.model.tree import Tree
    from understudy.runtime.body import Body, Channel, Reading
    from understudy.runtime.engine import Engine
    from understudy.runtime.interpreter import Interpreter
    from understudy.runtime.program import link
    from understudy.runtime.run import Run
    from understudy.runtime.team import Team
    from understudy.runtime.trace import Trace
    from understudy.runtime.troop import Troop
    from understudy.training.design import new_lesson
    from understudy.training.lateness import Lateness, lateness
    from understudy.training.screen import Screen
    from understudy.training.session import Session
    from understudy.training.trainee import Mode
    from understudy.worlds.forage import Forage, ForageSettings
    from understudy.worlds.scenario_files import load_scenario
    from understudy.worlds.teams import libraries_of, team_of, troop_of
    from understudy.worlds.world import World

_HOMES = {
    "errors": ("UnderstudyError",),
    "evaluation": ("Evaluation", "evaluate"),
    "learning.explain": ("Explanation", "explain"),
    "learning.transitions": ("learn", "learned"),
    "learning.slips": ("slips",),
    "learning.unlearning": ("Judgement", "judge"),
    "model.automaton": ("START", "Automaton", "State"),
    "model.behavior": (
        "Behavior",
        "Command",
        "behavior",
        "increment",
        "reset_counter",
        "reset_timer",
        "set_counter",
        "set_timer",
    ),
    "model.binding": ("Binding",),
    "model.example": ("Example", "ExampleKind"),
    "model.feature": ("BoundFeature", "Counter", "Feature", "Flag", "TimeInState", "Timer", "feature"),
    "model.folder": ("open_library", "save_taught"),
    "model.kinds": ("BOOLEAN", "TAU", "Categorical", "Continuous", "Toroidal"),
    "model.kit": ("Kit",),
    "model.lesson": ("Lesson", "Options", "Scikit", "Trees"),
    "model.library": ("Library", "Taught"),
    "model.target": ("Target",),
    "model.tree": ("Tree",),
    "runtime.body": ("Body", "Channel", "Reading"),
    "runtime.engine": ("Engine",),
    "runtime.interpreter": ("Interpreter",),
    "runtime.program": ("link",),
    "runtime.run": ("Run",),
    "runtime.team": ("Team",),
    "runtime.trace": ("Trace",),
    "runtime.troop": ("Troop",),
    "training.design": ("new_lesson",),
    "training.lateness": ("Lateness", "lateness"),
    "training.screen": ("Screen",),
    "training.session": ("Session",),
    "training.trainee": ("Mode",),
    "worlds.forage": ("Forage", "ForageSettings"),
    "worlds.scenario_files": ("load_scenario",),
    "worlds.teams": ("libraries_of", "team_of", "troop_of"),
    "worlds.world": ("World",),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "BOOLEAN",
    "START",
    "TAU",
    "Automaton",
    "Behavior",
    "Binding",
    "Body",
    "BoundFeature",
    "Categorical",
    "Channel",
    "Command",
    "Continuous",
    "Counter",
    "Engine",
    "Evaluation",
    "Example",
    "ExampleKind",
    "Explanation",
    "Feature",
    "Flag",
    "Forage",
    "ForageSettings",
    "Interpreter",
    "Judgement",
    "Kit",
    "Lateness",
    "Lesson",
    "Library",
    "Mode",
    "Options",
    "Reading",
    "Run",
    "Scikit",
    "Screen",
    "Session",
    "State",
    "Target",
    "Taught",
    "Team",
    "TimeInState",
    "Timer",
    "Toroidal",
    "Trace",
    "Tree",
    "Trees",
    "Troop",
    "UnderstudyError",
    "World",
    "behavior",
    "evaluate",
    "explain",
    "feature",
    "increment",
    "judge",
    "lateness",
    "learn",
    "learned",
    "libraries_of",
    "link",
    "load_scenario",
    "new_lesson",
    "open_library",
    "reset_counter",
    "reset_timer",
    "save_taught",
    "set_counter",
    "set_timer",
    "slips",
    "team_of",
    "troop_of",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'understudy' has no attribute {name!r}")
    module = import_module(f"understudy.{_HOME[name]}")
    value = getattr(module, "save" if name == "save_taught" else name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
