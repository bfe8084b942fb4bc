"""The ties between the statistics that a coordinator senses: any, all and none of a condition, counts and extremes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import permutations
from math import inf, nextafter

from understudy.addons.checks.verification.scenario_ties import DOWN, UP, list_bound_features
from understudy.addons.checks.verification.ties import Tie, make_presence_tie, make_range_tie
from understudy.model.features import BoundFeature, Feature
from understudy.model.kinds import Toroidal
from understudy.model.library import Library
from understudy.model.squad import YES_OR_NO, Squad, Statistic
from understudy.sim.scenario.schema import Scenario


def list_squad_ties(squad: Squad, library: Library, scenario: Scenario) -> list[Tie]:
    """List the ties between the features of coordinators, which follow from the definitions of their statistics.

    Parameters
    ----------
    squad
        The squad, with its statistics.
    library
        The library of its coordinators.
    scenario
        The scenario, whose targets features may be bound to.

    Returns
    -------
    list[Tie]
        The ties.
    """
    statistics = {each.name: each for each in squad.statistics}
    features = [
        (bound, statistics[bound.feature.reading])
        for bound in list_bound_features(library, scenario.targets)
        if isinstance(bound.feature, Feature) and bound.feature.reading in statistics
    ]
    ties: list[Tie] = []
    for bound, statistic in features:
        ties += _list_single(bound, statistic)
    for (first, one), (second, other) in permutations(features, 2):
        if dict(first.binding) == dict(second.binding):
            ties += _list_pairs(first, one, second, other)
    return ties


def _list_single(bound: BoundFeature, statistic: Statistic) -> Iterator[Tie]:
    if statistic.how in YES_OR_NO and not statistic.since:
        yield make_presence_tie(bound, f"{bound} is never absent")
    if statistic.how == "fraction":
        yield make_range_tie(bound, 0.0, nextafter(1.0, inf), f"{bound} is at least 0 and at most 1")
    if statistic.how in ("count", "spread") or statistic.since:
        yield make_range_tie(bound, 0.0, inf, f"{bound} is at least 0")


def _list_pairs(first: BoundFeature, one: Statistic, second: BoundFeature, other: Statistic) -> Iterator[Tie]:
    """Yield the ties between two statistics of the same members and the same condition."""
    if one.reading is None and one.flag is None:
        return
    if _is_told(one, other) and _get_condition(one) == _get_condition(other):
        if (one.how, other.how) == ("all", "any"):
            yield Tie(f"{first} is yes only while {second} is yes", {first: UP, second: DOWN})
        if (one.how, other.how) == ("any", "none"):
            sentence = f"{first} is yes exactly while {second} is no"
            yield Tie(sentence, {first: UP, second: UP})
            yield Tie(sentence, {first: DOWN, second: DOWN})
    is_recent = one.how == other.how == "any" and not one.is_timed and other.within_s is not None
    if is_recent and one.flag is None and _get_condition(one) == _get_condition(other):
        yield Tie(f"{first} is yes only while {second} is yes", {first: UP, second: DOWN})
    order = ("minimum", "mean", "maximum")
    alike = one.how in order and other.how in order and not one.is_timed and not other.is_timed
    same = (one.reading, one.role) == (other.reading, other.role)
    if alike and same and order.index(one.how) < order.index(other.how) and not _is_angle(first):
        yield Tie(f"{first} is at most {second}", {}, ((first, 1.0), (second, -1.0)), 0.0)


def _get_condition(statistic: Statistic) -> Statistic:
    """Return a statistic that is equal for all statistics of the same condition, now or lately."""
    return replace(statistic, name="", doc="", how="any", within_s=None)


def _is_told(one: Statistic, other: Statistic) -> bool:
    return one.how in YES_OR_NO and other.how in YES_OR_NO and not one.is_timed and not other.is_timed


def _is_angle(bound: BoundFeature) -> bool:
    return isinstance(bound.kind, Toroidal)
