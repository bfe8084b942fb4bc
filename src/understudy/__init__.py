"""Understudy: robots and robot teams that learn from demonstrations.

This module exports the public names. Each is imported when it is first used, so that programs start fast.
"""

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from understudy.addons.bridges.datasets.lerobot import write_lerobot as write_lerobot
    from understudy.addons.bridges.datasets.lerobot_reader import read_lerobot as read_lerobot
    from understudy.addons.bridges.datasets.minari import write_minari as write_minari
    from understudy.addons.bridges.datasets.minari_reader import read_minari as read_minari
    from understudy.addons.bridges.environments.gymnasium import GymnasiumBody as GymnasiumBody
    from understudy.addons.bridges.environments.gymnasium import ScenarioEnv as ScenarioEnv
    from understudy.addons.bridges.environments.pettingzoo import PettingZooBody as PettingZooBody
    from understudy.addons.bridges.environments.pettingzoo import ScenarioParallelEnv as ScenarioParallelEnv
    from understudy.addons.bridges.mujoco.body import MujocoBody as MujocoBody
    from understudy.addons.export.export_automaton import ExportResult as ExportResult
    from understudy.addons.export.export_automaton import export_automaton as export_automaton
    from understudy.addons.recordings.candidates import CommandModel as CommandModel
    from understudy.addons.recordings.drive_kit import make_candidates as make_candidates
    from understudy.addons.recordings.drive_kit import make_drive_kit as make_drive_kit
    from understudy.addons.recordings.drive_table import read_recorded_drive as read_recorded_drive
    from understudy.addons.recordings.driver_contradictions import DriverContradiction as DriverContradiction
    from understudy.addons.recordings.driver_contradictions import (
        find_driver_contradictions as find_driver_contradictions,
    )
    from understudy.addons.recordings.driver_contradictions import (
        settle_driver_contradictions as settle_driver_contradictions,
    )
    from understudy.addons.recordings.driver_lessons import merge_driver_lessons as merge_driver_lessons
    from understudy.addons.recordings.lesson_from_drive import DriveLesson as DriveLesson
    from understudy.addons.recordings.lesson_from_drive import to_lesson as to_lesson
    from understudy.addons.recordings.mapping_file import RecordingMap as RecordingMap
    from understudy.addons.recordings.mapping_file import load_recording_map as load_recording_map
    from understudy.addons.recordings.segment import Segmentation as Segmentation
    from understudy.addons.recordings.segment import SegmentOptions as SegmentOptions
    from understudy.addons.recordings.segment import segment as segment
    from understudy.errors import UnderstudyError as UnderstudyError
    from understudy.judging.comparison import Comparison as Comparison
    from understudy.judging.comparison import compare as compare
    from understudy.judging.evaluate import evaluate as evaluate
    from understudy.judging.evaluation import Evaluation as Evaluation
    from understudy.judging.record_files import read_lesson as read_lesson
    from understudy.judging.record_files import read_records as read_records
    from understudy.judging.world_run import WorldRun as WorldRun
    from understudy.learning.explain import Explanation as Explanation
    from understudy.learning.explain import explain as explain
    from understudy.learning.fit import learn as learn
    from understudy.learning.fit import learn_automaton as learn_automaton
    from understudy.learning.mislabels import CorrectionDiagnosis as CorrectionDiagnosis
    from understudy.learning.mislabels import diagnose_correction as diagnose_correction
    from understudy.learning.mislabels import find_mislabels as find_mislabels
    from understudy.model.automaton import START as START
    from understudy.model.automaton import Automaton as Automaton
    from understudy.model.automaton import State as State
    from understudy.model.behaviors import Behavior as Behavior
    from understudy.model.behaviors import Command as Command
    from understudy.model.behaviors import behavior as behavior
    from understudy.model.behaviors import increment as increment
    from understudy.model.behaviors import reset_counter as reset_counter
    from understudy.model.behaviors import reset_timer as reset_timer
    from understudy.model.behaviors import set_counter as set_counter
    from understudy.model.behaviors import set_timer as set_timer
    from understudy.model.binding import Binding as Binding
    from understudy.model.binding import Target as Target
    from understudy.model.change_summary import ChangeSummary as ChangeSummary
    from understudy.model.change_summary import summarize_change as summarize_change
    from understudy.model.diff import AutomatonDiff as AutomatonDiff
    from understudy.model.diff import diff_automata as diff_automata
    from understudy.model.example_source import ExampleSource as ExampleSource
    from understudy.model.features import BoundFeature as BoundFeature
    from understudy.model.features import CounterFeature as CounterFeature
    from understudy.model.features import Feature as Feature
    from understudy.model.features import FlagFeature as FlagFeature
    from understudy.model.features import TimeInState as TimeInState
    from understudy.model.features import TimerFeature as TimerFeature
    from understudy.model.features import feature as feature
    from understudy.model.learner_options import LearnerOptions as LearnerOptions
    from understudy.model.learner_options import SklearnOptions as SklearnOptions
    from understudy.model.learner_options import TreeOptions as TreeOptions
    from understudy.model.lesson import Example as Example
    from understudy.model.lesson import ExampleKind as ExampleKind
    from understudy.model.lesson import Lesson as Lesson
    from understudy.model.library import Kit as Kit
    from understudy.model.library import Library as Library
    from understudy.model.library import TrainedAutomaton as TrainedAutomaton
    from understudy.model.tree import Tree as Tree
    from understudy.model.value_kinds import BOOLEAN as BOOLEAN
    from understudy.model.value_kinds import TAU as TAU
    from understudy.model.value_kinds import Categorical as Categorical
    from understudy.model.value_kinds import Continuous as Continuous
    from understudy.model.value_kinds import Toroidal as Toroidal
    from understudy.records.record import Episode as Episode
    from understudy.records.record import Record as Record
    from understudy.records.record import RecordedPress as RecordedPress
    from understudy.records.record_tables import EpisodeFrames as EpisodeFrames
    from understudy.records.record_tables import make_episode_frames as make_episode_frames
    from understudy.runtime.body import Body as Body
    from understudy.runtime.body import Channel as Channel
    from understudy.runtime.body import Reading as Reading
    from understudy.runtime.decision_trace import DecisionTrace as DecisionTrace
    from understudy.runtime.engine.engine import Engine as Engine
    from understudy.runtime.interpreter import Interpreter as Interpreter
    from understudy.runtime.link import link as link
    from understudy.runtime.run_loop import Run as Run
    from understudy.runtime.team.coordinator_body import CoordinatorBody as CoordinatorBody
    from understudy.runtime.team.team import Team as Team
    from understudy.sim.forage import Forage as Forage
    from understudy.sim.forage import ForageSettings as ForageSettings
    from understudy.sim.scenario.files import load_scenario as load_scenario
    from understudy.sim.team.libraries import collect_libraries as collect_libraries
    from understudy.sim.team.libraries import make_coordinator_body as make_coordinator_body
    from understudy.sim.team.libraries import make_team as make_team
    from understudy.sim.world import World as World
    from understudy.storage.library_folder import open_library as open_library
    from understudy.storage.library_folder import save_automaton as save_automaton
    from understudy.training.lesson_design import new_lesson as new_lesson
    from understudy.training.reaction_time import ReactionEstimate as ReactionEstimate
    from understudy.training.reaction_time import estimate_reaction_time as estimate_reaction_time
    from understudy.training.session import Session as Session
    from understudy.training.trainee import Mode as Mode
    from understudy.training.trainee import SessionView as SessionView

