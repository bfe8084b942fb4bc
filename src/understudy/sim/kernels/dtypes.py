"""NumPy record types that Python and the world kernels share.

Lengths are in m and angles in rad; speeds in TYPE and ROBOT are per tick. Fields that are used together are adjacent.
Whole numbers have 64 bits, like those in kernels, so that no kernel is compiled again for narrower ones. A few of
ROBOT have 32 bits, so that the record fits into 128 bytes, two cache lines.
"""

from __future__ import annotations

import numpy as np

from understudy.sim.sensing.sectors import SECTOR

THING = np.dtype(
    [
        ("x", "f8"),
        ("y", "f8"),
        ("radius", "f8"),
        ("height", "f8"),
        ("color", "i4"),  # index, -1 none
        ("opaque", "i4"),  # 1: hides what is behind it; 0: does not; -1: nothing hides it either
    ],
    align=True,
)
"""A disc as a camera may see it."""

VIEW = np.dtype(
    [
        ("left", "f8"),  # where it appears, cut by the frame
        ("right", "f8"),
        ("power", "f8"),  # of the camera with respect to a disc: its tangents' length squared
        ("squared", "f8"),  # distance to a disc's center, squared
        ("height_px", "f8"),
        ("nearness", "f8"),  # of a segment: 1 / distance along the view, in the middle of the frame
        ("slope", "f8"),  # and by how much that grows across the frame
        ("cut_left", "f8"),  # memory for what hides one view: the list of cuts has no relation to this view
        ("cut_right", "f8"),
        ("color", "i4"),  # of a disc; -1: no blob, it only hides others
        ("opaque", "i4"),
    ],
    align=True,
)
"""The projection of a disc or a segment into a camera's image."""


ROBOT = np.dtype(
    [
        ("x", "f8"),
        ("y", "f8"),
        ("heading", "f8"),  # [0, tau)
        ("aim", "f8"),  # the heading whose cosine and sine are kept; NaN none yet
        ("cosine", "f8"),
        ("sine", "f8"),
        ("speed", "f8"),  # m per tick, along the heading, as its wheels would have it
        ("spin", "f8"),  # rad per tick
        ("id", "i8"),  # within its world
        ("type", "i8"),
        ("stored", "i8"),  # units of food
        ("loading", "i4"),  # ticks spent on the unit at hand
        ("unloading", "i4"),
        ("delivered", "i8"),
        ("blocked", "i8"),  # ticks in a row that it drove and got nowhere
        ("frozen", "i8"),  # 1: neither senses nor moves (a robot that failed)
        ("holding", "i4"),  # the slot of the box it holds + 1; 0 none
        ("signal", "i4"),  # what it raises for others to see, counted from 1; 0 nothing
    ],
    align=True,
)

TYPE = np.dtype(
    [
        ("radius", "f8"),
        ("height", "f8"),
        ("speed", "f8"),  # m per tick of drive = 1
        ("turning", "f8"),  # rad per tick of turn = 1
        ("acceleration", "f8"),  # m per tick, per tick; infinite where there is no limit
        ("turning_acceleration", "f8"),
        ("noise_drive", "f8"),  # share of the motion of a tick
        ("noise_turn", "f8"),
        ("reach", "f8"),
        ("color", "i8"),  # index, -1 none
        ("team", "i8"),  # index
        ("capacity", "i8"),
        ("load_ticks", "i8"),
        ("unload_ticks", "i8"),
        ("collides", "i8"),
    ],
    align=True,
)

OBJECT = np.dtype(
    [
        ("x", "f8"),
        ("y", "f8"),
        ("heading", "f8"),  # of one that walks
        ("present", "i8"),
        ("amount", "i8"),
        ("at_first", "i8"),
        ("appeared", "i8"),  # times it has appeared, which keys the next draw of a place
        ("due", "i8"),  # tick at which it appears or leaves; -1 never
        ("captured", "i8"),  # tick at which a robot first came within range; -1 not yet
        ("hands", "i8"),  # robots that hold it
        ("gathered", "i8"),  # times it was brought home
    ],
    align=True,
)

