"""The keys of a scenario, for the page about them: units and meanings from here, names and defaults from the code.

After a key changed, bring the page up to date with: python -m tests.docs.scenario_keys
"""

from __future__ import annotations

from collections.abc import Iterator

import msgspec
from msgspec.structs import FieldInfo, fields
from tests.docs.pages import ROOT
from tests.docs.renew import replace_between

from understudy.sim.scenario.schema import (
    AppearanceSchedule,
    ArenaRegion,
    Breakdown,
    Bumper,
    Camera,
    CaptureRule,
    CargoSensor,
    ClaimSensor,
    ElapsedSensor,
    FeatureSpec,
    Goal,
    GripSensor,
    Lidar,
    ObjectClass,
    Obstacle,
    Placement,
    PoseSensor,
    PullRule,
    RandomSensor,
    RandomWalk,
    RobotGroup,
    RobotType,
    Scenario,
    SensorBase,
    Sonar,
    StallSensor,
    TargetLocator,
    TargetSpec,
    Wall,
)
from understudy.sim.scenario.skill_schema import SkillStandIn
from understudy.sim.scenario.squad_schema import (
    AssignmentSpec,
    CommsSpec,
    RoleSpec,
    SquadSpec,
    StatisticSpec,
    StrictStruct,
)

PAGE = ROOT / "docs" / "reference" / "scenario-files.md"
KEYS = (
    "<!-- keys: python -m tests.docs.scenario_keys puts here what the code says -->\n",
    "<!-- end of keys -->",
)

Rows = dict[str, tuple[str, str]]
"""Key -> unit, meaning."""

