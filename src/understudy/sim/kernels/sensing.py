"""Kernels of sensing: the readings of a robot in one tick, step by step of its sense plan (see `sense_plan.py`)."""

import math
from typing import Any

from understudy.jit.decorators import inlined, inner, int64, uint64
from understudy.sim.kernels.angles import compute_angle, wrap_angle
from understudy.sim.kernels.dtypes import (
    ALONG_BEAM,
    ANYONE,
    BUMPER,
    CAMERA,
    CHANCE,
    CLAIMED,
    ENOUGH,
    FOOD_LEFT,
    HOLDING,
    LIDAR,
    NEAREST_RETURN,
    OWN_HEADING,
    OWN_SPEED,
    OWN_TURNING,
    OWN_X,
    OWN_Y,
    SINCE,
    SONAR,
    STATION_HERE,
    STORED,
    STUCK,
    TO_CALLER,
    TO_CLASS,
    TO_OBJECT,
    TO_ROBOT,
    TO_UNCLAIMED,
    TOUCH,
)
from understudy.sim.kernels.grid import find_nearest_robot
from understudy.sim.kernels.nearest import (
    find_nearest_gathered_object,
    find_nearest_object,
    find_nearest_unclaimed,
)
from understudy.sim.kernels.rng import draw_normal, draw_uniform
from understudy.sim.kernels.scan import detect_blobs, scan_sectors
from understudy.sim.kernels.signals import find_nearest_signaler, is_claimed
from understudy.sim.sensing import sectors

NOISE_A, NOISE_B, DROPOUT, MISS, GHOST, GHOST_X = 0, 2, 4, 5, 6, 7  # streams within a part's eight
GHOST_PX = 16.0  # the largest size of a blob that is not there, as wide and high


@inner
def find_nearest_food(c: Any, world: int, x: float, y: float) -> Any:
    """Find the nearest source with food left: its slot, -1 if there is none, and its squared distance (m**2)."""
    best, best_squared = -1, math.inf
    for index in range(c.facts.class_count):
        if c.classes[index].food:
            slot, squared = find_nearest_object(c, world, x, y, index)
            if squared < best_squared:
                best, best_squared = slot, squared
    return best, best_squared


@inner
def is_station_near(c: Any, world: int, x: float, y: float, reach: float) -> Any:
    """Return whether the center of a home is within `reach` (m) of a place."""
    for index in range(c.facts.class_count):
        if c.classes[index].home:
            _, squared = find_nearest_object(c, world, x, y, index)
            if squared <= reach * reach:
                return True
    return False


@inner
def _enough(c: Any, robot: Any, world: int) -> Any:
    """Return 1 if enough robots hold the box that a robot holds to pull it, else 0."""
    slot = robot.holding - 1
    if slot < 0:
        return 0.0
    return (
        1.0
        if c.objects[world * c.facts.object_count + slot].hands >= c.classes[int64(c.class_of[slot])].pull
        else 0.0
    )


@inner
def read_robot_state(c: Any, robot: Any, world: int, step: Any) -> Any:
    """Return a reading of the robot's own state, such as its place, speed or cargo."""
    what = step.what
    if what == OWN_X:
        return robot.x
    if what == OWN_Y:
        return robot.y
    if what == OWN_HEADING:
        return robot.heading
    if what == OWN_SPEED:
        return robot.speed / c.facts.tick_s
    if what == OWN_TURNING:
        return robot.spin / c.facts.tick_s
    if what == STUCK:
        return 1.0 if robot.blocked >= step.ticks else 0.0
    if what == STORED:
        return float(robot.stored)
    if what == HOLDING:
        return 1.0 if robot.holding != 0 else 0.0
    if what == ENOUGH:
        return _enough(c, robot, world)
    reach = c.types[uint64(robot.type)].reach
    if what == STATION_HERE:
        return 1.0 if is_station_near(c, world, robot.x, robot.y, reach) else 0.0
    slot, squared = find_nearest_food(c, world, robot.x, robot.y)
    if what == FOOD_LEFT:
        return 1.0 if slot >= 0 else 0.0
    return (
        float(c.objects[world * c.facts.object_count + slot].amount)
        if slot >= 0 and squared <= reach * reach
        else 0.0
    )


