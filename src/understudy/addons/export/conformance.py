"""Conformance files: rows of readings with what the interpreter answers, by which an export proves itself.

The file is CSV with one tick per row; `docs/exporting.md` describes its columns. Its rows come from the recorded
lessons, from recorded runs, and from walks that look for the boundaries of trees, absent values, infinite ones (which
count as absent) and seams.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isinf, nan
from random import Random

import numpy as np

from understudy.addons.export.hierarchy import Hierarchy
from understudy.addons.export.single_precision import compute_in_single, round_to_single
from understudy.addons.export.walks import ReadingWalk
from understudy.errors import UnderstudyError
from understudy.model.features import Percept, ReadingKey
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.model.value_kinds import Categorical, Column, Kind
from understudy.records.record import Record, sample_record
from understudy.runtime.body import Commands, Reading
from understudy.runtime.command_columns import CommandColumns
from understudy.runtime.feature_columns import FeatureColumns, read_feature_column
from understudy.runtime.interpreter import Interpreter, RunningAutomaton
from understudy.runtime.link import Program

TICKS = 60
"""The number of ticks of a walk."""
MOST_TICKS = 6000
"""The largest number of ticks of all walks of a file."""
MOST_QUESTIONS = 10_000_000
"""About the largest number of questions that all walks ask, so that very deep trees take seconds."""
MOST_RECORDED = 1500
"""The largest number of ticks from the record of one lesson."""
SEED = 22
MS_PER_S = 1000
CLOCKS_S = (0.0, 0.0, 0.0, 1e5 / 3, 1_700_000_000.0)
"""Times at which walks begin, in s: clocks of robots, and one that counts from 1970."""
CLOCKS_MS = (0, 0, 0, 33_333_333, 2**32 - 2_000)
"""Times at which walks begin on a clock in ms; the last one overflows soon."""


@dataclass(frozen=True, slots=True)
class ReferenceTick:
    """The answer to one row of readings.

    `path` has the index of the state of every level, the root first; `flags` the flag that each level has raised, as an
    index of `Hierarchy.flags`, -1 if none; `commands` a value for each channel.
    """

    path: tuple[int, ...]
    flags: tuple[int, ...]
    basic: int
    commands: tuple[float, ...]


class RowBody:
    """A body of one agent that senses the rows it is given, in the order of `Hierarchy.readings`.

    With `single_precision`, readings are 32-bit floats.
    """

    agents = 1

    def __init__(self, program: Program, hierarchy: Hierarchy, *, single_precision: bool = False) -> None:
        self.readings = tuple(
            Reading(each.reading, each.kind, each.unit, each.target is not None)
            for each in hierarchy.readings
        )
        bindings = [each.binding for each in program.features] + [each.binding for each in program.basics]
        self.targets = tuple(dict.fromkeys(target for each in bindings for target in each.values()))
        self.channels, self.tick_s, self.time_s = hierarchy.channels, hierarchy.tick_s, 0.0
        self._keys = [(each.reading, each.target) for each in hierarchy.readings]
        self._type = np.float32 if single_precision else np.float64
        self.row: Sequence[float] = [float("nan")] * len(self._keys)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return all readings of the row."""
        with np.errstate(over="ignore"):
            columns = np.array(self.row, self._type)[:, None]
        return dict(zip(self._keys, columns, strict=True))

    def act(self, commands: Commands) -> None:
        """Do nothing: the next row does not depend on commands."""


