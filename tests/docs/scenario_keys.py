"""The keys of a scenario, for the page about them: their units and meanings here, the rest from the code.

After a key changed, bring the page up to date with: python -m tests.docs.scenario_keys
"""

from __future__ import annotations

from collections.abc import Iterator

import msgspec
from msgspec.structs import FieldInfo, fields
from tests.docs.pages import ROOT
from tests.docs.renew import put_between

from understudy.sim.scenario.schema import (
    AppearanceSchedule,
    ArenaRegion,
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
from understudy.sim.scenario.squad_schema import (
    AssignmentSpec,
    CommsSpec,
    RoleSpec,
    SquadSpec,
    StatisticSpec,
    StrictStruct,
)

PAGE = ROOT / "docs" / "scenarios.md"
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
            "name": ("", "its name; left out in a file, that of the file"),
            "about": ("", "what it is, in a sentence"),
            "size": ("m", "width and height: the arena spans [0, width] × [0, height], with walls around it"),
            "tick_s": ("s", "length of a tick"),
            "limit_s": ("s", "how long a run of it takes at most"),
            "walls": ("", "inner walls, see below"),
            "obstacles": ("", "what is solid and stays, see below"),
            "regions": ("", "parts of the arena by name, see below"),
            "objects": ("", "classes of objects, see below"),
            "types": ("", "types of robots by name, see below"),
            "robots": ("", "the robots, see below"),
            "targets": ("", "what features and behaviors can refer to, by name, see below"),
            "features": ("", "features under names of their own, see below"),
            "squads": ("", "sorts of squads by name, see below"),
            "radio": ("", "between coordinators and their members, see below"),
            "goal": ("", "when it is finished, see below; never where it is left out"),
            "spare_objects": (
                "",
                "how many objects of each class can be added while it runs, 10 000 at most",
            ),
        },
    ),
    Wall: (
        "`[[walls]]`",
        {
            "points": ("m", "corners of the wall, one after the other"),
            "closed": ("", "whether the last is joined to the first"),
        },
    ),
    ArenaRegion: (
        "`[regions]`: a box, or a circle",
        {
            "box": ("m", "[x0, y0, x1, y1]"),
            "center": ("m", "[x, y]"),
            "radius": ("m", "of the circle"),
        },
    ),
    Placement: (
        "Places: obstacles, objects and robots have these",
        {
            "count": ("", "how many are put at random; or `least, most`, except for robots; one if left out"),
            "at": ("m", "given places instead: [x, y], or [x, y, how far it is turned in degrees] each"),
            "within": ("", "the region of the centers of the random ones"),
            "apart": (
                "m",
                "free space around each of the random ones, from rim to rim, walls and bounds included",
            ),
            "near": (
                "",
                "a class of objects: they are beside its first one, on the side of the arena's center",
            ),
            "near_m": ("m", "how far from it, from center to center; 0 is right there"),
        },
    ),
    Obstacle: (
        "`[[obstacles]]`: round, or polygons",
        {
            "radius": ("m", "of a round one"),
            "points": ("m", "corners of a polygon around its place; random ones are turned at random"),
            "color": ("", "what cameras see of a round one"),
            "height": ("m", "how high a camera sees it; 2 radii if left out"),
        },
    ),
    ObjectClass: (
        "`[[objects]]`: a class of objects",
        {
            "name": ("", "of the class"),
            "radius": ("m", ""),
            "height": ("m", "how high a camera sees it; 2 radii if left out"),
            "color": ("", "what cameras see of it; nothing if left out"),
            "amount": ("units", "food in it; or `least, most`"),
            "home": ("", "whether food is unloaded there"),
            "solid": ("", "whether it stops robots, sonar and sight"),
            "pushable": ("", "whether robots move it by driving into it; solid then"),
            "pushers": ("", "how many robots it takes to push it"),
            "pull": ("", "see below: a box that robots take hold of, and pull"),
            "aloft": ("", "whether it hangs above all else, so that nothing hides it; not solid then"),
            "presence": ("", "see below: it comes and goes"),
            "capture": ("", "see below: robots remove it"),
            "walk": ("", "see below: it wanders"),
        },
    ),
    PullRule: (
        "`pull` of objects: boxes, which are in nobody's way",
        {
            "robots": ("", "how many must hold it, so that it moves"),
            "respawn": ("", "whether it appears at a free place again once it is gathered"),
        },
    ),
    AppearanceSchedule: (
        "`presence` of objects: begins absent, appears at free places",
        {
            "away_s": ("s", "`least, most`: how long it is away"),
            "first_s": ("s", "`least, most`: when it first appears; as `away_s` if left out"),
            "stays_s": ("s", "`least, most`: how long it stays; until captured if left out"),
        },
    ),
    CaptureRule: (
        "`capture` of objects",
        {
            "range": ("m", "how near a robot must come, from center to center"),
            "after_s": ("s", "how long after that it is removed"),
        },
    ),
    RandomWalk: (
        "`walk` of objects",
        {"speed": ("m/s", "how fast it wanders"), "turn_s": ("s", "how often it takes a new direction")},
    ),
    RobotType: (
        "`[types.NAME]`: a disc on two wheels",
        {
            "radius": ("m", ""),
            "speed": ("m/s", "of the command drive = 1"),
            "turning_deg": ("°/s", "of the command turn = 1"),
            "acceleration": ("m/s²", "how fast it gets to its speed; at once if left out"),
            "turning_acceleration_deg": ("°/s²", "the same for turning"),
            "noise_drive": ("", "standard deviation of the way driven in a tick, as a share of it"),
            "noise_turn": ("", "the same for turning"),
            "color": ("", "what cameras see of it; nothing if left out"),
            "team": ("", "its team; the name of the type if left out"),
            "height": ("m", "how high a camera sees it; 2 radii if left out"),
            "capacity": ("units", "how much food it carries"),
            "reach": ("m", "how near to food, a box or home it must stand, from center to center"),
            "load_s": ("s", "how long it takes to load a unit, in whole ticks"),
            "unload_s": ("s", "how long it takes to unload a unit, in whole ticks"),
            "collides": ("", "whether it and other robots are in each other's way"),
            "sensors": ("", "see below"),
            "behaviors": (
                "",
                "basic behaviors by name: tables of channels, `drive`, `turn`, `load`, `unload` and `signal`",
            ),
        },
    ),
    RobotGroup: (
        "`[[robots]]`: of one type",
        {"type": ("", "their type"), "stored": ("units", "food they carry at first")},
    ),
    TargetSpec: (
        "`[targets]`: exactly one of the first four, `color` and `signal`; `signal` also beside `team` or `robot`",
        {
            "nearest": ("", "the nearest object of this class; of food, one with food left"),
            "object": ("", "an object of this class"),
            "index": ("", "which one of them"),
            "team": ("", "the nearest other robot of this team"),
            "robot": ("", "the nearest other robot that is a `teammate`, an `opponent` or `any`"),
            "color": ("", "whatever has this color, for cameras"),
            "signal": ("", "the nearest other robot that raises this signal"),
            "unclaimed": (
                "",
                "beside `nearest`: passes over what another robot claims by raising this signal",
            ),
            "within": ("m", "so near to a thing, or nearer, a robot claims it"),
            "doc": ("", "what it is, in a sentence"),
        },
    ),
    FeatureSpec: (
        "`[features]`: instead of the reading's usual feature",
        {"reading": ("", "what it reads"), "doc": ("", "what it is, in a sentence")},
    ),
    SquadSpec: (
        "`[squads.NAME]`: a sort of squad",
        {
            "doc": ("", "what it is, in a sentence"),
            "count": (
                "",
                "how many; if left out, as many as get the members they prefer, one where no role prefers any",
            ),
            "drops": ("", "a yes-or-no reading, such as `stuck`: members who read yes are counted no more"),
            "members": ("", "roles by name, see below"),
            "statistics": ("", "what its coordinator senses, by name, see below"),
            "orders": ("", "what it can order beside its members' behaviors: lists of duties by name"),
        },
    ),
    RoleSpec: (
        "`[squads.NAME.members.ROLE]`: so many in each squad",
        {
            "of": ("", "a type of robots, or another sort of squad"),
            "least": ("", "every squad gets so many"),
            "preferred": ("", "then up to so many; as `least` if left out"),
            "most": ("", "then up to so many; any number if left out"),
        },
    ),
    StatisticSpec: (
        "`[squads.NAME.statistics]`: of a reading or a flag of each member",
        {
            "how": (
                "",
                "`any`, `all`, `none`, `count` or `fraction`; `mean`, `minimum`, `maximum` or `spread`; `centroid`",
            ),
            "reading": ("", "what members read: whether it is yes, or there at all; or its value"),
            "flag": ("", "whether members have raised it"),
            "role": ("", "of members in this role only"),
            "least": ("the reading's", "whether it is at least so much"),
            "below": ("the reading's", "and below so much"),
            "within_s": (
                "s",
                "whether it was so in the last seconds; of a number, its mean (or extreme) over them",
            ),
            "since": ("", "how long ago it was last so, s"),
            "for_s": ("s", "whether it has been so for as long"),
            "doc": ("", "what it is, in a sentence"),
        },
    ),
    AssignmentSpec: (
        "Duties of `[squads.NAME.orders]`: of several that fit a member, the first with room",
        {
            "run": ("", "the behavior that members are to run"),
            "with": ("", "targets for its parameters: `{ A = target }`"),
            "role": ("", "only for members in this role"),
            "share": ("", 'how many of them, or what part: `"1/3"`; all that are left if left out'),
        },
    ),
    CommsSpec: (
        "`[radio]`: what orders and reports between coordinators and their members suffer",
        {
            "delay_s": ("s", "how long they travel"),
            "loss": ("", "chance that one gets lost"),
        },
    ),
    Goal: (
        "`[goal]`",
        {
            "delivered": ("", "all food is at home"),
            "gathered": ("", "or so many boxes were gathered"),
            "target": ("", "or a robot is near an object of this class"),
            "within": ("m", "how near, from center to center"),
            "all": ("", "whether all robots must be"),
        },
    ),
    SensorBase: (
        "All sensors",
        {
            "dropout": ("", "chance that a measurement gives no answer: the reading is absent"),
            "rate_hz": (
                "1/s",
                "how often it measures, keeping its answer in between; every tick if left out",
            ),
        },
    ),
    Sonar: (
        '`kind = "sonar"` reads a distance for each sector, m',
        {
            "sectors": ("°", "name of a reading = [from, to], counter-clockwise from ahead; equal: a beam"),
            "range": ("m", "how far it hears, and what it reads where it hears nothing"),
            "noise": ("m", "standard deviation"),
            "sees": ("", "what reflects"),
        },
    ),
    Lidar: (
        '`kind = "lidar"` reads distances along beams, and sums them up in sectors (m, bearings in rad)',
        {
            "view_deg": ("°", "width of its view, symmetric about ahead; 360 is all around"),
            "beams": ("", "how many, 1 to 2048, evenly spread: readings `beam_0` and on, counter-clockwise"),
            "range": ("m", "how far it sees, and what it reads where it hits nothing"),
            "noise": ("m", "standard deviation"),
            "sectors": (
                "°",
                "name = [from, to]; readings by that name (the nearest), `…_bearing` (where that is) and `…_width` "
                "(how wide the widest opening is)",
            ),
            "clear": ("m", "beams that reach this far make an opening; the range at most"),
            "name": ("", "of the beams' readings"),
            "sees": ("", "what reflects"),
        },
    ),
    Camera: (
        '`kind = "camera"` reads `blob_x` and `blob_size` of a target, px',
        {
            "view_deg": ("°", "width of its view"),
            "width_px": ("px", "width of its picture"),
            "height_px": ("px", "height of its picture"),
            "range": ("m", "how far it sees; any distance if left out"),
            "choose": ("", "which blob of the color counts: `largest` or `nearest`"),
            "least_px": ("px", "the smallest blob that it sees"),
            "noise_x": ("px", "standard deviation of `blob_x`"),
            "noise_size": ("", "standard deviation of `blob_size`, as a share of it"),
            "misses": ("", "chance that a blob is not seen"),
            "ghosts": ("", "chance that one is seen where there is none"),
        },
    ),
    TargetLocator: (
        '`kind = "locator"` reads `range` (m) and `bearing` (rad) of a target, through everything',
        {
            "targets": ("", "of which targets; if left out, of all that no other locator of the type names"),
            "range": ("m", "how far it reaches; any distance if left out"),
            "noise_range": ("m", "standard deviation"),
            "noise_deg": ("°", "standard deviation"),
        },
    ),
    PoseSensor: (
        '`kind = "pose"` reads `x`, `y` (m), `heading` (rad), `speed` (m/s) and `turning` (rad/s)',
        {
            "noise": ("m", "standard deviation of the place"),
            "noise_deg": ("°", "standard deviation of the heading"),
        },
    ),
    Bumper: (
        '`kind = "bumper"` reads yes or no for each sector',
        {"sectors": ("°", "name of a reading = [from, to]")},
    ),
    StallSensor: (
        '`kind = "stuck"` reads `stuck`, yes or no',
        {"after_s": ("s", "how long it has been driving without getting anywhere")},
    ),
    CargoSensor: (
        '`kind = "cargo"` reads `food_here`, `food_stored` (units), `food_left` and `station_here` (yes or no)',
        {},
    ),
    GripSensor: (
        '`kind = "holding"` reads `holding` (a box) and `enough` (so many hold it that it moves), yes or no',
        {},
    ),
    ClaimSensor: (
        '`kind = "claimed"` reads whether another robot claims a target that is an object, yes or no',
        {
            "signal": ("", "which robots raise that claim something"),
            "range": ("m", "so near to a thing, or nearer, a robot claims it"),
            "name": ("", "of the reading"),
            "targets": ("", "of which targets; of all that are objects if left out"),
        },
    ),
    RandomSensor: (
        '`kind = "random"` reads a number from 0 to 1',
        {
            "name": ("", "of the reading"),
            "every_s": ("s", "how often it is drawn anew; every tick if left out"),
        },
    ),
    ElapsedSensor: (
        '`kind = "since"` reads how long ago another reading was last there, or last yes, s',
        {
            "name": ("", "of the reading"),
            "of": ("", "the other reading: of a target, or one that is yes or no"),
        },
    ),
}


def table() -> str:
    """The part of the page with all keys."""
    return "\n" + "\n".join(line for part in PARTS for line in _section(part)) + "\n"


def own_fields(part: type[StrictStruct]) -> list[FieldInfo]:
    """The fields that a part has beside those of what it is a sort of."""
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
    put_between(PAGE, KEYS, table())
