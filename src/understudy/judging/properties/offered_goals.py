"""Goals that are offered for a behavior without a flag: properties that fit what was shown, to pick one of them.

Without a flag, nothing that was taught says what success means, so that it cannot be measured: a wall follower has no
*done*. What was kept while it was taught is a good guess.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import ceil, floor, inf, isinf, log10

import numpy as np
from numpy.typing import NDArray

from understudy.errors import join_names
from understudy.judging.evaluate import choose_success_flag, find_success_flag
from understudy.judging.properties.free_space import CELL_M, COVERED, TOUCHED, UNITS
from understudy.learning.shown_ranges import find_shown_range
from understudy.learning.training_set import select_teaching_examples
from understudy.model.features import BoundFeature, Feature
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.model.property import RAISED, Property, PropertyKind, SeededWorlds
from understudy.model.value_kinds import Column, Continuous
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World

RUN_S = 60.0
"""The longest run of each world, s."""
KEPT = 0.8
"""The share of the moments of a lesson that lie in a range of values that was kept."""
LARGEST_SHARE = 1 / 3
"""The largest share of all values in a lesson that such a range can cover."""
FEWEST_MOMENTS = 5
"""The least number of moments from which it is concluded that something was kept."""
LEAST_BREAK_S, BREAK = 5.0, 1.5
"""The time that a value may be outside of its range: at least, s, and in times of the longest that was shown."""
COVERED_SHARE = 0.25
"""The share that is demanded of the ground that a robot can cover: of the whole arena, or straight ahead."""
MOVING_SQUARES = 3
"""In how many squares of ground a robot has to be lately to move on; at the border of two it may stand."""
MOVING = 0.5
"""The share of the moments of a lesson in which a robot has to drive, so that moving on is demanded, too."""


@dataclass(frozen=True, slots=True)
class _Words:
    """What the goals of a robot, or of a coordinator about its robots, are called."""

    never_touching: str
    touching_nothing: str
    each: str


WORDS_OF_ROBOT = _Words("never touches anything", "touches nothing", "")
WORDS_OF_COORDINATOR = _Words(
    "never lets its robots touch anything", "lets its robots touch nothing", " with each of its robots"
)


def offer_goals(
    lesson: Lesson,
    world: World,
    *,
    robots: NDArray[np.bool_] | None = None,
    of_coordinator: bool = False,
) -> tuple[Property, ...]:
    """List goals that fit what was shown, of which a person can pick one.

    Parameters
    ----------
    lesson
        The lesson.
    world
        The world in which it is taught.
    robots
        Which robots of the world the goals are about [N]: the trained one, or those of a coordinator. None: all.
    of_coordinator
        Whether a coordinator is trained, so that they are about its robots.

    Returns
    -------
    tuple[Property, ...]
        At most three: a reading is kept in a range, nothing is touched, ground is covered. `name` says it in words.
        What stands still keeps most readings, so where the lesson drives, the first demands that it moves on, too.
    """
    start = SeededWorlds(world.scenario.name, (), min(RUN_S, world.scenario.limit_s))
    types = world.rules.types[world.state.robots["type"][slice(None) if robots is None else robots]]
    words = WORDS_OF_COORDINATOR if of_coordinator else WORDS_OF_ROBOT
    speed, collides = float(types["speed"].min()) / world.tick_s, bool(types["collides"].all())
    breaks = {TOUCHED: words.touching_nothing} if collides else {}
    if not of_coordinator and _is_driving(lesson, world.scenario):
        breaks |= _describe_standing(world, start, speed)
    goals = [_make_kept_goal(each, start, breaks) for each in _list_kept(lesson, start)[:1]]
    if collides:
        goals.append(Property(kind=PropertyKind.NEVER, what=TOUCHED, start=start, name=words.never_touching))
    if (area := _compute_demanded_area(world, start, speed)) > CELL_M**2:
        text = f"{area:g} {UNITS[COVERED]}"
        name = f"covers at least {text} of ground in {start.limit_s:g} s{words.each}"
        what = f"{COVERED} is at least {text}"
        goals.append(
            Property(kind=PropertyKind.ALWAYS, what=what, seconds=start.limit_s, start=start, name=name)
        )
    return tuple(goals)


def find_behavior_success(library: Library, behavior: str) -> Property | str | None:
    """Find what success means for a behavior of a library, taught or not; see `find_success`."""
    taught = library.taught.get(behavior)
    lesson = None if taught is None else taught.lesson
    return find_success_flag(library, behavior) if lesson is None else find_success(lesson)


def find_success(lesson: Lesson) -> Property | str | None:
    """Find what success means for a behavior: the chosen goal, or its flag; None if the world's goal counts."""
    return choose_success_flag(lesson.automaton.flags) if lesson.goal is None else lesson.goal