class ReferenceRun:
    """The interpreter on rows of readings, by which exported code is measured: it answers as a `Run` of a `RowBody`.

    Rows are many, so that readings and commands are looked up; only functions get columns, at the ticks that need them.
    With `single_precision`, they compute in 32-bit floats.
    """

    def __init__(self, program: Program, hierarchy: Hierarchy, *, single_precision: bool = False) -> None:
        if single_precision:
            program = compute_in_single(program)
        self.hierarchy, self.is_coordinator = hierarchy, hierarchy.is_coordinator
        self.interpreter = Interpreter(program)
        self.body = RowBody(program, hierarchy, single_precision=single_precision)
        self._sensing = FeatureColumns(program.features, self.body)
        self._acting = CommandColumns(program.basics, self.body)
        self._commands: list[tuple[float, ...]] = [tuple(values) for values in self._acting.table.tolist()]
        self._functions = [index for index, at in enumerate(hierarchy.features) if at < 0]
        self._labels = [
            (index, frozenset(range(len(bound.kind.labels))))
            for index, bound in enumerate(program.features)
            if isinstance(bound.kind, Categorical) and index not in self._functions
        ]
        self._flags = {flag: index for index, flag in enumerate(hierarchy.flags)}

    def start(self, now: float) -> None:
        """Start the root again at a time, s."""
        self.interpreter.start(now)

    def pulse(self, readings: Sequence[float], now: float) -> ReferenceTick:
        """Return the answer to a row of readings at a time, s; UnderstudyError if a function cannot use them."""
        if inf in readings or -inf in readings:
            readings = [nan if isinf(value) else value for value in readings]
        self.body.row, self.body.time_s = readings, now
        basic = self.interpreter.pulse(self._read_features(readings), now)
        active = self.interpreter.active
        commands = self._commands[basic]
        if basic in self._acting.computed:
            commands = self._compute_commands(basic)
        if self.is_coordinator:  # an export numbers orders by their behavior, and says when one is new
            is_new = self.interpreter.behavior_start_s == now
            commands = (float(basic if self.hierarchy.basics[basic].order is not None else 0), float(is_new))
        return ReferenceTick(
            tuple([machine.state for machine in active]),
            tuple([-1 if machine.flag is None else self._flags[machine.flag] for machine in active]),
            basic,
            commands,
        )

    def _read_features(self, readings: Sequence[float]) -> list[float]:
        values = [readings[at] for at in self.hierarchy.features]
        if self._functions:
            percept = self.body.sense(())
            with np.errstate(all="ignore"):
                for index in self._functions:
                    column = read_feature_column(self._sensing.features[index], percept, agents=1)
                    values[index] = float(column[0])
        is_of_kind = True
        for index, labels in self._labels:
            is_of_kind &= values[index] != values[index] or values[index] in labels
        return values if is_of_kind else self._sensing.columns(self.body.sense(())).T[0].tolist()  # refuses

    def _compute_commands(self, basic: int) -> tuple[float, ...]:
        with np.errstate(all="ignore"):
            running, entered = np.array([basic]), np.array([self.interpreter.behavior_start_s])
            columns = self._acting.commands(running, self.body.sense(()), lambda: entered)
        return tuple(columns[:, 0].tolist())


@dataclass(frozen=True, slots=True)
class ConformanceTick:
    """One row: whether the behavior starts before it, the time (s or ms), the readings, and the expected answer."""

    starts: bool
    time: float
    readings: tuple[float, ...]
    expected: ReferenceTick


@dataclass(frozen=True, slots=True)
class Conformance:
    """All rows of a conformance file, and how much of the trees they reach.

    `leaves` and `boundaries` are pairs: how many were reached, of how many. `recorded` is the number of rows that come
    from lessons and runs, the first of all, and `from_runs` of those from runs.
    """

    ticks: tuple[ConformanceTick, ...]
    recorded: int
    leaves: tuple[int, int]
    boundaries: tuple[int, int]
    from_runs: int = 0


