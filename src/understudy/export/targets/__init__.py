"""The targets of exports: what an automaton can be exported to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from understudy.export.target_files import ExportJob, TargetFiles

ROWS = "conformance.csv"


@dataclass(frozen=True, slots=True)
class ExportTarget:
    """A target: the place of a function from an `ExportJob` to its files, MODULE:FUNCTION, loaded when it is used.

    `single_precision` says whether it can be written in single precision.
    """

    place: str
    single_precision: bool = False

    def make_files(self, job: ExportJob) -> TargetFiles:
        """Make the files of an export, with the conformance rows in the names of the target."""
        from understudy.export.conformance import format_conformance

        module, _, function = self.place.partition(":")
        made: TargetFiles = getattr(import_module(module), function)(job)
        rows = format_conformance(job.conformance, job.hierarchy, made.names)
        return replace(made, files={**made.files, ROWS: rows})


TARGETS: Mapping[str, ExportTarget] = {
    "c99": ExportTarget("understudy.export.targets.c99:make_c99_files", single_precision=True),
    "python": ExportTarget("understudy.export.targets.python_module:make_python_files"),
    "scxml": ExportTarget("understudy.export.targets.scxml:make_scxml_files"),
    "xstate": ExportTarget("understudy.export.targets.xstate:make_xstate_files"),
    "json": ExportTarget("understudy.export.targets.json_documents:make_json_files"),
    "btcpp": ExportTarget("understudy.export.targets.btcpp:make_btcpp_files"),
    "ros2": ExportTarget("understudy.export.targets.ros2:make_ros2_files"),
}
"""The targets by name."""