__version__ = "0.4.0.dev0"
"""The version of this package, from which the distribution takes its own."""

_MODULES = {
    "GymnasiumBody": "addons.bridges.environments.gymnasium",
    "ScenarioEnv": "addons.bridges.environments.gymnasium",
    "PettingZooBody": "addons.bridges.environments.pettingzoo",
    "ScenarioParallelEnv": "addons.bridges.environments.pettingzoo",
    "MujocoBody": "addons.bridges.mujoco.body",
    "Comparison": "judging.comparison",
    "compare": "judging.comparison",
    "Evaluation": "judging.evaluation",
    "evaluate": "judging.evaluate",
    "WorldRun": "judging.world_run",
    "read_records": "judging.record_files",
    "read_lesson": "judging.record_files",
    "write_lerobot": "addons.bridges.datasets.lerobot",
    "read_lerobot": "addons.bridges.datasets.lerobot_reader",
    "write_minari": "addons.bridges.datasets.minari",
    "read_minari": "addons.bridges.datasets.minari_reader",
    "UnderstudyError": "errors",
    "ExportResult": "addons.export.export_automaton",
    "export_automaton": "addons.export.export_automaton",
    "CorrectionDiagnosis": "learning.mislabels",
    "diagnose_correction": "learning.mislabels",
    "Explanation": "learning.explain",
    "explain": "learning.explain",
    "learn": "learning.fit",
    "learn_automaton": "learning.fit",
    "find_mislabels": "learning.mislabels",
    "START": "model.automaton",
    "Automaton": "model.automaton",
    "State": "model.automaton",
    "Behavior": "model.behaviors",
    "Command": "model.behaviors",
    "behavior": "model.behaviors",
    "increment": "model.behaviors",
    "reset_counter": "model.behaviors",
    "reset_timer": "model.behaviors",
    "set_counter": "model.behaviors",
    "set_timer": "model.behaviors",
    "Binding": "model.binding",
    "Target": "model.binding",
    "ChangeSummary": "model.change_summary",
    "summarize_change": "model.change_summary",
    "AutomatonDiff": "model.diff",
    "diff_automata": "model.diff",
    "ExampleSource": "model.example_source",
    "BoundFeature": "model.features",
    "CounterFeature": "model.features",
    "Feature": "model.features",
    "FlagFeature": "model.features",
    "TimeInState": "model.features",
    "TimerFeature": "model.features",
    "feature": "model.features",
    "BOOLEAN": "model.value_kinds",
    "TAU": "model.value_kinds",
    "Categorical": "model.value_kinds",
    "Continuous": "model.value_kinds",
    "Toroidal": "model.value_kinds",
    "Example": "model.lesson",
    "ExampleKind": "model.lesson",
    "LearnerOptions": "model.learner_options",
    "Lesson": "model.lesson",
    "SklearnOptions": "model.learner_options",
    "TreeOptions": "model.learner_options",
    "Kit": "model.library",
    "Library": "model.library",
    "TrainedAutomaton": "model.library",
    "Tree": "model.tree",
    "Body": "runtime.body",
    "Channel": "runtime.body",
    "Reading": "runtime.body",
    "DecisionTrace": "runtime.decision_trace",
    "Engine": "runtime.engine.engine",
    "Interpreter": "runtime.interpreter",
    "link": "runtime.link",
    "Run": "runtime.run_loop",
    "CoordinatorBody": "runtime.team.coordinator_body",
    "Team": "runtime.team.team",
    "Episode": "records.record",
    "Record": "records.record",
    "RecordedPress": "records.record",
    "EpisodeFrames": "records.record_tables",
    "make_episode_frames": "records.record_tables",
    "CommandModel": "addons.recordings.candidates",
    "make_candidates": "addons.recordings.drive_kit",
    "make_drive_kit": "addons.recordings.drive_kit",
    "read_recorded_drive": "addons.recordings.drive_table",
    "DriverContradiction": "addons.recordings.driver_contradictions",
    "find_driver_contradictions": "addons.recordings.driver_contradictions",
    "settle_driver_contradictions": "addons.recordings.driver_contradictions",
    "merge_driver_lessons": "addons.recordings.driver_lessons",
    "DriveLesson": "addons.recordings.lesson_from_drive",
    "to_lesson": "addons.recordings.lesson_from_drive",
    "RecordingMap": "addons.recordings.mapping_file",
    "load_recording_map": "addons.recordings.mapping_file",
    "Segmentation": "addons.recordings.segment",
    "SegmentOptions": "addons.recordings.segment",
    "segment": "addons.recordings.segment",
    "Forage": "sim.forage",
    "ForageSettings": "sim.forage",
    "load_scenario": "sim.scenario.files",
    "collect_libraries": "sim.team.libraries",
    "make_coordinator_body": "sim.team.libraries",
    "make_team": "sim.team.libraries",
    "World": "sim.world",
    "open_library": "storage.library_folder",
    "save_automaton": "storage.library_folder",
    "new_lesson": "training.lesson_design",
    "ReactionEstimate": "training.reaction_time",
    "estimate_reaction_time": "training.reaction_time",
    "Session": "training.session",
    "SessionView": "training.trainee",
    "Mode": "training.trainee",
}
"""The module, within `understudy`, that defines each public name; the imports above repeat it for type checkers."""
__all__ = list(_MODULES)


def _load_name(name: str, modules: Mapping[str, str], space: dict[str, Any]) -> Any:
    """Import a public name of a module from the module that defines it, and keep it in the namespace of the first."""
    if name not in modules:
        raise AttributeError(f"module {space['__name__']!r} has no attribute {name!r}")
    value = getattr(import_module(f"understudy.{modules[name]}"), name)
    space[name] = value
    return value


def __getattr__(name: str) -> Any:
    return _load_name(name, _MODULES, globals())


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__} - {"Any", "Mapping", "TYPE_CHECKING", "import_module"})
