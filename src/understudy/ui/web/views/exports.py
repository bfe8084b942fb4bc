"""Describe to pages what automata can be exported to."""

from __future__ import annotations

from understudy.addons.export.targets.target_table import find_target, list_targets
from understudy.errors import UnderstudyError
from understudy.ui.web.messages.base import Data


class ExportTargetData(Data, frozen=True, kw_only=True):
    """A target that automata can be exported to."""

    name: str
    single_precision: bool
    """Whether it can be written in single precision, too."""


def describe_export_targets() -> list[ExportTargetData]:
    """Describe the targets; one that cannot be loaded is among them, and an export to it says why."""
    return [
        ExportTargetData(name=name, single_precision=_offers_single_precision(name))
        for name in list_targets()
    ]


def _offers_single_precision(name: str) -> bool:
    try:
        return find_target(name).single_precision
    except UnderstudyError:
        return False