@inner
def _seek(c: Any, row: int, world: int, step: Any) -> Any:
    """Find the nearest unclaimed object, or robot that raises a signal: x, y, squared distance (m**2); NaN if none."""
    if step.place == TO_UNCLAIMED:
        slot, squared = find_nearest_unclaimed(c, row, world, step)
        if slot >= 0:
            return c.object_x[slot], c.object_y[slot], squared
    else:
        other, squared = find_nearest_signaler(c, row, world, step.index, step.signal, step.range)
        if other >= 0:
            return c.robots[other].x, c.robots[other].y, squared
    return math.nan, math.nan, math.inf


@inlined
def locate_target(c: Any, row: int, world: int, step: Any, offset: Any, calling: Any) -> None:
    """Write the offset (x, y in m, world frame) of a step's target to `offset`; NaN in x if absent or out of range."""
    robot = c.robots[uint64(row)]
    squared = math.inf
    x, y = math.nan, math.nan
    if step.place == TO_ROBOT:
        other = -1
        if step.index >= 0:
            other, squared = find_nearest_robot(c, row, world, step.index, step.range)
        if other >= 0:
            x, y = c.robots[other].x, c.robots[other].y
        if step.index == ANYONE:
            c.moves[uint64(row - world * c.facts.count)].alone = min(squared, step.range * step.range)
    elif step.place == TO_CLASS:
        slot, squared = find_nearest_gathered_object(c, row, world, step)
        if slot >= 0:
            x, y = c.object_x[slot], c.object_y[slot]
    elif step.place == TO_OBJECT:
        thing = c.objects[world * c.facts.object_count + step.index]
        if thing.present:
            x, y = thing.x, thing.y
            squared = (x - robot.x) * (x - robot.x) + (y - robot.y) * (y - robot.y)
    if calling is not None:  # noqa: SIM102 - apart, so that Numba leaves out what follows from None
        if step.place > TO_ROBOT:
            x, y, squared = _seek(c, row, world, step)
    offset.x = x - robot.x if squared <= step.range * step.range else math.nan
    offset.y = y - robot.y


@inlined
def compute_bearing(dx: float, dy: float, heading: float) -> Any:
    """Return the bearing (rad in [0, tau), robot frame) of the offset (dx, dy); 0 for no offset."""
    if dx == 0.0 and dy == 0.0:
        return 0.0
    return wrap_angle(compute_angle(dy, dx) - heading)


@inlined
def measure_from_rim(c: Any, row: int, world: int, step: Any) -> None:
    """Write a sonar's distances (m from the robot's rim) or a bumper's contacts (0 or 1), by sector, to `c.a`."""
    radius = c.types[c.robots[row].type].radius
    limit = radius + (step.range if step.what == SONAR else TOUCH)
    scan_sectors(c, row, world, step, limit)
    for k in range(step.end - step.first):
        if step.what == SONAR:
            c.a[k] = min(step.range, max(0.0, c.a[k] - radius))
        else:
            c.a[k] = 1.0 if c.a[k] < limit else 0.0


find_nearest_beam = inner(sectors.find_nearest_beam)
measure_widest_opening = inner(sectors.measure_widest_opening)


@inner
def measure_lidar(c: Any, row: int, world: int, step: Any) -> None:
    """Measure along the beams of a lidar, with noise, and summarize them by sectors; distances are from the rim, m.

    The parts of single beams precede those of sectors. `c.b` holds their distances by beam, because a reading that is
    requested twice has two parts.
    """
    robot = c.robots[row]
    radius = c.types[robot.type].radius
    scan_sectors(c, row, world, step, radius + step.range)
    for k in range(step.end - step.first):
        part = c.parts[step.first + k]
        if part.of == ALONG_BEAM:
            far = min(step.range, max(0.0, c.a[k] - radius))
            if step.noisy:
                far, _ = add_sensor_noise(
                    step, part, c.seeds[world], robot.id, c.tick[world], c.facts.generator, far, math.nan
                )
            c.a[k] = c.b[part.number] = far
            continue
        beam = find_nearest_beam(c.b, part.beam, part.beams, step.beams)
        c.b[k] = math.nan
        if beam < 0:
            c.a[k] = math.nan
        elif part.of == NEAREST_RETURN:
            c.a[k] = c.b[beam]
            if c.b[beam] < step.range:
                c.b[k] = wrap_angle(step.first_rad + beam * step.spacing)
        else:
            c.a[k] = measure_widest_opening(
                c.b, part.beam, part.beams, step.beams, step.spacing, radius, step.clear
            )


