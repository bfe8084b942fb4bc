"""A taught behavior judged beside the yardstick."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from tests.cli.forage_parts import AUTOMATA

from understudy.errors import SettingError, UnboundParameter, UnknownName
from understudy.evaluation import LENIENCE, evaluate
from understudy.model.automaton import Automaton
from understudy.model.library import Library
from understudy.worlds.catalog import CATALOG
from understudy.worlds.forage import Forage, ForageSettings

FORAGE = CATALOG["forage"]
LIBRARY = Library.of(FORAGE.kit, *AUTOMATA)


def test_side_by_side_as_one_by_one() -> None:
    together = evaluate(LIBRARY, "forage", FORAGE, range(5, 9))
    alone = [evaluate(LIBRARY, "forage", FORAGE, [seed]) for seed in range(5, 9)]
    assert together.taught.seconds.tolist() == [each.taught.seconds[0] for each in alone]
    assert together.expert.seconds.tolist() == [each.expert.seconds[0] for each in alone]
    assert together.relative_to_expert == np.median([each.relative_to_expert for each in alone])
    assert together.success == 1.0


def test_who_does_nothing_fails_at_three_times_the_yardstick() -> None:
    library = Library.of(FORAGE.kit, Automaton("lazy"))
    judged = evaluate(library, "lazy", FORAGE, range(3))
    assert (judged.success, judged.relative_to_expert) == (0.0, 0.0)
    assert judged.taught.limit_s.tolist() == (LENIENCE * judged.expert.seconds).tolist()


def test_progress_reaches_the_end() -> None:
    calls: list[tuple[int, int]] = []
    evaluate(LIBRARY, "forage", FORAGE, range(3), progress=lambda done, total: calls.append((done, total)))
    assert calls[0] == (0, 3)
    assert calls[-1] == (3, 3)
    assert [done for done, _ in calls] == sorted(done for done, _ in calls)


def test_worlds_with_other_settings() -> None:
    small = replace(FORAGE, make=partial(Forage, settings=ForageSettings(capacity=3)))
    assert evaluate(LIBRARY, "forage", small, range(2)).expert.seconds.min() > 0


def test_a_world_by_name() -> None:
    with pytest.raises(UnknownName, match="no world 'moon'; it has forage"):
        evaluate(LIBRARY, "forage", "moon", [1])


def test_parameters_are_bound() -> None:
    evaluate(LIBRARY, "goto", FORAGE, [0], binding={"A": "station"})
    with pytest.raises(UnboundParameter, match="bind it to one of the targets"):
        evaluate(LIBRARY, "goto", FORAGE, [0])
    with pytest.raises(SettingError, match="seeds"):
        evaluate(LIBRARY, "forage", FORAGE, [])