def describe_goal(lesson: Lesson, *, of_world: bool) -> str:
    """Describe what success means for a behavior: the chosen goal, the flag where it was shown, or the world's goal.

    Parameters
    ----------
    lesson
        The lesson.
    of_world
        Whether the world has a goal.

    Returns
    -------
    str
        The goal in words; empty if there is none.
    """
    success = find_success(lesson)
    if isinstance(success, Property):
        return success.name or success.claim
    if success is None:
        return "the goal of the world is reached" if of_world else ""
    shown_range = find_shown_range(lesson, success)
    return f"{success}{RAISED}" + (
        ", wherever that is" if shown_range is None else f" and {shown_range.condition}"
    )


@dataclass(frozen=True, slots=True)
class _KeptRange:
    """A range of the values of a feature that was kept while a lesson was taught, and for how long it was left."""

    feature: BoundFeature
    low: float
    high: float
    share: float
    break_s: float
    was_absent: bool


def _list_kept(lesson: Lesson, start: SeededWorlds) -> list[_KeptRange]:
    """List the ranges that were kept, the narrowest first; then lower limits of what is around the robot."""
    moments = _list_moments(lesson)
    if len(moments) < FEWEST_MOMENTS:
        return []
    values = np.array([lesson_values for lesson_values, _ in moments])
    seconds = np.array([each for _, each in moments])
    ranges = list[_KeptRange]()
    for index, feature in enumerate(lesson.automaton.features):
        if isinstance(feature.feature, Feature) and isinstance(feature.kind, Continuous):
            ranges += _find_kept(feature, values[:, index], seconds)
    limit_s = start.limit_s or RUN_S
    fitting = [each for each in ranges if each.break_s <= limit_s / 2]
    return sorted(fitting, key=lambda each: (isinf(each.high), each.share))


def _list_moments(lesson: Lesson) -> list[tuple[tuple[float, ...], float]]:
    """List the values of the features and the time, s, at each moment of a lesson, in order."""
    moments = dict[int, tuple[tuple[float, ...], float]]()
    for each in select_teaching_examples(lesson):
        moment = each.moment
        if moment is not None and moment < len(lesson.record):
            moments[moment] = each.values, float(lesson.record.seconds[moment])
    return [moments[moment] for moment in sorted(moments)]


def _find_kept(feature: BoundFeature, values: Column, seconds: Column) -> Iterator[_KeptRange]:
    """Yield the narrowest range that has the share KEPT of some values [M], or else the lower limit of that share."""
    present = np.sort(values[~np.isnan(values)])
    count, absent = ceil(KEPT * len(values)), bool(np.isnan(values).any())
    if len(present) < count or present[0] == present[-1]:
        return
    widths = present[count - 1 :] - present[: len(present) - count + 1]
    first = int(widths.argmin())
    share = float(widths[first] / (present[-1] - present[0]))
    low, high = _round_outward(
        float(present[first]), float(present[first + count - 1]), float(present[-1] - present[0])
    )
    if share > LARGEST_SHARE:
        if feature.binding or not present[0] > 0:
            return  # how far away a target is, is not free space
        low, high = _round_outward(float(present[0]), np.inf, float(present[-1] - present[0]))
        if low <= 0:
            return  # kept by whatever it does
    inside = (values >= low) & (values <= high)
    yield _KeptRange(feature, low, high, share, _measure_longest_break(inside, seconds), absent)