@inlined
def measure_sense_step(
    c: Any, row: int, world: int, step: Any, offset: Any, camera: Any, ranging: Any, calling: Any
) -> None:
    """Measure one step of a sense plan without noise, writing the readings a and b of its parts to `c.a` and `c.b`.

    `offset` is that of the step's target, already located. `camera`, `ranging` and `calling` are None if no robot has a
    camera, no robot has a range sensor, or no robot raises signals: no code is compiled for these then.
    """
    robot = c.robots[uint64(row)]
    if step.what <= TO_CALLER:
        c.a[0] = math.sqrt(offset.x * offset.x + offset.y * offset.y)
        if c.parts[step.first].b >= 0:
            c.b[0] = compute_bearing(offset.x, offset.y, robot.heading) if offset.x == offset.x else math.nan
    elif step.what == CHANCE:
        time = c.tick[world] // step.ticks
        c.a[0] = draw_uniform(c.seeds[world], robot.id, time, step.stream + GHOST)
    elif step.what > BUMPER and step.what < CHANCE:
        c.a[0] = read_robot_state(c, robot, world, step)
    if calling is not None:  # noqa: SIM102
        if step.what == CLAIMED:
            c.a[0] = _claimed(c, row, world, step, offset)
    if ranging is not None:
        if step.what == SONAR or step.what == BUMPER:
            measure_from_rim(c, row, world, step)
        elif step.what == LIDAR:
            measure_lidar(c, row, world, step)
    if camera is not None:  # noqa: SIM102
        if step.what == CAMERA:
            detect_blobs(c, row, world, step)


@inner
def _claimed(c: Any, row: int, world: int, step: Any, offset: Any) -> Any:
    """Return 1 if another robot claims the located target, 0 if none does; NaN if the target is absent."""
    if offset.x != offset.x:
        return math.nan
    robot = c.robots[uint64(row)]
    x, y = robot.x + offset.x, robot.y + offset.y
    return 1.0 if is_claimed(c, row, world, x, y, step.signal, step.within) else 0.0


@inlined
def add_sensor_noise(
    step: Any, part: Any, seed: int, item: int, tick: int, generator: int, a: float, b: float
) -> Any:
    """Return the readings a and b of a part with noise, misdetections and dropout (NaN) added."""
    stream = step.stream + 8 * part.number
    if step.dropout > 0.0 and draw_uniform(seed, item, tick, stream + DROPOUT) < step.dropout:
        return math.nan, math.nan
    if step.what == CAMERA:
        if step.misses > 0.0 and draw_uniform(seed, item, tick, stream + MISS) < step.misses:
            a = b = math.nan
        ghosts = step.ghosts if part.color >= 0 else 0.0  # what has no color is never seen
        if a != a and ghosts > 0.0 and draw_uniform(seed, item, tick, stream + GHOST) < ghosts:
            a = step.width_px * draw_uniform(seed, item, tick, stream + GHOST_X)
            b = step.least_px + (GHOST_PX * GHOST_PX) * draw_uniform(seed, item, tick, stream + NOISE_B)
            return a, b
    ranges = step.what == SONAR or step.what == LIDAR
    silent = ranges and a >= step.range  # nothing was heard, and there is nothing to be noisy
    if (
        step.noise_a > 0.0 and a == a and not silent
    ):  # what is absent stays so: the largest of 0 and NaN would be 0
        a += step.noise_a * draw_normal(seed, item, tick, stream + NOISE_A, generator)
        if ranges:
            a = min(step.range, max(0.0, a))
        elif step.what == CAMERA:
            a = min(step.width_px, max(0.0, a))
        elif step.what == OWN_HEADING:
            a = wrap_angle(a)
        elif step.what <= TO_CALLER:
            a = max(0.0, a)
    if step.noise_b > 0.0 and b == b:
        drawn = step.noise_b * draw_normal(seed, item, tick, stream + NOISE_B, generator)
        b = max(0.0, b * (1.0 + drawn)) if step.what == CAMERA else wrap_angle(b + drawn)
    return a, b


