"""Coordinators in kernels: sensing, deciding and ordering as in `squad_body.py`, for layers of squads in one world.

All layers are passed as tuples of the same types (see `compiled_squads.py`). `bands` has the robots and then every
layer of squads, `leads` the further data of each layer of squads.
"""

import math
from typing import Any

import numpy as np

from understudy.jit.decorators import njit_inner
from understudy.runtime.engine._pulse_kernels import pulse_agent, start_instance

inner = njit_inner(error_model="numpy", _nrt=False)

# As in leading.py, which a kernel file cannot import.
ANY, ALL, NONE, COUNT, FRACTION, MEAN, MINIMUM, MAXIMUM, SPREAD = range(9)
READING, FLAG, THERE = range(3)
NOW, WITHIN, SINCE, FOR = range(4)
IDLING = 0
SAME_S = 1e-6


@inner
def read_member(statistic: Any, sources: Any, member: Any, bands: Any) -> float:
    """Read the reading of a member, or whether it has raised the flag."""
    if statistic.of == THERE:
        return 1.0
    band, source = bands[member.layer], sources[member.layer]
    if source < 0:
        return math.nan if statistic.of == READING else 0.0
    if statistic.of == READING:
        return float(band[2][member.row, source])
    states, stacks = band[0][1], band[1]
    if stacks[0][member.row] < 0:
        return 0.0
    return 1.0 if states[stacks[1][member.row, 0]].flag == source else 0.0


@inner
def compute_member_statistic(
    statistic: Any, sources: Any, lead: Any, bands: Any, low: int, high: int
) -> float:
    """Compute the present value of a statistic over the members from `low` up to `high`."""
    members, counted = lead[2], lead[6]
    everyone, number, total = 0, 0, 0.0
    least, most = math.inf, -math.inf
    for m in range(low, high):
        member = members[m]
        if not counted[m] or (statistic.role >= 0 and statistic.role != member.role):
            continue
        value = read_member(statistic, sources, member, bands)
        everyone += 1
        if statistic.how >= MEAN:
            if value == value:
                number += 1
                total += value
                least, most = min(least, value), max(most, value)
        elif statistic.plain:
            number += 1 if value == 1.0 else 0
        else:
            number += 1 if value >= statistic.least and value < statistic.below else 0
    how = statistic.how
    if how == ANY:
        return 1.0 if number > 0 else 0.0
    if how == NONE:
        return 1.0 if number == 0 else 0.0
    if how == ALL:
        return 1.0 if number == everyone and everyone > 0 else 0.0
    if how == COUNT:
        return float(number)
    if how == FRACTION:
        return number / everyone if everyone > 0 else math.nan
    if number == 0:
        return math.nan
    if how == MINIMUM:
        return least
    if how == MAXIMUM:
        return most
    middle = total / number
    if how == MEAN:
        return middle
    total = 0.0
    for m in range(low, high):
        member = members[m]
        if counted[m] and (statistic.role < 0 or statistic.role == member.role):
            value = read_member(statistic, sources, member, bands)
            if value == value:
                total += (value - middle) * (value - middle)
    return math.sqrt(total / number)


@inner
def update_timed_statistic(
    statistic: Any, value: float, now: float, last: Any, since: Any, squad: int
) -> float:
    """Compute a statistic over time, given its present value."""
    if value == 1.0:
        last[squad] = now
        if since[squad] != since[squad]:
            since[squad] = now
    else:
        since[squad] = math.nan
    back = since[squad] if statistic.when == FOR else last[squad]
    steps = 1e9 if now < 4194304.0 else 1e6  # as the interpreter rounds
    seconds = np.floor((now - back) * steps + 0.5) / steps
    if statistic.when == SINCE:
        return float(seconds)
    if statistic.when == WITHIN:
        return 1.0 if seconds <= statistic.seconds else 0.0
    return 1.0 if seconds >= statistic.seconds else 0.0


@inner
def survey_members(squad: int, now: float, mine: Any, lead: Any, bands: Any) -> None:
    """Compute all statistics of a squad, and whether any member is left."""
    statistics, sources, members, first, drops = lead[0], lead[1], lead[2], lead[3], lead[4]
    counted, last, since = lead[6], lead[7], lead[8]
    low, high = first[squad], first[squad + 1]
    anybody = False
    for m in range(low, high):
        member = members[m]
        band, drop = bands[member.layer], drops[member.layer]
        there = band[3][member.row] and not (drop >= 0 and band[2][member.row, drop] == 1.0)
        counted[m] = there
        anybody = anybody or there
    mine[3][squad] = anybody
    for k in range(len(statistics)):
        value = compute_member_statistic(statistics[k], sources[k], lead, bands, low, high)
        if statistics[k].when != NOW:
            value = update_timed_statistic(statistics[k], value, now, last[k], since[k], squad)
        mine[2][squad, k] = value


@inner
def start_member(member: Any, duty: int, now: float, roots: Any, bands: Any) -> None:
    """Let a member begin a duty."""
    band, row = bands[member.layer], member.row
    stacks = band[1]
    root = roots[duty, member.band]
    stacks[0][row] = root
    stacks[2][row, 0] = now
    band[4][row] = IDLING
    if root >= 0:
        start_instance(row, 0, root, now, band[0], stacks)


@inner
def pulse_coordinator(squad: int, now: float, mine: Any, lead: Any, bands: Any) -> None:
    """Pulse a coordinator; if it gives a new order, its members begin it."""
    members, first, ordered = lead[2], lead[3], lead[5]
    order, issued, meant, heard, answering, duties, roots = lead[9]
    tables, stacks, values, _, running = mine
    running[squad] = pulse_agent(squad, values[squad], now, tables, stacks)
    new_order, when = ordered[running[squad]], -math.inf
    for level in range(stacks[2].shape[1]):
        when = max(when, stacks[2][squad, level])
    anew = new_order != order[squad] or not abs(when - issued[squad]) <= SAME_S
    order[squad] = new_order
    if anew:
        issued[squad] = when
    now_issued = issued[squad]
    for m in range(first[squad], first[squad + 1]):
        if anew:
            meant[m] = duties[new_order, members[m].role]
        heard[m] = meant[m]
        begins = answering[m] != now_issued and now_issued == now_issued
        answering[m] = now_issued
        if begins:
            start_member(members[m], heard[m], now, roots, bands)


@inner
def run_world_coordinators(world: int, now: float, bands: Any, leads: Any) -> None:
    """Run all coordinators of a world after its robots have sensed: statistics bottom-up, orders top-down."""
    for level in range(len(leads)):
        lead = leads[level]
        squads = lead[10]
        for squad in range(world * squads, (world + 1) * squads):
            survey_members(squad, now, bands[level + 1], lead, bands)
    for turn in range(len(leads)):
        level = len(leads) - 1 - turn
        lead = leads[level]
        squads = lead[10]
        for squad in range(world * squads, (world + 1) * squads):
            pulse_coordinator(squad, now, bands[level + 1], lead, bands)
