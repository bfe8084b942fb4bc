"""The requests of the page on which a person drives a robot."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from msgspec import Meta, Struct

from understudy.ui.web.messages.base import Index, Seed

Lean: TypeAlias = Annotated[float, Meta(ge=-1, le=1)]
"""How far a stick leans to one side."""
HeldIndices: TypeAlias = Annotated[list[Index], Meta(max_length=100)]
"""The indices of the behaviors whose buttons are held."""


class DriveRequest(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="do"):
    """A request about the drive under way."""


class SteerRobot(DriveRequest, frozen=True, kw_only=True, tag="steer"):
    """Where the stick is: sent whenever it moves, and again and again while the robot is driven."""

    right: Lean = 0.0
    up: Lean = 0.0
    held: HeldIndices = []


class BeginDriving(DriveRequest, frozen=True, kw_only=True, tag="drive"):
    """Drive, or go on."""


class LetAutomatonDrive(DriveRequest, frozen=True, kw_only=True, tag="let_drive"):
    """Let the automaton that was learned drive, until it is paused or the stick is moved."""


class PauseDriving(DriveRequest, frozen=True, kw_only=True, tag="pause_drive"):
    """Pause, so that the labels can be reviewed."""


class BeginWorld(DriveRequest, frozen=True, kw_only=True, tag="new_world"):
    """Begin another world, as another episode of the drive; by default that of the next seed."""

    seed: Seed | None = None


AnyDriveRequest: TypeAlias = SteerRobot | BeginDriving | LetAutomatonDrive | PauseDriving | BeginWorld
DRIVE_REQUESTS = (SteerRobot, BeginDriving, LetAutomatonDrive, PauseDriving, BeginWorld)
"""All requests of the page on which a person drives."""