@inlined
def is_due(step: Any, tick: int) -> Any:
    """Return whether a step measures in this tick; between its periods its last readings are repeated."""
    return step.period == 1 or tick % step.period == 0


@inlined
def _since(c: Any, row: int, step: Any, values: Any, tick: int, seed: int, item: int, keep: bool) -> None:
    """Write the time (s) since a step's source reading was last present, or 1 if it is a flag."""
    part = c.parts[step.first]
    source = values[step.index]
    there = source == 1.0 if step.nearest else source == source
    last = row * c.facts.memory_count + part.held
    answer = last + 1
    since = c.memory[answer]
    if is_due(step, tick):
        since = 0.0 if there else tick - c.memory[last]
        if since == since:  # the floor of what is absent would be a number
            since = math.floor(since * c.facts.tick_s * 1e9 + 0.5) / 1e9
        stream = step.stream + 8 * part.number + DROPOUT
        if step.dropout > 0.0 and draw_uniform(seed, item, tick, stream) < step.dropout:
            since = math.nan
        if keep:
            c.memory[answer] = since
    if part.a >= 0:
        values[part.a] = since
    if keep and there:
        c.memory[last] = float(tick)


@inlined
def run_sense_step(
    c: Any, row: int, world: int, step: Any, offset: Any, values: Any, keep: bool, camera: Any, ranging: Any,
    calling: Any,
) -> None:  # fmt: skip
    """Run one step of a sense plan, writing readings to `values`, and to the sensors' memory where `keep`."""
    robot, tick, seed = c.robots[row], c.tick[world], c.seeds[world]
    if step.what == SINCE:
        _since(c, row, step, values, tick, seed, robot.id, keep)
        return
    due = is_due(step, tick)
    if due:
        measure_sense_step(c, row, world, step, offset, camera, ranging, calling)
    for k in range(step.first, step.end):
        part = c.parts[uint64(k)]
        held = row * c.facts.memory_count + part.held
        if due:
            a, b = c.a[uint64(k - step.first)], c.b[uint64(k - step.first)]
            if step.noisy and step.what != LIDAR:  # whose beams had it before they were summed up
                a, b = add_sensor_noise(step, part, seed, robot.id, tick, c.facts.generator, a, b)
            if keep and part.held >= 0:
                c.memory[held] = a
                if part.b >= 0:  # else b has the value of an earlier measurement
                    c.memory[held + 1] = b
        else:
            a, b = c.memory[held], c.memory[held + 1]
        if part.a >= 0:
            values[uint64(part.a)] = a
        if part.b >= 0:
            values[uint64(part.b)] = b


@inlined
def sense_robots(
    c: Any, low: int, high: int, world: int, keep: bool, camera: Any, ranging: Any, calling: Any
) -> None:
    """Write the readings of the robots `low` to `high` in this tick to `c.rows`; NaN where a robot has none.

    With `keep`, sensors store what they need of this tick: true once per tick, before robots move. Each step runs for
    all these robots before the next step, so that a processor can work on several robots at a time.
    """
    for column in range((high - low) * c.facts.width_of_row):
        c.rows[uint64(column)] = math.nan
    for row in range(low, high):
        c.moves[uint64(row - world * c.facts.count)].alone = 0.0
    for kind in range(c.facts.type_count):
        for index in range(c.of_type[2 * kind], c.of_type[2 * kind + 1]):
            step = c.steps[index]
            if step.place >= 0 and is_due(step, c.tick[world]):
                for row in range(low, high):
                    if c.facts.type_count == 1 or c.robots[row].type == kind:
                        locate_target(c, row, world, step, c.offsets[uint64(row - low)], calling)
            for row in range(low, high):
                robot = c.robots[uint64(row)]
                if robot.type == kind and not robot.frozen:
                    offset, values = (
                        c.offsets[uint64(row - low)],
                        c.rows[c.facts.width_of_row * (row - low) :],
                    )
                    run_sense_step(c, row, world, step, offset, values, keep, camera, ranging, calling)
