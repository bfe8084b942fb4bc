"""Examples from segmented drives: a session over the recorded readings, with a press at each switch of the labels.

Directives, defaults and watched examples then mean the same as in any session (docs/semantics.md). Switches in doubt go
into quarantine.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from understudy.addons.recordings.drive_kit import remove_functions
from understudy.addons.recordings.segment import UNEXPLAINED, Segmentation, Span
from understudy.model.automaton import START
from understudy.model.example_source import ExampleSource
from understudy.model.features import CounterFeature, FlagFeature, TimerFeature
from understudy.model.learner_options import LONGEST_REACTION_S
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Library
from understudy.records.record import Episode, Record, fill_readings, select_episode
from understudy.records.replay import ReplayBody
from understudy.training.example_index import make_example_key
from understudy.training.feature_values import (
    compute_example_values,
    find_shifted_row,
    list_steady_readings,
)
from understudy.training.session import Session

DOUBT = 0.8
"""The certainty of a span below which the switch to it and the switch from it are left out of learning."""
SURE = 0.9
"""The certainty of a tick below which it does not become a watched example."""


def make_drive_examples(segmentation: Segmentation, library: Library, empty: Lesson) -> Lesson:
    """Add the examples of all episodes to an empty lesson."""
    lesson, ticks = _teach(segmentation, library, empty)
    if not lesson.options.watched:
        return lesson
    steady = list_drive_steady_readings(segmentation.drive)
    return _doubt_rare_switches(_add_last_stays(segmentation, lesson, ticks, steady))


def _teach(segmentation: Segmentation, library: Library, lesson: Lesson) -> tuple[Lesson, dict[int, int]]:
    """Add the examples of all episodes to a lesson; return it, and the tick of each example by its number."""
    ticks: dict[int, int] = {}
    bare = remove_functions(library)
    for episode in segmentation.drive.episodes:
        for spans in _list_pieces(segmentation, episode):
            begins = _begins_episode(segmentation, episode, spans[0].first)
            taught_spans = spans[1:] if begins and _is_before_motion(segmentation, spans) else spans
            lesson = _teach_piece(segmentation, bare, lesson, taught_spans, ticks, begins=begins)
    return lesson, ticks


def name_state(label: str) -> str:
    """Return the name of the state that a label becomes: goto_ball for "goto(ball)"."""
    name = label.replace("(", "_").replace(")", "").replace(",", "_").replace(" ", "").replace("=", "_")
    return f"{name}_" if name == START.name else name


def _list_pieces(segmentation: Segmentation, episode: Episode) -> Iterator[list[Span]]:
    """Yield the spans of an episode in pieces, which are parted by ticks that nothing explains."""
    piece: list[Span] = []
    for span in segmentation.list_spans(episode):
        if span.label != UNEXPLAINED:
            piece.append(span)
        elif piece:
            yield piece
            piece = []
    if piece:
        yield piece


def _begins_episode(segmentation: Segmentation, episode: Episode, first: int) -> bool:
    """Return whether the driver begins with the first explained tick of an episode.

    Before it there may be a short time that nothing explains: a rest, and the first ticks in which the stick moves.
    """
    drive = segmentation.drive
    if first == episode.first:
        return True
    is_soon = (first - episode.first) * drive.tick_s <= LONGEST_REACTION_S
    return is_soon and _is_short_rest(segmentation, episode.first, episode.first + 1)


def _is_before_motion(segmentation: Segmentation, spans: Sequence[Span]) -> bool:
    """Return whether the first of several spans is a short rest, in which the driver had not begun."""
    return len(spans) > 1 and _is_short_rest(segmentation, spans[0].first, spans[0].end)


def _is_short_rest(segmentation: Segmentation, first: int, end: int) -> bool:
    """Return whether the driver gave no command from one tick to another, no longer than a late reaction takes."""
    drive = segmentation.drive
    if (end - first) * drive.tick_s > LONGEST_REACTION_S:
        return False
    away = drive.commands[first:end] - [each.rest for each in drive.channels]
    return bool((np.abs(away) <= 4 * segmentation.driver.noise).all())


def _teach_piece(
    segmentation: Segmentation,
    library: Library,
    lesson: Lesson,
    spans: Sequence[Span],
    ticks: dict[int, int],
    *,
    begins: bool,
) -> Lesson:
    """Add the examples of spans in a row, which may begin an episode, to a lesson, and note their ticks."""
    drive = segmentation.drive
    episode = drive.find_episode(spans[0].first)
    first, end = spans[0].first, spans[-1].end
    body = make_replay(drive, Episode(episode.source, first, end))
    session = Session(body, library, lesson)
    session.train()
    starts = {span.first: span for span in spans}
    for tick in range(first, end):
        if tick in starts:
            session.direct(name_state(starts[tick].label))
        session.tick()
    taught = session.lesson
    numbers = {each.number for each in lesson.examples}
    examples = []
    for example in taught.examples:
        if example.number in numbers:
            examples.append(example)
            continue
        # Pressing start is no decision of a driver who was driving already.
        if example.state == START.name and not begins:
            continue
        moment = float(taught.record.seconds[example.moment or 0])
        tick = first + int(np.searchsorted(drive.times[first:end], moment - 1e-9))
        certainty = _measure_certainty(segmentation, example, spans, tick)
        if example.kind is ExampleKind.WATCHED and certainty < SURE:
            continue
        reason = ""
        if certainty < DOUBT and example.kind is ExampleKind.DIRECTIVE:
            reason = f"the recording leaves this switch in doubt (certainty {certainty:.2f})"
        ticks[example.number] = tick
        source = _make_source(episode, moment, certainty)
        examples.append(replace(example, quarantined=reason, source=source))
    return replace(taught, examples=tuple(examples))


def _make_source(episode: Episode, time_s: float, certainty: float) -> ExampleSource:
    """Make the source of an example; more than four digits of a certainty would only make files longer."""
    return ExampleSource(Path(episode.source).name, time_s, certainty=round(certainty, 4))


def _measure_certainty(
    segmentation: Segmentation, example: Example, spans: Sequence[Span], tick: int
) -> float:
    """Return how certain an example is: of a switch, the less certain of the two spans that it parts."""
    if example.kind is ExampleKind.WATCHED:
        return _find_certainty(segmentation, tick)
    at = bisect_right(spans, tick, key=lambda span: span.first) - 1
    sides = spans[max(0, at - 1) : at + 1] if example.kind is ExampleKind.DIRECTIVE else spans[at : at + 1]
    return min(float(segmentation.list_certainties(span.first, span.end).max()) for span in sides)


def _find_certainty(segmentation: Segmentation, tick: int) -> float:
    return float(segmentation.posteriors[tick, segmentation.labels[tick]])


def _add_last_stays(
    segmentation: Segmentation, lesson: Lesson, ticks: Mapping[int, int], steady: frozenset[str]
) -> Lesson:
    """Add the last tick before each switch that is sure, as a watched example.

    A session discards the ticks before a press, in which a demonstrator may have been deciding. The labels of a drive
    say that the former behavior went on in them. Where all features are as at the switch, it says nothing: after an
    event, such as the last unit of food, the driver was late.
    """
    own = (FlagFeature, CounterFeature, TimerFeature)
    if any(isinstance(each.feature, own) for each in lesson.automaton.features):
        return lesson
    record, added = lesson.record, []
    number = max((each.number for each in lesson.examples), default=0)
    for example in lesson.examples:
        if example.kind is not ExampleKind.DIRECTIVE or example.state == START.name or example.quarantined:
            continue
        shifted = find_shifted_row(example, record, lesson.options.reaction_s)
        moment = example.moment or 0
        for row in range(shifted - 1, moment - example.window - 1, -1):
            tick = ticks[example.number] - (moment - row)
            stayed_s = example.own.get("time_in_state", 0.0) - float(
                record.seconds[moment] - record.seconds[row]
            )
            if stayed_s <= 0:
                break
            certainty = _find_certainty(segmentation, tick)
            if certainty < SURE:
                continue
            source = _make_source(
                segmentation.drive.find_episode(tick),
                float(record.seconds[row]),
                certainty,
            )
            stay = replace(
                example, next=example.state, kind=ExampleKind.WATCHED, moment=row, window=0,
                own={**example.own, "time_in_state": stayed_s}, source=source,
            )  # fmt: skip
            values = compute_example_values(stay, lesson, record, steady=steady)
            if make_example_key(replace(stay, values=values)) == make_example_key(example):
                continue
            number += 1
            added.append(replace(stay, number=number, values=values))
            break
    return replace(lesson, examples=(*lesson.examples, *added))


def _doubt_rare_switches(lesson: Lesson) -> Lesson:
    """Put switches into quarantine where the driver mostly went on at the very same values, and their defaults, too.

    A press is meant; the label of a tick may be wrong by one.
    """
    used = [each for each in lesson.examples if not each.quarantined]
    stays = Counter(make_example_key(each) for each in used if each.kind is ExampleKind.WATCHED)
    switches = Counter(make_example_key(each) for each in used if each.kind is ExampleKind.DIRECTIVE)
    reasons = {}
    for each in used:
        key = make_example_key(each)
        if each.kind is ExampleKind.DIRECTIVE and stays[key] > switches[key]:
            reasons[each.moment, each.next] = (
                f"at the same values, the driver went on {stays[key]} times, and switched {switches[key]} times"
            )
    return replace(
        lesson,
        examples=tuple(
            replace(each, quarantined=reasons.get((each.moment, each.next), each.quarantined))
            if each.kind in (ExampleKind.DIRECTIVE, ExampleKind.DEFAULT)
            else each
            for each in lesson.examples
        ),
    )


def make_replay(drive: Record, episode: Episode) -> ReplayBody:
    """Make a body that replays the readings of an episode; readings that a drive lacks are absent."""
    return ReplayBody([fill_readings(select_episode(drive, episode))])


def list_drive_steady_readings(drive: Record) -> frozenset[str]:
    """List the readings of a drive that a reaction time never shifts."""
    return list_steady_readings(make_replay(drive, drive.episodes[0]))