@dataclass(frozen=True, slots=True)
class ConformanceClock:
    """The clock of an exported behavior: seconds as a double, or milliseconds as a whole number of 32 bits."""

    tick_s: float
    is_ms: bool

    def list_times(self, random: Random) -> Iterator[tuple[float, float]]:
        """Yield the times of a walk with ticks that jitter: in s, and as the exported behavior reads them."""
        if self.is_ms:
            tick = max(1, round(self.tick_s * MS_PER_S))
            now = random.choice(CLOCKS_MS)
            while True:
                yield now / MS_PER_S, float(now % 2**32)
                now += random.choice((tick, tick, tick, max(1, tick // 2), 2 * tick))
        begin_s, passed = random.choice(CLOCKS_S), 0.0
        while True:
            time_s = begin_s + passed
            yield time_s, time_s
            passed += random.choice((1.0, 1.0, 1.0, 0.5, 7 / 3)) * self.tick_s

    def convert_times(self, times: Sequence[float]) -> Iterator[tuple[float, float]]:
        """Yield recorded times (s): in s, and as the exported behavior reads them."""
        for time_s in times:
            now = round(time_s * MS_PER_S)
            yield (now / MS_PER_S, float(now % 2**32)) if self.is_ms else (time_s, time_s)


def make_conformance(
    program: Program,
    hierarchy: Hierarchy,
    library: Library,
    *,
    single_precision: bool = False,
    runs: Sequence[Record] = (),
    seed: int = SEED,
) -> Conformance:
    """Make the rows of the conformance file of a program, also of the readings of recorded runs.

    Rows for which a Python function fails are left out, and the walk starts again.
    """
    random = Random(seed)
    reference = ReferenceRun(program, hierarchy, single_precision=single_precision)
    walker = ReadingWalk(hierarchy, random, single_precision=single_precision)
    reference.interpreter.observe_queries(
        lambda machine, state, _, values: walker.note(machine, state, values)
    )
    clock = ConformanceClock(hierarchy.tick_s, single_precision)
    recorder = _Recorder(reference, clock, random)
    convert = round_to_single if single_precision else float
    for rows in list_recorded_rows(hierarchy, library):
        recorder.follow(len(rows), (tuple(map(convert, row)) for row in rows).__next__)
    from_lessons = len(recorder.ticks)
    for times, rows in list_run_rows(hierarchy, runs):
        values = (tuple(map(convert, row)) for row in rows)
        recorder.follow(len(rows), values.__next__, clock.convert_times(times))
    recorded = len(recorder.ticks)
    most = min(MOST_TICKS, max(TICKS, MOST_QUESTIONS // max(1, walker.deepest)))
    enough = min(most, 20 * TICKS + 10 * len(walker.boundaries))
    while len(recorder.ticks) < recorded + enough and recorder.failures < MOST_TICKS:
        recorder.follow(TICKS, lambda: walker.advance(recorder.active))
    return Conformance(
        tuple(recorder.ticks),
        recorded,
        (len(walker.reached), len(walker.leaves)),
        (len(walker.boundaries) - sum(map(len, walker.waiting.values())), len(walker.boundaries)),
        recorded - from_lessons,
    )


class _Recorder:
    def __init__(self, reference: ReferenceRun, clock: ConformanceClock, random: Random) -> None:
        self.reference, self.clock, self.random = reference, clock, random
        self.ticks: list[ConformanceTick] = []
        self.failures, self.starts = 0, True

    @property
    def active(self) -> tuple[RunningAutomaton, ...]:
        """The automata that are active before the next tick, none before a start."""
        return () if self.starts else self.reference.interpreter.active

    def follow(
        self,
        ticks: int,
        take_row: Callable[[], tuple[float, ...]],
        times: Iterator[tuple[float, float]] | None = None,
    ) -> None:
        """Answer the rows of a walk, which starts again where a row cannot be answered."""
        times = times or self.clock.list_times(self.random)
        self.starts = True
        for _ in range(ticks):
            self.starts = not self.add(self.starts, next(times), take_row())

    def add(self, starts: bool, time: tuple[float, float], row: tuple[float, ...]) -> bool:
        now, read = time
        if starts:
            self.reference.start(now)
        try:
            expected = self.reference.pulse(row, now)
        except UnderstudyError:  # no run would have got further with these readings
            self.failures += 1
            return False
        self.ticks.append(ConformanceTick(starts, read, row, expected))
        return True


def list_recorded_rows(hierarchy: Hierarchy, library: Library) -> Iterator[list[list[float]]]:
    """Yield the readings of recorded lessons, of each automaton of a hierarchy: around presses, in order."""
    for name in dict.fromkeys(each.automaton for each in hierarchy.automata):
        lesson = library.taught[name].lesson
        if lesson is None:
            continue
        if len(lesson.record):
            yield _read_record(hierarchy, lesson)
    yield from _list_example_rows(hierarchy, library)


def list_run_rows(
    hierarchy: Hierarchy, runs: Sequence[Record]
) -> Iterator[tuple[list[float], list[list[float]]]]:
    """Yield the times (s) and readings of each episode of recorded runs; of long runs, pieces spread over them.

    Labels are those of the export; what a run does not have, or has as another kind, is absent.
    """
    for run in runs:
        sample = sample_record(run, most=MOST_RECORDED)
        columns = [_read_slot(sample, (slot.reading, slot.target), slot.kind) for slot in hierarchy.readings]
        rows = np.column_stack(columns) if columns else np.zeros((sample.ticks, 0))
        for episode in sample.episodes:
            yield sample.times[episode.ticks].tolist(), rows[episode.ticks].tolist()


def _read_slot(run: Record, key: ReadingKey, kind: Kind) -> Column:
    """Return the column of a reading in a run, with the labels of a kind."""
    absent = np.full(run.ticks, nan)
    if key not in run.values:
        return absent
    own = run.find_kind(key)
    if not isinstance(kind, Categorical) and not isinstance(own, Categorical):
        return run.values[key]
    if not isinstance(kind, Categorical) or not isinstance(own, Categorical):
        return absent
    numbers = [float(kind.labels.index(label)) if label in kind.labels else nan for label in own.labels]
    return np.array([nan if np.isnan(value) else numbers[int(value)] for value in run.values[key].tolist()])


def _read_record(hierarchy: Hierarchy, lesson: Lesson) -> list[list[float]]:
    keys = {key: index for index, key in enumerate(lesson.record.keys)}
    columns = [keys.get((slot.reading, slot.target)) for slot in hierarchy.readings]
    rows = sorted(
        {
            row
            for example in lesson.examples
            if example.moment is not None
            for row in range(example.moment - example.window, example.moment + 1)
        }
    )[:MOST_RECORDED]
    values = lesson.record.values
    return [
        [float("nan") if column is None else float(values[row, column]) for column in columns] for row in rows
    ]


def _list_example_rows(hierarchy: Hierarchy, library: Library) -> Iterator[list[list[float]]]:
    """Yield the values of examples, for each ground automaton, as rows of the readings that its features are."""
    for automaton in hierarchy.automata:
        lesson = library.taught[automaton.automaton].lesson
        rows = []
        for example in () if lesson is None else lesson.examples:
            if example.is_from_press and len(example.values) == len(automaton.features):
                row = [float("nan")] * len(hierarchy.readings)
                for source, value in zip(automaton.features, example.values, strict=True):
                    if source.sort == "reading":
                        row[source.index] = value
                rows.append(row)
        if rows:
            yield rows[:MOST_RECORDED]


def _write_number(value: float) -> str:
    """Write a number as all languages of the targets read it; "inf" is no number in JavaScript."""
    return repr(value).replace("inf", "Infinity")


def format_conformance(
    conformance: Conformance, hierarchy: Hierarchy, names: Mapping[str, Mapping[str, str]]
) -> bytes:
    """Format a conformance file, with the identifiers of a target for readings and channels, where it has some."""
    labels = [isinstance(slot.kind, Categorical) for slot in hierarchy.readings]
    readings = [names.get("readings", {}).get(str(slot), str(slot)) for slot in hierarchy.readings]
    channels = [names.get("channels", {}).get(each.name, each.name) for each in hierarchy.channels]
    columns = ("starts", "time", *readings, "path", "flags", "basic", *channels)
    lines = [",".join(" ".join(each.replace(",", ";").split()) for each in columns)]
    for tick in conformance.ticks:
        values = [
            "" if value != value else str(int(value)) if label else _write_number(value)
            for value, label in zip(tick.readings, labels, strict=True)
        ]
        expected = tick.expected
        time = str(int(tick.time)) if tick.time == int(tick.time) else repr(tick.time)
        path = ".".join(map(str, expected.path))
        flags = ".".join(str(flag + 1) for flag in expected.flags)
        commands = map(repr, expected.commands)
        lines.append(
            ",".join((str(int(tick.starts)), time, *values, path, flags, str(expected.basic), *commands))
        )
    return ("\n".join(lines) + "\n").encode()
