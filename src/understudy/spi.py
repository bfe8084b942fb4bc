"""The extension points: everything that another package needs to add to Understudy, and where it is found.

`EXTENSION_POINTS` lists them. Each has a group of entry points, in which the `pyproject.toml` of a package names what
it offers; a contract, which is the docstring of a name of this module; and a check in `understudy.testing`, which a
test of that package calls. Built-in names come first. What cannot be loaded, or is of another class, is reported in a
sentence where it is used.

A package imports `understudy` and this module only. Names are imported when they are first used, so that programs
start fast; other modules of Understudy may move between versions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from understudy import _load_name
from understudy.entry_points import (
    BASELINES,
    BODIES,
    COMMANDS,
    EXPORT_TARGETS,
    KITS,
    READERS,
    STUDIES,
    TRANSPORTS,
    WORLDS,
)

if TYPE_CHECKING:
    from understudy.addons.export.hierarchy import Hierarchy as Hierarchy
    from understudy.addons.export.target_files import ExportJob as ExportJob
    from understudy.addons.export.target_files import FileByHand as FileByHand
    from understudy.addons.export.target_files import TargetFiles as TargetFiles
    from understudy.addons.export.targets.target_table import ExportTarget as ExportTarget
    from understudy.addons.recordings.mapping_file import RecordingMap as RecordingMap
    from understudy.addons.recordings.recorded_table import RecordedTable as RecordedTable
    from understudy.addons.recordings.recording_readers import RecordingReader as RecordingReader
    from understudy.addons.robots.robot_file import RobotFile as RobotFile
    from understudy.addons.robots.ros.transport import Answered as Answered
    from understudy.addons.robots.ros.transport import Publish as Publish
    from understudy.addons.robots.ros.transport import Publisher as Publisher
    from understudy.addons.robots.ros.transport import Received as Received
    from understudy.addons.robots.ros.transport import Transport as Transport
    from understudy.addons.robots.ros.transport import Unreachable as Unreachable
    from understudy.addons.robots.ros.transport import WireType as WireType
    from understudy.errors import DefinitionError as DefinitionError
    from understudy.errors import FileError as FileError
    from understudy.errors import SettingError as SettingError
    from understudy.errors import UnderstudyError as UnderstudyError
    from understudy.errors import UnknownName as UnknownName
    from understudy.judging.baseline import Baseline as Baseline
    from understudy.judging.baseline import Controller as Controller
    from understudy.judging.study import ResultTable as ResultTable
    from understudy.judging.study import Row as Row
    from understudy.judging.study import Study as Study
    from understudy.judging.study import StudyFindings as StudyFindings
    from understudy.judging.study import StudyGoal as StudyGoal
    from understudy.judging.study import StudyPlan as StudyPlan
    from understudy.judging.study import Task as Task
    from understudy.model.features import Percept as Percept
    from understudy.model.features import ReadingKey as ReadingKey
    from understudy.model.library import Kit as Kit
    from understudy.model.value_kinds import Column as Column
    from understudy.runtime.body import Body as Body
    from understudy.runtime.body import Channel as Channel
    from understudy.runtime.body import Commands as Commands
    from understudy.runtime.body import Reading as Reading
    from understudy.runtime.body import Resettable as Resettable
    from understudy.runtime.body import Rewindable as Rewindable
    from understudy.sim.scenario.files import load_scenario as load_scenario
    from understudy.sim.scenario.schema import Scenario as Scenario
    from understudy.sim.world import World as World
    from understudy.ui.cli.plugins import CommandEntry as CommandEntry


class ExtensionPoint(NamedTuple):
    """A point at which other packages extend Understudy.

    Parameters
    ----------
    group
        The group of entry points.
    offers
        What an entry point of the group names.
    used
        Where it is used, by the name of the entry point.
    contract
        The name of this module whose docstring says what must hold of it.
    check
        The function of `understudy.testing` that finds breaches of the contract.
    """

    group: str
    offers: str
    used: str
    contract: str
    check: str


EXTENSION_POINTS = (
    ExtensionPoint(
        BODIES,
        "a function of the seed, or of nothing, that returns a `Body`",
        "as the world NAME, in commands that open a world",
        "Body",
        "check_body",
    ),
    ExtensionPoint(
        KITS,
        "a `Kit` of features, behaviors and targets",
        "`--kit NAME`",
        "Kit",
        "check_kit",
    ),
    ExtensionPoint(
        WORLDS,
        "a function without parameters that returns a `Scenario`, or a `Scenario`",
        "as the world NAME, in all commands and in the studio",
        "Scenario",
        "check_scenario_worlds",
    ),
    ExtensionPoint(
        EXPORT_TARGETS,
        "an `ExportTarget`",
        "`--to NAME` of exports, and the studio",
        "ExportTarget",
        "check_export_target",
    ),
    ExtensionPoint(
        READERS,
        "a `RecordingReader`, for files whose names end in `.NAME`",
        "lessons from recordings, and `read_recorded_drive`",
        "RecordingReader",
        "check_reader",
    ),
    ExtensionPoint(
        TRANSPORTS,
        "a function of a `RobotFile` that returns a `Transport`",
        '`transport = "NAME"` in the file of a robot',
        "Transport",
        "check_transport",
    ),
    ExtensionPoint(
        COMMANDS,
        "a `CommandEntry`",
        "the command line, as the command NAME",
        "CommandEntry",
        "check_command",
    ),
    ExtensionPoint(
        STUDIES,
        "a `Study`",
        "`understudy experiment NAME`",
        "Study",
        "check_study",
    ),
    ExtensionPoint(
        BASELINES,
        "a function of a `Scenario` that returns its `Baseline`, or None",
        "`understudy eval`, and `evaluate`, to compare behaviors with it",
        "Baseline",
        "check_baseline",
    ),
)
"""All extension points."""

_MODULES = {
    "Baseline": "judging.baseline",
    "Controller": "judging.baseline",
    "ResultTable": "judging.study",
    "Row": "judging.study",
    "Study": "judging.study",
    "StudyFindings": "judging.study",
    "StudyGoal": "judging.study",
    "StudyPlan": "judging.study",
    "Task": "judging.study",
    "DefinitionError": "errors",
    "FileError": "errors",
    "SettingError": "errors",
    "UnderstudyError": "errors",
    "UnknownName": "errors",
    "Hierarchy": "addons.export.hierarchy",
    "ExportJob": "addons.export.target_files",
    "FileByHand": "addons.export.target_files",
    "TargetFiles": "addons.export.target_files",
    "ExportTarget": "addons.export.targets.target_table",
    "Percept": "model.features",
    "ReadingKey": "model.features",
    "Column": "model.value_kinds",
    "Kit": "model.library",
    "RobotFile": "addons.robots.robot_file",
    "Answered": "addons.robots.ros.transport",
    "Publish": "addons.robots.ros.transport",
    "Publisher": "addons.robots.ros.transport",
    "Received": "addons.robots.ros.transport",
    "Transport": "addons.robots.ros.transport",
    "Unreachable": "addons.robots.ros.transport",
    "WireType": "addons.robots.ros.transport",
    "Body": "runtime.body",
    "Channel": "runtime.body",
    "Commands": "runtime.body",
    "Reading": "runtime.body",
    "Resettable": "runtime.body",
    "Rewindable": "runtime.body",
    "RecordingMap": "addons.recordings.mapping_file",
    "RecordedTable": "addons.recordings.recorded_table",
    "RecordingReader": "addons.recordings.recording_readers",
    "load_scenario": "sim.scenario.files",
    "Scenario": "sim.scenario.schema",
    "World": "sim.world",
    "CommandEntry": "ui.cli.plugins",
}
"""The module, within `understudy`, that defines each name; the imports above repeat it for type checkers."""
__all__ = ["EXTENSION_POINTS", "ExtensionPoint", *_MODULES]


def __getattr__(name: str) -> Any:
    return _load_name(name, _MODULES, globals())