PARTS: dict[type[StrictStruct], tuple[str, Rows]] = {
    Scenario: (
        "The scenario itself",
        {
            "name": ("", "name of the scenario; the name of the file if left out"),
            "about": ("", "description, one sentence"),
            "size": ("m", "width and height: the arena spans [0, width] × [0, height], with walls around it"),
            "tick_s": ("s", "length of a tick"),
            "limit_s": ("s", "time limit of a run"),
            "walls": ("", "inner walls; see below"),
            "obstacles": ("", "solid things that never move; see below"),
            "regions": ("", "named parts of the arena; see below"),
            "objects": ("", "classes of objects; see below"),
            "types": ("", "types of robots, by name; see below"),
            "robots": ("", "the robots; see below"),
            "targets": ("", "things that features and behaviors can refer to, by name; see below"),
            "features": ("", "features with names of your choice; see below"),
            "squads": ("", "types of squads, by name; see below"),
            "radio": ("", "radio between coordinators and their members; see below"),
            "goal": ("", "when the world is finished; never if left out; see below"),
            "spare_objects": (
                "",
                "number of objects of each class that can be added while it runs; at most 10 000",
            ),
            "generator": (
                "",
                "generator of random numbers: 2 draws the same on all computers, 1 is that of versions before 0.3",
            ),
        },
    ),
    Wall: (
        "`[[walls]]`",
        {
            "points": ("m", "corners of the wall, in order"),
            "closed": ("", "whether the last corner is joined to the first"),
        },
    ),
    ArenaRegion: (
        "`[regions]`: a box, or a circle",
        {
            "box": ("m", "[x0, y0, x1, y1]"),
            "center": ("m", "center of the circle, [x, y]"),
            "radius": ("m", "radius of the circle"),
        },
    ),
    Placement: (
        "Placement: keys of obstacles, objects and robots",
        {
            "count": (
                "",
                "number of things placed at random, or `least, most` (not for robots); "
                "1 if neither `count` nor `at` is given",
            ),
            "at": ("m", "fixed places instead: for each thing [x, y], or [x, y, rotation in degrees]"),
            "within": ("", "region in which the centers of things placed at random lie"),
            "apart": (
                "m",
                "free space around each thing placed at random: the distance from rim to rim, also to walls and bounds",
            ),
            "near": (
                "",
                "class of objects: the things are placed beside its first object, on the side of the arena's center",
            ),
            "near_m": ("m", "distance to that object, from center to center; 0 is the same place"),
        },
    ),
    Obstacle: (
        "`[[obstacles]]`: discs or polygons",
        {
            "radius": ("m", "radius of a disc"),
            "points": (
                "m",
                "corners of a polygon, relative to its place; polygons placed at random have a random rotation",
            ),
            "color": ("", "color of a disc for cameras"),
            "height": ("m", "height for cameras; twice the radius if left out"),
        },
    ),
    ObjectClass: (
        "`[[objects]]`: a class of objects",
        {
            "name": ("", "name of the class"),
            "radius": ("m", "radius of each object"),
            "height": ("m", "height for cameras; twice the radius if left out"),
            "color": ("", "color for cameras; invisible to them if left out"),
            "amount": ("units", "food in each object, or `least, most`"),
            "home": ("", "whether robots can unload food there"),
            "solid": ("", "whether it blocks robots, sonar and cameras"),
            "pushable": ("", "whether robots move it by driving into it; it is then solid"),
            "pushers": ("", "number of robots needed to push it"),
            "pull": ("", "makes it a box that robots grip and pull; see below"),
            "aloft": (
                "",
                "whether it hangs above everything else, so that nothing hides it; it cannot be solid",
            ),
            "presence": ("", "makes it appear and disappear; see below"),
            "capture": ("", "makes robots remove it; see below"),
            "walk": ("", "makes it wander; see below"),
        },
    ),
    PullRule: (
        "`pull` of objects: boxes, which never block anything",
        {
            "robots": ("", "number of robots that must hold the box before it moves"),
            "respawn": ("", "whether it appears again, at a free place, after it was gathered"),
        },
    ),
    AppearanceSchedule: (
        "`presence` of objects: absent at first, each time at a new free place",
        {
            "away_s": ("s", "`least, most`: duration of each absence"),
            "first_s": ("s", "`least, most`: time of the first appearance; as `away_s` if left out"),
            "stays_s": ("s", "`least, most`: duration of each presence; until it is captured if left out"),
        },
    ),
    CaptureRule: (
        "`capture` of objects",
        {
            "range": ("m", "distance at which a robot captures it, from center to center"),
            "after_s": ("s", "time from then until it is removed"),
        },
    ),
    RandomWalk: (
        "`walk` of objects",
        {"speed": ("m/s", "speed"), "turn_s": ("s", "time between changes of direction")},
    ),
    RobotType: (
        "`[types.NAME]`: a type of robot, a disc on two wheels",
        {
            "radius": ("m", "radius of the robot"),
            "speed": ("m/s", "speed at the command drive = 1"),
            "turning_deg": ("°/s", "turning rate at the command turn = 1"),
            "acceleration": ("m/s²", "limit of the acceleration; none if left out"),
            "turning_acceleration_deg": ("°/s²", "limit of the angular acceleration; none if left out"),
            "noise_drive": ("", "standard deviation of the distance driven in a tick, as a share of it"),
            "noise_turn": ("", "standard deviation of the angle turned in a tick, as a share of it"),
            "color": ("", "color for cameras; invisible to them if left out"),
            "team": ("", "team of the robots; the name of the type if left out"),
            "height": ("m", "height for cameras; twice the radius if left out"),
            "capacity": ("units", "amount of food that it can carry"),
            "reach": (
                "m",
                "largest distance to food, a box or a home for loading and unloading, from center to center",
            ),
            "load_s": ("s", "time to load a unit, in whole ticks"),
            "unload_s": ("s", "time to unload a unit, in whole ticks"),
            "collides": ("", "whether it and other robots block each other"),
            "sensors": ("", "its sensors; see below"),
            "behaviors": (
                "",
                "basic behaviors by name: tables of the channels `drive`, `turn`, `load`, `unload` and `signal`",
            ),
            "skills": ("", "behaviors that the robot has by itself, by name; see below"),
        },
    ),
    SkillStandIn: (
        "`[types.NAME.skills.NAME]`: a skill, and its stand-in in simulation",
        {
            "duration_s": ("s", "how long it takes: a number or [least, most]"),
            "success": ("", "probability that it succeeds; otherwise it aborts before its time is over"),
            "parameters": ("", "names of the parameters of its behavior, which states bind to targets"),
            "ends": ("", "where the robot is at the end: a parameter or a target; where it is if left out"),
            "within": ("m", "distance from there, from center to center, at which it ends"),
            "feedback": (
                "",
                "readings while it runs, by name: the `distance` left (m), the `time` since its start (s), or a "
                "`number` that only real robots know",
            ),
            "timeout_s": ("s", "time after which it has timed out"),
            "doc": ("", "description of the behavior"),
        },
    ),
    RobotGroup: (
        "`[[robots]]`: a group of robots of one type",
        {
            "type": ("", "type of the robots"),
            "stored": ("units", "food that each carries at the start"),
            "fails": ("", "which of them fail, and when: a list of the tables below"),
        },
    ),
    Breakdown: (
        "`[[robots.fails]]`: robots of the group that fail for good, and neither sense nor move any more",
        {
            "at_s": ("s", "when each fails, after the start: a number or [least, most]"),
            "count": ("", "how many fail, drawn among them: a number or [least, most]"),
            "robots": ("", "which fail, instead of `count`: their numbers in the group, from 0"),
        },
    ),
    TargetSpec: (
        "`[targets]`: `nearest`, `object`, `team`, `robot`, `color` or `signal`; `team` and `robot` also with `signal`",
        {
            "nearest": (
                "",
                "the nearest object of this class; of sources of food, the nearest with food left",
            ),
            "object": ("", "a particular object of this class; see `index`"),
            "index": ("", "number of that object in its class, from 0"),
            "team": ("", "the nearest other robot of this team"),
            "robot": ("", "the nearest other robot that is a `teammate`, an `opponent` or `any`"),
            "color": ("", "anything of this color, for cameras"),
            "signal": ("", "the nearest other robot that raises this signal"),
            "unclaimed": (
                "",
                "with `nearest`: skips objects that another robot claims by raising this signal",
            ),
            "within": ("m", "with `unclaimed`: largest distance at which a robot claims an object"),
            "doc": ("", "description, one sentence"),
        },
    ),
    FeatureSpec: (
        "`[features]`: each replaces the usual feature of its reading",
        {"reading": ("", "the reading"), "doc": ("", "description, one sentence")},
    ),
    SquadSpec: (
        "`[squads.NAME]`: a type of squad",
        {
            "doc": ("", "description, one sentence"),
            "count": (
                "",
                "number of squads; if left out, as many as reach their preferred sizes; 1 if no role has `preferred`",
            ),
            "drops": (
                "",
                "a yes-or-no reading, such as `stuck`: members that read yes are no longer counted",
            ),
            "members": ("", "roles, by name; see below"),
            "statistics": ("", "readings of its coordinator, by name; see below"),
            "orders": (
                "",
                "further orders of its coordinator, besides its members' behaviors: lists of assignments, by name",
            ),
        },
    ),
    RoleSpec: (
        "`[squads.NAME.members.ROLE]`: the number of members in each squad",
        {
            "of": ("", "a type of robot, or another type of squad"),
            "least": ("", "number that every squad gets first"),
            "preferred": ("", "number up to which squads are then filled; as `least` if left out"),
            "most": ("", "largest number; no limit if left out"),
        },
    ),
    StatisticSpec: (
        "`[squads.NAME.statistics]`: computed from a reading or a flag of each member",
        {
            "how": (
                "",
                "`any`, `all`, `none`, `count` or `fraction`; `mean`, `minimum`, `maximum` or `spread`; `centroid`",
            ),
            "reading": (
                "",
                "members' reading; `any`, `all`, `none`, `count` and `fraction` test whether it is yes or present",
            ),
            "flag": ("", "flag of the members: whether it is raised"),
            "role": ("", "counts only members in this role"),
            "least": ("the reading's", "counts readings of at least this value"),
            "below": ("the reading's", "counts readings below this value"),
            "within_s": (
                "s",
                "whether it held at some moment of the last seconds; of a number, its mean (or extreme) over this time",
            ),
            "since": ("", "reads instead how long ago it last held, in s"),
            "for_s": ("s", "whether it has held for this long without a break"),
            "doc": ("", "description, one sentence"),
        },
    ),
    AssignmentSpec: (
        "Assignments in `[squads.NAME.orders]`: each member gets the first that fits it and has room",
        {
            "run": ("", "behavior that the members run"),
            "with": ("", "targets for its parameters: `{ A = target }`"),
            "role": ("", "restricts it to members in this role"),
            "share": ("", 'number of members, or a fraction such as `"1/3"`; all that remain if left out'),
        },
    ),
    CommsSpec: (
        "`[radio]`: delay and loss of orders and reports between coordinators and their members",
        {
            "delay_s": ("s", "delay of each order and report"),
            "loss": ("", "probability that one is lost"),
        },
    ),
    Goal: (
        "`[goal]`: exactly one of `delivered`, `gathered` and `target`",
        {
            "delivered": ("", "reached when all food is at home"),
            "gathered": ("", "reached when this many boxes were gathered"),
            "target": ("", "reached when a robot is near an object of this class"),
            "within": ("m", "largest distance to that object, from center to center"),
            "all": ("", "whether all robots must be near one"),
        },
    ),
    SensorBase: (
        "All sensors",
        {
            "dropout": ("", "probability that a measurement fails: the reading is then absent"),
            "rate_hz": (
                "1/s",
                "frequency of measurements, between which the reading stays as it is; every tick if left out",
            ),
        },
    ),
    Sonar: (
        '`kind = "sonar"` reads a distance for each sector (m)',
        {
            "sectors": (
                "°",
                "name of a reading = [from, to], counter-clockwise from ahead; a single beam if both are equal",
            ),
            "range": ("m", "largest distance, and its reading when nothing reflects"),
            "noise": ("m", "standard deviation"),
            "sees": ("", "things that reflect"),
        },
    ),
    Lidar: (
        '`kind = "lidar"` reads distances along beams, and summaries of them for each sector (m, bearings in rad)',
        {
            "view_deg": ("°", "width of its field of view, symmetric about ahead; 360 is all around"),
            "beams": (
                "",
                "number of beams, 1 to 2048, evenly spread: readings `beam_0`, `beam_1`, ..., counter-clockwise",
            ),
            "range": ("m", "largest distance, and its reading when nothing is hit"),
            "noise": ("m", "standard deviation"),
            "sectors": (
                "°",
                "NAME = [from, to], for three readings: `NAME` (distance of the nearest thing), `NAME_bearing` "
                "(its direction) and `NAME_width` (width of the widest opening)",
            ),
            "clear": ("m", "length from which a beam counts as part of an opening; at most `range`"),
            "name": ("", "first part of the names of the beams' readings"),
            "sees": ("", "things that reflect"),
        },
    ),
    Camera: (
        '`kind = "camera"` reads `blob_x` and `blob_size` of a target (px)',
        {
            "view_deg": ("°", "width of its field of view"),
            "width_px": ("px", "width of its picture"),
            "height_px": ("px", "height of its picture"),
            "range": ("m", "largest distance; no limit if left out"),
            "choose": ("", "which blob counts if there are several of the color: `largest` or `nearest`"),
            "least_px": ("px", "size of the smallest blob that it sees"),
            "noise_x": ("px", "standard deviation of `blob_x`"),
            "noise_size": ("", "standard deviation of `blob_size`, as a share of it"),
            "misses": ("", "probability that a blob is missed"),
            "ghosts": ("", "probability that a blob is seen where there is none"),
        },
    ),
    TargetLocator: (
        '`kind = "locator"` reads `range` (m) and `bearing` (rad) of a target; nothing hides targets from it',
        {
            "targets": ("", "names of its targets; if left out, all that no other locator of the type names"),
            "range": ("m", "largest distance; no limit if left out"),
            "noise_range": ("m", "standard deviation of `range`"),
            "noise_deg": ("°", "standard deviation of `bearing`"),
        },
    ),
    PoseSensor: (
        '`kind = "pose"` reads `x`, `y` (m), `heading` (rad), `speed` (m/s) and `turning` (rad/s)',
        {
            "noise": ("m", "standard deviation of `x` and `y`, and of `speed` (m/s)"),
            "noise_deg": ("°", "standard deviation of `heading`, and of `turning` (°/s)"),
        },
    ),
    Bumper: (
        '`kind = "bumper"` reads for each sector whether the robot touches something (yes or no)',
        {"sectors": ("°", "name of a reading = [from, to]")},
    ),
    StallSensor: (
        '`kind = "stuck"` reads `stuck`: whether the robot moves less than a tenth as far as it tries to (yes or no)',
        {"after_s": ("s", "how long this must have lasted")},
    ),
    CargoSensor: (
        '`kind = "cargo"` reads `food_here`, `food_stored` (units), `food_left` and `station_here` (yes or no)',
        {},
    ),
    GripSensor: (
        '`kind = "holding"` reads whether the robot is `holding` a box, and whether `enough` robots hold that box',
        {},
    ),
    ClaimSensor: (
        '`kind = "claimed"` reads whether another robot claims a target, which must be an object (yes or no)',
        {
            "signal": ("", "signal by which robots claim objects"),
            "range": ("m", "largest distance at which a robot claims an object"),
            "name": ("", "name of the reading"),
            "targets": ("", "names of its targets; all that are objects if left out"),
        },
    ),
    RandomSensor: (
        '`kind = "random"` reads a number from 0 to 1',
        {
            "name": ("", "name of the reading"),
            "every_s": ("s", "time between draws; a draw every tick if left out"),
        },
    ),
    ElapsedSensor: (
        '`kind = "since"` reads how long ago another reading was last present, or last yes (s)',
        {
            "name": ("", "name of the reading"),
            "of": ("", "the other reading: one of targets, or one that is yes or no"),
        },
    ),
}