CLASS = np.dtype(
    [
        ("radius", "f8"),
        ("height", "f8"),
        ("capture_range", "f8"),  # NaN: cannot be captured
        ("walk", "f8"),  # m per tick; 0 stays
        ("away_least", "f8"),  # s; NaN: always present
        ("away_most", "f8"),
        ("stays_least", "f8"),  # s; NaN: until captured
        ("stays_most", "f8"),
        ("apart", "f8"),
        ("region", "f8", 4),  # box in which it appears and walks
        ("first", "i8"),  # its slots among the objects of a world: first, and one after the last
        ("end", "i8"),
        ("color", "i8"),
        ("food", "i8"),
        ("home", "i8"),
        ("solid", "i8"),
        ("pushable", "i8"),
        ("pushers", "i8"),
        ("opaque", "i8"),  # as a THING's
        ("pull", "i8"),  # robots it takes to pull it; 0: it cannot be pulled
        ("respawn", "i8"),  # appears again once it is gathered
        ("capture_ticks", "i8"),
        ("turn_ticks", "i8"),
    ],
    align=True,
)

DISC = np.dtype([("x", "f8"), ("y", "f8"), ("radius", "f8"), ("height", "f8"), ("color", "i8")], align=True)
"""A round obstacle; there is none if the radius is 0."""

SEGMENT = np.dtype([("x0", "f8"), ("y0", "f8"), ("x1", "f8"), ("y1", "f8"), ("wall", "i8")], align=True)
"""A piece of a wall, or (`wall` 0) an edge of a polygonal obstacle; there is none if an end is NaN."""

SPOT = np.dtype([("x", "f8"), ("y", "f8"), ("row", "i8"), ("id", "i8")], align=True)
"""A robot's entry in the sorted order of a grid, next to those of the same cell."""

MOVE = np.dtype(
    [
        ("dx", "f8"),
        ("dy", "f8"),
        ("heading", "f8"),
        ("wanted", "f8"),  # how far it would go if nothing were in its way
        ("scale", "f8"),  # the share of its step that it may
        ("alone", "f8"),  # m**2; no other robot is nearer, as far as was seen
    ],
    align=True,
)
"""A robot's intended step in a tick."""

WORK = np.dtype(
    [
        ("load", "f8"),  # as commanded
        ("unload", "f8"),
        ("still", "i8"),  # commanded neither to drive nor to turn
        ("slot", "i8"),  # the source it is about to get a unit of, and how many get one before it
        ("order", "i8"),
        ("signal", "i8"),  # raised from this tick on
    ],
    align=True,
)
"""A robot's intended actions in a tick other than moving."""

PUSH = np.dtype(
    [("dx", "f8"), ("dy", "f8"), ("scale", "f8"), ("sum_x", "i8"), ("sum_y", "i8"), ("count", "i8")],
    align=True,
)
"""The step (dx, dy) of a pushed box in a tick, its permitted share (scale), and the sum and number of pushes."""

PULL = np.dtype(
    [
        ("dx", "f8"),
        ("dy", "f8"),
        ("scale", "f8"),
        ("slowest", "f8"),  # of the robots that hold it, m per tick
        ("sum_x", "i8"),
        ("sum_y", "i8"),
        ("count", "i8"),
    ],
    align=True,
)
"""The step (dx, dy) of a pulled box in a tick, its permitted share (scale), and the sum and number of pulls."""

OFFSET = np.dtype([("x", "f8"), ("y", "f8")])
"""A vector from a robot to something, m; NaN if it is absent."""

(
    TO_CLASS, TO_OBJECT, TO_ROBOT, TO_UNCLAIMED, TO_CALLER, SONAR, CAMERA, BUMPER,
    OWN_X, OWN_Y, OWN_HEADING, OWN_SPEED, OWN_TURNING,
    STUCK, STORED, FOOD_HERE, FOOD_LEFT, STATION_HERE, HOLDING, ENOUGH, CHANCE, SINCE, CLAIMED, LIDAR,
) = range(24)  # fmt: skip
"""The possible measurements of a step of a sense plan: values of `what` of a STEP."""

