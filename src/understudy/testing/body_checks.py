"""Checks of bodies, and of simulated worlds."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from understudy.errors import UnderstudyError
from understudy.model.features import Percept
from understudy.runtime.body import Body, Rewindable, list_reading_keys
from understudy.sim.scenario.files import format_scenario, parse_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World
from understudy.testing.laws import LawBroken, require, require_call
from understudy.testing.random_drive import (
    TICKS,
    are_same,
    check_body_parts,
    check_column,
    copy_percept,
    draw_commands,
    drive_randomly,
    name_reading,
    record_percepts,
    require_same_percepts,
    restore_afterwards,
)


def check_body(body: Body, *, ticks: int = TICKS, seed: int = 0) -> None:
    """Check that a body meets its contract, driven with random commands.

    The body must return N float64 values of the declared kind for each reading, the same if it is read twice and if a
    reading is asked for alone. It must leave the commands that it gets unchanged, and refuse unknown readings,
    unknown channels, columns of the wrong length and NaN with an UnderstudyError. A Rewindable body must also
    continue from a snapshot exactly as before, refuse invalid snapshots, and put channels without a command at rest.

    Parameters
    ----------
    body
        The body. A Rewindable body is restored afterwards.
    ticks
        Number of ticks for which it is driven.
    seed
        Seed of the random commands.

    Raises
    ------
    LawBroken
        If the body breaks a rule.
    """
    part = f"body {type(body).__name__}"
    check_body_parts(body)
    _check_declarations(part, body)
    with restore_afterwards(body):
        for percept in drive_randomly(body, ticks, seed):
            _check_percept(part, body, percept)
        _check_refusals(part, body)
        _check_commands_untouched(part, body, seed)
    if isinstance(body, Rewindable):
        _check_rewinding(part, body, ticks, seed)


def check_world(
    make: Callable[[Sequence[int]], Body], *, seeds: Sequence[int] = (0, 1, 2, 7, 40), ticks: int = TICKS
) -> None:
    """Check that a simulated world meets the contract of a body and can be repeated by its seed.

    In addition to `check_body`, the same seeds must give the same run, and each world must run alone exactly as it
    does together with others.

    Parameters
    ----------
    make
        Function that takes seeds and returns a body with one world per seed. All worlds have the same number of rows,
        in the order of the seeds.
    seeds
        Seeds of the worlds.
    ticks
        Number of ticks for which each world is driven.

    Raises
    ------
    LawBroken
        If the world breaks a rule.
    """
    body = make(seeds)
    check_body_parts(body)
    part = f"world {type(body).__name__}"
    rows, rest = divmod(body.agents, len(seeds))
    require(
        not rest, part, "each seed's world has as many rows", f"{len(seeds)} seeds gave {body.agents} rows"
    )
    check_body(body, ticks=ticks)
    among = record_percepts(make(seeds), ticks, seeds, rows)
    require_same_percepts(
        part, "the same seeds give the same run", among, record_percepts(make(seeds), ticks, seeds, rows)
    )
    for index, seed in enumerate(seeds):
        alone = record_percepts(make([seed]), ticks, [seed], rows)
        own = slice(index * rows, (index + 1) * rows)
        cut = [{key: column[own] for key, column in percept.items()} for percept in among]
        require_same_percepts(part, f"world {seed} runs alone as it does among others", cut, alone)


def check_scenario_worlds(
    scenario: Scenario | Callable[[], Scenario], *, seeds: Sequence[int] = (0, 1, 2), ticks: int = TICKS
) -> None:
    """Check that a scenario, or the function that makes it, can be used wherever a built-in one can.

    The function must make the same scenario each time. Its file must give the scenario back, and its worlds must meet
    `check_world`.

    Parameters
    ----------
    scenario
        The scenario, or a function without parameters that returns it.
    seeds
        Seeds of the worlds.
    ticks
        Number of ticks for which each world is driven.

    Raises
    ------
    LawBroken
        If it breaks a rule.
    """
    made, again = (
        require_call("scenario", "its function takes no parameters and returns a Scenario", scenario)
        if callable(scenario)
        else scenario
        for _ in range(2)
    )
    require(isinstance(made, Scenario), "scenario", "it is a Scenario", f"it is a {type(made).__name__}")
    part = f"scenario {made.name!r}"
    require(made == again, part, "its function makes the same scenario each time", "two differ")
    worlds = require_call(part, "a World can be made of it", lambda: World(made, seeds))
    require(worlds.agents > 0, part, "it has robots", "it has none")
    text = require_call(part, "it can be written as a file", lambda: format_scenario(made))
    read = require_call(part, "its file can be read", lambda: parse_scenario(text))
    require(read == made, part, "its file gives the same scenario", "the one of the file differs")
    check_world(lambda chosen: World(made, chosen), seeds=seeds, ticks=ticks)


def _check_declarations(part: str, body: Body) -> None:
    law = "names are given once, and there is at least one reading, channel and agent"
    for names in ([each.name for each in body.readings], [each.name for each in body.channels]):
        require(bool(names) and len(set(names)) == len(names), part, law, f"it has {names}")
    require(len(set(body.targets)) == len(body.targets), part, law, f"it has targets {list(body.targets)}")
    require(body.agents >= 1, part, law, f"it has {body.agents} agents")
    require(body.tick_s > 0, part, "a tick takes some time", f"tick_s is {body.tick_s}")


def _check_percept(part: str, body: Body, percept: Percept) -> None:
    kinds = {reading.name: reading.kind for reading in body.readings}
    keys = list_reading_keys(body)
    require(
        set(percept) == set(keys), part, "it senses what it is asked", f"it gave {sorted(map(str, percept))}"
    )
    for key in keys:
        check_column(f"{part}, {name_reading(key)}", percept[key], body.agents, kinds[key[0]])
    require_same_percepts(part, "sensing twice gives the same", [percept], [body.sense(keys)])
    for key in keys:
        require_same_percepts(part, "a reading is the same asked alone", [body.sense([key])], [percept])
    kept, written = copy_percept(percept), body.sense(keys)
    for key in keys:
        if written[key].flags.writeable:
            written[key].fill(0.5)
    require_same_percepts(
        part, "what is done to a percept does not reach the body", [kept], [body.sense(keys)]
    )


def _check_refusals(part: str, body: Body) -> None:
    law = "what it does not know, it refuses with an UnderstudyError that names it"
    unknown = "no_such_thing"
    channel, wrong = body.channels[0].name, np.zeros(body.agents + 1)
    attempts: dict[str, Callable[[], object]] = {
        f"reading {unknown!r}": lambda: body.sense([(unknown, None)]),
        f"channel {unknown!r}": lambda: body.act({unknown: np.zeros(body.agents)}),
        f"{channel!r} for one agent too many": lambda: body.act({channel: wrong}),
        f"{channel!r} that is NaN": lambda: body.act({channel: np.full(body.agents, np.nan)}),
    }
    before = copy_percept(body.sense(list_reading_keys(body)))
    for what, attempt in attempts.items():
        name = unknown if unknown in what else channel
        try:
            attempt()
        except UnderstudyError as refusal:
            require(name in str(refusal), part, law, f"for {what} it said: {refusal}")
        except Exception as error:
            raise LawBroken(part=part, law=law, found=f"for {what} it raised {error!r}") from error
        else:
            raise LawBroken(part=part, law=law, found=f"it took {what}")
    after = [body.sense(list_reading_keys(body))]
    require_same_percepts(part, "a command that is refused changes nothing", [before], after)


def _check_commands_untouched(part: str, body: Body, seed: int) -> None:
    commands = draw_commands(body, [np.random.default_rng(seed)], body.agents)
    before = {channel: column.copy() for channel, column in commands.items()}
    body.act(commands)
    kept = all(are_same(commands[channel], column) for channel, column in before.items())
    require(kept, part, "it leaves the commands it is given untouched", "it changed them")


def _check_rewinding(part: str, body: Body, ticks: int, seed: int) -> None:
    if not isinstance(body, Rewindable):
        return
    start, time_s = body.snapshot(), body.time_s
    first = [copy_percept(percept) for percept in drive_randomly(body, ticks, seed)]
    body.restore(start)
    law = "restoring a snapshot goes back bit for bit"
    require(body.time_s == time_s, part, law, f"its time was {time_s} s and is {body.time_s} s")
    require(body.snapshot() == start, part, law, "a snapshot taken there is another")
    second = [copy_percept(percept) for percept in drive_randomly(body, ticks, seed)]
    require_same_percepts(part, "it goes on from a snapshot as it did before", first, second)
    for bad in (b"", b"nonsense", start[:-1]):
        try:
            body.restore(bad)
        except UnderstudyError:
            continue
        except Exception as error:
            raise LawBroken(
                part=part, law="it refuses a bad snapshot", found=f"it raised {error!r}"
            ) from error
        raise LawBroken(part=part, law="it refuses a bad snapshot", found=f"it took {bad[:20]!r}")
    body.restore(start)
    body.act({})
    rested = [body.sense(list_reading_keys(body))]
    body.restore(start)
    body.act({channel.name: np.full(body.agents, channel.rest) for channel in body.channels})
    require_same_percepts(part, "a channel left out rests", rested, [body.sense(list_reading_keys(body))])
    body.restore(start)