def _round_outward(low: float, high: float, size: float) -> tuple[float, float]:
    """Round a range to steps of about a fiftieth of a size, so that it becomes wider."""
    step = 10.0 ** floor(log10(size)) / 20.0
    return round(floor(low / step) * step, 9), high if isinf(high) else round(ceil(high / step) * step, 9)


def _measure_longest_break(inside: NDArray[np.bool_], seconds: Column) -> float:
    """Return the longest time, s, from a moment outside of a range to the next one inside, or the last one outside."""
    longest, since = 0.0, np.nan
    for within, now in zip(inside.tolist(), seconds.tolist(), strict=True):
        since = now if np.isnan(since) or now < since else since  # another session begins at 0 again
        longest = max(longest, now - since)
        since = np.nan if within else since
    return max(LEAST_BREAK_S, float(ceil(BREAK * longest)))


def _is_driving(lesson: Lesson, scenario: Scenario) -> bool:
    """Return whether a lesson is mostly in states that drive; what another automaton does is taken as driving."""
    basics = {name: how for each in scenario.types.values() for name, how in each.behaviors.items()}
    driving = {
        state.name
        for state in lesson.automaton.states
        if state.behavior is not None and basics.get(state.behavior, {"drive": 1.0}).get("drive")
    }
    is_driving = [
        each.state in driving for each in select_teaching_examples(lesson) if each.moment is not None
    ]
    return sum(is_driving) >= MOVING * len(is_driving)


def _describe_standing(world: World, start: SeededWorlds, speed: float) -> dict[str, str]:
    """Return when a robot of a speed, m/s, does not move on, and that it does in words; empty if it is too slow.

    It has to cover COVERED_SHARE of what it covers straight ahead, lately: as long as MOVING_SQUARES take.
    """
    seconds = ceil(round(MOVING_SQUARES * CELL_M / (COVERED_SHARE * speed), 6)) if speed else inf
    whole = world.rules.width * world.rules.height / CELL_M**2
    if seconds > (start.limit_s or RUN_S) / 2 or COVERED_SHARE * whole < MOVING_SQUARES:
        return {}
    return {f"{COVERED}({seconds} s) is below {MOVING_SQUARES * CELL_M**2:g} {UNITS[COVERED]}": "moves on"}


def _make_kept_goal(kept_range: _KeptRange, start: SeededWorlds, breaks: Mapping[str, str]) -> Property:
    """Make the goal that a range is kept; a robot that is stuck at something, or stands still, keeps nothing.

    `breaks` are conditions in which nothing is kept, each with what is demanded instead, in words.
    """
    feature, unit = kept_range.feature, kept_range.feature.feature.unit
    low, high = (f"{end:g} {unit}".strip() for end in (kept_range.low, kept_range.high))
    what = f"{feature} is below {low}"
    name = f"keeps {feature} at {low} or more"
    if not isinf(kept_range.high):
        what += f" or above {high}"
        name = f"keeps {feature} between {kept_range.low:g} and {high}"
    if kept_range.was_absent:
        what += " or absent"
    what = " or ".join([what, *breaks])
    name = join_names([name, *breaks.values()])
    name += f", but for at most {kept_range.break_s:g} s at a time"
    return Property(
        kind=PropertyKind.NEVER_LONGER, what=what, seconds=kept_range.break_s, start=start, name=name
    )


def _compute_demanded_area(world: World, start: SeededWorlds, speed: float) -> float:
    """Return the area that each robot is to cover at a speed, m/s, in m²: whole squares."""
    straight = speed * (start.limit_s or RUN_S) / CELL_M
    whole = world.rules.width * world.rules.height / CELL_M**2
    return floor(COVERED_SHARE * min(straight, whole)) * CELL_M**2