ALONG_BEAM, NEAREST_RETURN, WIDEST_OPENING = range(3)
"""The possible readings of a part of a lidar's step: values of `of` of a PART."""

WALLS, OBSTACLES, ROBOTS = 1, 2, 4
"""The kinds of things that a range sensor detects: bits of `sees` of a STEP."""

ANYONE, TEAMMATE, OPPONENT, TEAM = 0, 1, 2, 3
"""The robots that a target can refer to: values of `index` of a STEP TO_ROBOT; a team is TEAM + its index."""

STEP = np.dtype(
    [
        ("range", "f8"),
        ("within", "f8"),  # m; how near to a thing a robot claims it
        ("noise_a", "f8"),
        ("noise_b", "f8"),
        ("dropout", "f8"),
        ("tan_half", "f8"),  # of a camera, as all down to ghosts
        ("width_px", "f8"),
        ("height_px", "f8"),
        ("least_px", "f8"),
        ("misses", "f8"),
        ("ghosts", "f8"),
        ("first_rad", "f8"),  # of a lidar, as all down to beams: direction of its first beam, robot frame
        ("spacing", "f8"),  # rad from one beam to the next
        ("clear", "f8"),  # m from the rim
        ("beams", "i8"),
        ("noisy", "i8"),  # has noise, dropout or the like
        ("what", "i8"),  # as listed above
        ("place", "i8"),  # what is to be located first, as `what` has it; -1 nothing
        ("signal", "i8"),  # that the wanted robots, or the claiming ones, raise
        ("index", "i8"),  # class, object slot, relation of a robot, source column of SINCE
        ("nearest", "i8"),
        ("sees", "i8"),  # WALLS | OBSTACLES | ROBOTS
        ("period", "i8"),  # ticks between measurements
        ("ticks", "i8"),  # of STUCK and CHANCE
        ("stream", "i8"),
        ("first", "i8"),  # its parts: first, and one after the last
        ("end", "i8"),
    ],
    align=True,
)

PART = np.dtype(
    [
        ("a", "i8"),  # columns that the readings go to; -1 nowhere
        ("b", "i8"),
        ("held", "i8"),  # memory slot of a (b's is the next); -1 none
        ("color", "i8"),
        ("number", "i8"),
        ("of", "i8"),  # of a lidar, as all that follow: what is read
        ("beam", "i8"),  # the first beam of its sector, and how many there are
        ("beams", "i8"),
    ],
    align=True,
)

__all__ = ["SECTOR", "THING", "VIEW"]

TOUCH = 0.005
"""The distance below which a bumper touches a thing, m."""

FACTS = np.dtype(
    [
        ("width", "f8"),
        ("height", "f8"),
        ("tick_s", "f8"),
        ("goal_within", "f8"),
        ("per_cell", "f8"),
        ("near_per_cell", "f8"),
        ("cell", "f8"),  # of the robots' grid, as all down to gridded
        ("most_radius", "f8"),
        ("most_step", "f8"),
        ("drift", "f8"),  # m; so far may robots have gone since they were sorted
        ("keep", "i8"),  # ticks from one sorting to the next
        ("columns", "i8"),
        ("lines", "i8"),
        ("shift", "i8"),
        ("gridded", "i8"),
        ("near_columns", "i8"),  # of the lists of what stays
        ("near_lines", "i8"),
        ("count", "i8"),  # N, robots in a world
        ("goal", "i8"),
        ("goal_target", "i8"),
        ("goal_count", "i8"),
        ("type_count", "i8"),
        ("class_count", "i8"),
        ("object_count", "i8"),
        ("disc_count", "i8"),
        ("segment_count", "i8"),
        ("memory_count", "i8"),
        ("width_of_row", "i8"),
        ("passable", "i8"),  # some robots let others pass, so that two may be in the same place
        ("lines_up", "i8"),  # objects of some class are looked for
        ("signals", "i8"),
        ("solids", "i8"),
        ("failing", "i8"),  # some robots fail at a time
        ("generator", "i8"),  # of random numbers
    ],
    align=True,
)
"""Constants and sizes of the worlds and of the working memory, for kernels."""
