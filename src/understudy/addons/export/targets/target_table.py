"""The targets of exports: what an automaton can be exported to, here and by other packages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pkgutil import resolve_name
from typing import TYPE_CHECKING

from understudy.entry_points import EXPORT_TARGETS, list_entry_points, load_instance
from understudy.errors import UnknownName

if TYPE_CHECKING:
    from understudy.addons.export.hierarchy import Hierarchy
    from understudy.addons.export.target_files import ExportJob, TargetFiles

ROWS = "conformance.csv"
REMEDY = "let the entry point name an ExportTarget of understudy.spi"


@dataclass(frozen=True, slots=True)
class ExportTarget:
    """A target of exports: the function that makes its files from the job of an export.

    Parameters
    ----------
    function
        Function from an `ExportJob` to `TargetFiles`, or its place, MODULE:FUNCTION, which is imported when it is used.
        The same job gives the same files; it writes none itself. For what it cannot express, it raises an
        `UnderstudyError` that names the part of the automaton. It is called in any thread, once for each export.
    single_precision
        Whether jobs in single precision are accepted, too.
    check
        Function that raises an `UnderstudyError` for a `Hierarchy` that would be too large, or its place. It is called
        before the conformance rows are answered, which takes a while where trees are large. None: all are taken.
    """

    function: Callable[[ExportJob], TargetFiles] | str
    single_precision: bool = False
    check: Callable[[Hierarchy], None] | str | None = None

    def check_size(self, hierarchy: Hierarchy) -> None:
        """Refuse a hierarchy that would be too large for the target.

        Parameters
        ----------
        hierarchy
            What is to be exported.

        Raises
        ------
        DefinitionError
            If it is too large; it says of what there is how much.
        """
        if self.check is not None:
            check = resolve_name(self.check) if isinstance(self.check, str) else self.check
            check(hierarchy)

    def load(self) -> Callable[[ExportJob], TargetFiles]:
        """Import the function.

        Returns
        -------
        callable
            The function.
        """
        return resolve_name(self.function) if isinstance(self.function, str) else self.function

    def make_files(self, job: ExportJob) -> TargetFiles:
        """Make the files of an export, with the conformance rows in the names of the target.

        Parameters
        ----------
        job
            What is exported.

        Returns
        -------
        TargetFiles
            The files of the target, and the rows.
        """
        from understudy.addons.export.conformance import format_conformance

        target_files = self.load()(job)
        rows = format_conformance(job.conformance, job.hierarchy, target_files.names)
        return replace(target_files, files={**target_files.files, ROWS: rows})


HERE = "understudy.addons.export.targets"
CHART_SIZE = "understudy.addons.export.statechart:check_statechart_size"
TARGETS: Mapping[str, ExportTarget] = {
    "c99": ExportTarget(f"{HERE}.c99:make_c99_files", single_precision=True),
    "python": ExportTarget(f"{HERE}.python_module:make_python_files"),
    "scxml": ExportTarget(f"{HERE}.scxml:make_scxml_files", check=CHART_SIZE),
    "xstate": ExportTarget(f"{HERE}.xstate:make_xstate_files", check=CHART_SIZE),
    "json": ExportTarget(f"{HERE}.json_documents:make_json_files"),
    "btcpp": ExportTarget(f"{HERE}.btcpp:make_btcpp_files", check=f"{HERE}.btcpp_tree:check_tree_size"),
    "ros2": ExportTarget(f"{HERE}.ros2:make_ros2_files"),
}
"""The built-in targets by name."""


def list_targets() -> list[str]:
    """List the names of targets: the built-in ones, then those of installed packages."""
    return list(dict.fromkeys([*TARGETS, *list_entry_points(EXPORT_TARGETS)]))


def find_target(name: str) -> ExportTarget:
    """Return a target by its name; UnknownName if there is none, SettingError if a package's cannot be loaded."""
    if name in TARGETS:
        return TARGETS[name]
    if name not in list_targets():
        raise UnknownName(what="target", name=name, where="export", known=list_targets())
    return load_instance(name, EXPORT_TARGETS, ExportTarget, where="export", remedy=REMEDY)
