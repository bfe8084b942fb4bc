"""Understudy: robots and robot teams that learn by being shown.

The public names, each fetched when it is first used, so that a robot or a command starts at once.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from understudy.analysis.evaluation import Evaluation, evaluate
    from understudy.errors import UnderstudyError
    from understudy.learning.correction_diagnosis import CorrectionDiagnosis, diagnose_correction
    from understudy.learning.explain import Explanation, explain
    from understudy.learning.fit import learn, learn_automaton
    from understudy.learning.mislabels import find_mislabels
    from understudy.model.automaton import START, Automaton, State
    from understudy.model.behaviors import (
        Behavior,
        Command,
        behavior,
        increment,
        reset_counter,
        reset_timer,
        set_counter,
        set_timer,
    )
    from understudy.model.binding import Binding, Target
    from understudy.model.features import (
        BoundFeature,
        CounterFeature,
        Feature,
        FlagFeature,
        TimeInState,
        TimerFeature,
        feature,
    )
    from understudy.model.kinds import BOOLEAN, TAU, Categorical, Continuous, Toroidal
    from understudy.model.lesson import (
        Example,
        ExampleKind,
        LearnerOptions,
        Lesson,
        SklearnOptions,
        TreeOptions,
    )
    from understudy.model.library import Kit, Library, TrainedAutomaton
    from understudy.model.tree import Tree
    from understudy.runtime.body import Body, Channel, Reading
    from understudy.runtime.decision_trace import DecisionTrace
    from understudy.runtime.engine.engine import Engine
    from understudy.runtime.interpreter import Interpreter
    from understudy.runtime.program import link
    from understudy.runtime.run_loop import Run
    from understudy.runtime.team.coordinator_body import CoordinatorBody
    from understudy.runtime.team.team import Team
    from understudy.sim.forage import Forage, ForageSettings
    from understudy.sim.scenario.files import load_scenario
    from understudy.sim.team.libraries import collect_libraries, make_coordinator_body, make_team
    from understudy.sim.world import World
    from understudy.storage.library_folder import open_library, save_automaton
    from understudy.training.lesson_design import new_lesson
    from understudy.training.reaction_time import ReactionEstimate, estimate_reaction_time
    from understudy.training.session import Session
    from understudy.training.session_view import SessionView
    from understudy.training.trainee import Mode

_HOMES = {
    "analysis.evaluation": (
        "Evaluation",
        "evaluate",
    ),
    "errors": ("UnderstudyError",),
    "learning.correction_diagnosis": (
        "CorrectionDiagnosis",
        "diagnose_correction",
    ),
    "learning.explain": (
        "Explanation",
        "explain",
    ),
    "learning.fit": (
        "learn",
        "learn_automaton",
    ),
    "learning.mislabels": ("find_mislabels",),
    "model.automaton": (
        "START",
        "Automaton",
        "State",
    ),
    "model.behaviors": (
        "Behavior",
        "Command",
        "behavior",
        "increment",
        "reset_counter",
        "reset_timer",
        "set_counter",
        "set_timer",
    ),
    "model.binding": (
        "Binding",
        "Target",
    ),
    "model.features": (
        "BoundFeature",
        "CounterFeature",
        "Feature",
        "FlagFeature",
        "TimeInState",
        "TimerFeature",
        "feature",
    ),
    "model.kinds": (
        "BOOLEAN",
        "TAU",
        "Categorical",
        "Continuous",
        "Toroidal",
    ),
    "model.lesson": (
        "Example",
        "ExampleKind",
        "LearnerOptions",
        "Lesson",
        "SklearnOptions",
        "TreeOptions",
    ),
    "model.library": (
        "Kit",
        "Library",
        "TrainedAutomaton",
    ),
    "model.tree": ("Tree",),
    "runtime.body": (
        "Body",
        "Channel",
        "Reading",
    ),
    "runtime.decision_trace": ("DecisionTrace",),
    "runtime.engine.engine": ("Engine",),
    "runtime.interpreter": ("Interpreter",),
    "runtime.program": ("link",),
    "runtime.run_loop": ("Run",),
    "runtime.team.coordinator_body": ("CoordinatorBody",),
    "runtime.team.team": ("Team",),
    "sim.forage": (
        "Forage",
        "ForageSettings",
    ),
    "sim.scenario.files": ("load_scenario",),
    "sim.team.libraries": (
        "collect_libraries",
        "make_coordinator_body",
        "make_team",
    ),
    "sim.world": ("World",),
    "storage.library_folder": (
        "open_library",
        "save_automaton",
    ),
    "training.lesson_design": ("new_lesson",),
    "training.reaction_time": (
        "ReactionEstimate",
        "estimate_reaction_time",
    ),
    "training.session": ("Session",),
    "training.session_view": ("SessionView",),
    "training.trainee": ("Mode",),
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
    "CoordinatorBody",
    "CorrectionDiagnosis",
    "CounterFeature",
    "DecisionTrace",
    "Engine",
    "Evaluation",
    "Example",
    "ExampleKind",
    "Explanation",
    "Feature",
    "FlagFeature",
    "Forage",
    "ForageSettings",
    "Interpreter",
    "Kit",
    "LearnerOptions",
    "Lesson",
    "Library",
    "Mode",
    "ReactionEstimate",
    "Reading",
    "Run",
    "Session",
    "SessionView",
    "SklearnOptions",
    "State",
    "Target",
    "Team",
    "TimeInState",
    "TimerFeature",
    "Toroidal",
    "TrainedAutomaton",
    "Tree",
    "TreeOptions",
    "UnderstudyError",
    "World",
    "behavior",
    "collect_libraries",
    "diagnose_correction",
    "estimate_reaction_time",
    "evaluate",
    "explain",
    "feature",
    "find_mislabels",
    "increment",
    "learn",
    "learn_automaton",
    "link",
    "load_scenario",
    "make_coordinator_body",
    "make_team",
    "new_lesson",
    "open_library",
    "reset_counter",
    "reset_timer",
    "save_automaton",
    "set_counter",
    "set_timer",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'understudy' has no attribute {name!r}")
    module = import_module(f"understudy.{_HOME[name]}")
    value = getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