def table() -> str:
    """The part of the page with all keys."""
    return "\n" + "\n".join(line for part in PARTS for line in _section(part)) + "\n"


def own_fields(part: type[StrictStruct]) -> list[FieldInfo]:
    """The fields that a part does not inherit."""
    inherited = {field.name for base in part.__mro__[1:] if base in PARTS for field in fields(base)}
    return [field for field in fields(part) if field.name not in inherited]


def _section(part: type[StrictStruct]) -> Iterator[str]:
    title, rows = PARTS[part]
    yield f"**{title}**\n"
    listed = own_fields(part)
    if listed:
        yield "| key | unit | default | |"
        yield "|---|---|---|---|"
    for field in listed:
        unit, meaning = rows[field.encode_name]
        yield f"| `{field.encode_name}` | {unit} | {_default(field)} | {meaning} |"
    if listed:
        yield ""


def _default(field: FieldInfo) -> str:
    if field.default_factory is not msgspec.NODEFAULT:
        made = field.default_factory()
        inside = ", ".join(f"{key} = {list(value)}" for key, value in made.items())
        return f"`{{ {inside} }}`" if inside else "none"
    default = field.default
    if default is msgspec.NODEFAULT:
        return "**must be given**"
    if default is None or isinstance(default, msgspec.UnsetType | StrictStruct) or default in ((), ""):
        return ""
    if isinstance(default, bool):
        return str(default).lower()
    return ", ".join(map(str, default)) if isinstance(default, tuple) else f"{default}"


if __name__ == "__main__":
    replace_between(PAGE, KEYS, table())
